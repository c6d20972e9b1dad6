//! Axes: from a value to a place on paper, and the ticks that say so.

use super::error::{FigureError, require_finite, require_limits};
use super::text::{fixed, number};

/// Whether equal lengths are equal differences or equal ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios; values must be above zero.
    Log,
}

impl Scale {
    /// The number that grows evenly along this scale.
    pub(super) fn measure(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.log10(),
        }
    }
}

/// One axis of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, e.g. "force, N".
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Ends of the axis; taken from the data when absent.
    pub limits: Option<[f64; 2]>,
    /// Values to mark; chosen when absent.
    pub ticks: Option<Vec<f64>>,
}

impl Axis {
    /// A linear axis that takes its limits from the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, limits: None, ticks: None }
    }

    /// A logarithmic axis that takes its limits from the data.
    pub fn log(label: impl Into<String>) -> Self {
        Self { scale: Scale::Log, ..Self::linear(label) }
    }

    /// The same axis with fixed ends.
    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.limits = Some([low, high]);
        self
    }

    /// The same axis marked at these values.
    pub fn with_ticks(mut self, ticks: Vec<f64>) -> Self {
        self.ticks = Some(ticks);
        self
    }

    /// Ends of the axis: those asked for, or round numbers just beyond the data.
    pub(super) fn span(&self, data: &[f64]) -> Result<[f64; 2], FigureError> {
        require_finite(&self.label, data)?;
        let given = self.limits.into_iter().flatten();
        let lowest = data.iter().copied().chain(given).fold(f64::INFINITY, f64::min);
        if self.scale == Scale::Log && lowest <= 0.0 {
            let what = self.label.clone();
            return Err(FigureError::NotPositive { what });
        }
        if let Some(limits) = self.limits {
            require_limits(&self.label, limits)?;
            return Ok(limits);
        }
        let highest = data.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if lowest > highest {
            let what = self.label.clone();
            return Err(FigureError::Empty { what });
        }
        Ok(match self.scale {
            Scale::Linear => round_out(lowest, highest),
            Scale::Log => round_out_log(lowest, highest),
        })
    }

    /// The ticks within the span, at most `most` of them where they are not given.
    pub(super) fn marks(&self, span: [f64; 2], most: usize) -> Vec<Tick> {
        let slack = (span[1] - span[0]) * 1e-9;
        match &self.ticks {
            Some(values) => values
                .iter()
                .filter(|value| **value >= span[0] - slack && **value <= span[1] + slack)
                .map(|value| Tick::new(*value, number(*value)))
                .collect(),
            None => ticks(self.scale, span, most),
        }
    }
}

/// A marked value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) label: String,
}

impl Tick {
    fn new(value: f64, label: String) -> Self {
        Self { value, label }
    }
}

/// Maps values of a span to pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ruler {
    scale: Scale,
    span: [f64; 2],
    pixels: [f64; 2],
}

impl Ruler {
    /// The span's ends come to lie on the two pixel places.
    pub(super) fn new(scale: Scale, span: [f64; 2], pixels: [f64; 2]) -> Self {
        Self { scale, span, pixels }
    }

    /// Where a value lies, in pixels.
    pub(super) fn place(&self, value: f64) -> f64 {
        let [low, high] = self.span.map(|end| self.scale.measure(end));
        let part = (self.scale.measure(value) - low) / (high - low);
        self.pixels[0] + part * (self.pixels[1] - self.pixels[0])
    }
}

/// Round values within the span, at most `most` (and at least two where the span allows).
pub(super) fn ticks(scale: Scale, span: [f64; 2], most: usize) -> Vec<Tick> {
    let decades = (span[1] / span[0]).log10();
    match scale {
        Scale::Log if decades >= 1.0 => log_ticks(span, decades, most),
        // Less than a decade holds too few round powers: mark it like a linear one.
        _ => linear_ticks(span, most),
    }
}

fn linear_ticks([low, high]: [f64; 2], most: usize) -> Vec<Tick> {
    let step = round_step((high - low) / most.max(1) as f64);
    let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let count = (last - first) as usize + 1;
    (0..count.min(most + 2))
        .map(|i| (first + i as f64) * step)
        .map(|value| Tick::new(value, fixed(value, decimals)))
        .collect()
}

fn log_ticks([low, high]: [f64; 2], decades: f64, most: usize) -> Vec<Tick> {
    let factors: &[f64] = if 3.0 * decades <= most as f64 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let stride = (decades / most.max(1) as f64).ceil().max(1.0) as i32;
    let first = low.log10().floor() as i32;
    let last = high.log10().ceil() as i32;
    (first..=last)
        .filter(|power| power.rem_euclid(stride) == 0)
        .flat_map(|power| factors.iter().map(move |factor| factor * 10f64.powi(power)))
        .filter(|value| *value >= low * (1.0 - 1e-9) && *value <= high * (1.0 + 1e-9))
        .map(|value| Tick::new(value, number(value)))
        .collect()
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0]
        .iter()
        .map(|factor| factor * power)
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

fn round_out(low: f64, high: f64) -> [f64; 2] {
    if low == high {
        // A single value: room on both sides of it, in its own order of size.
        let room = if low == 0.0 { 1.0 } else { low.abs() * 0.5 };
        return [low - room, high + room];
    }
    let step = round_step((high - low) / 8.0);
    [(low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step]
}

fn round_out_log(low: f64, high: f64) -> [f64; 2] {
    let power = |value: f64| 10f64.powf(value.log10().floor());
    let factors = [1.0, 2.0, 5.0, 10.0];
    let below = |value: f64| {
        let fits = |factor: &&f64| **factor * power(value) <= value * (1.0 + 1e-9);
        factors.iter().rev().find(fits).unwrap_or(&1.0) * power(value)
    };
    let above = |value: f64| {
        let fits = |factor: &&f64| **factor * power(value) >= value * (1.0 - 1e-9);
        factors.iter().find(fits).unwrap_or(&10.0) * power(value)
    };
    let (low, high) = (below(low), above(high));
    if low < high { [low, high] } else { [low / 2.0, high * 2.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_and_within_the_span() {
        assert_eq!(labels(&ticks(Scale::Linear, [-60.0, 60.0], 8)), ["−60", "−40", "−20", "0", "20", "40", "60"]);
        assert_eq!(labels(&ticks(Scale::Linear, [0.0, 0.5], 6)), ["0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(labels(&ticks(Scale::Log, [0.01, 100.0], 6)), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(&ticks(Scale::Log, [1.0, 20.0], 6)), ["1", "2", "5", "10", "20"]);
    }

    #[test]
    fn a_ruler_puts_the_middle_of_a_log_span_at_its_geometric_mean() {
        let ruler = Ruler::new(Scale::Log, [0.1, 10.0], [200.0, 0.0]);
        assert!((ruler.place(1.0) - 100.0).abs() < 1e-9);
        assert!((ruler.place(10.0)).abs() < 1e-9);
    }

    #[test]
    fn the_span_holds_the_data_and_refuses_what_has_no_place() {
        let [low, high] = Axis::linear("y").span(&[0.3, 9.7]).unwrap();
        assert!(low <= 0.3 && high >= 9.7 && low >= -2.0 && high <= 12.0);
        let [low, high] = Axis::log("y").span(&[0.3, 70.0]).unwrap();
        assert!((low - 0.2).abs() < 1e-12 && (high - 100.0).abs() < 1e-9);
        assert!(Axis::log("y").span(&[0.0, 1.0]).is_err());
        assert!(Axis::linear("y").span(&[f64::NAN]).is_err());
        assert!(Axis::linear("y").span(&[]).is_err());
    }
}
