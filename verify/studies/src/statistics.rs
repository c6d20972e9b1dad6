//! Summary statistics: means, medians, percentiles and spans.

/// Arithmetic mean, in the unit of the figures; `None` without figures.
pub fn mean(figures: impl IntoIterator<Item = f64>) -> Option<f64> {
    let figures: Vec<f64> = figures.into_iter().collect();
    (!figures.is_empty()).then(|| figures.iter().sum::<f64>() / figures.len() as f64)
}

/// Root mean square, in the unit of the figures; `None` without figures.
pub fn rms(figures: impl IntoIterator<Item = f64>) -> Option<f64> {
    mean(figures.into_iter().map(|x| x * x)).map(f64::sqrt)
}

/// Median, in the unit of the figures; `None` without figures. For an even number of figures: the mean of the two middle figures.
pub fn median(figures: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = figures.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len() % 2 == 1 { upper } else { (sorted[middle - 1] + upper) / 2.0 })
}

/// Mean, least and greatest of some figures, in their unit.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Span {
    /// Arithmetic mean, in the unit of the figures.
    pub mean: f64,
    /// Least figure, in the unit of the figures.
    pub least: f64,
    /// Greatest figure, in the unit of the figures.
    pub greatest: f64,
}

impl Span {
    /// Span of some figures; `None` without figures.
    pub fn of(figures: impl IntoIterator<Item = f64>) -> Option<Span> {
        let figures: Vec<f64> = figures.into_iter().collect();
        let least = figures.iter().copied().reduce(f64::min)?;
        let greatest = figures.iter().copied().fold(least, f64::max);
        Some(Span { mean: mean(figures)?, least, greatest })
    }

    /// Least and greatest figure, in this order.
    pub fn ends(self) -> [f64; 2] {
        [self.least, self.greatest]
    }
}
