//! Charts: series over a common quantity, bars in groups, and values to compare them with.

use super::axis::{Axis, Scale};
use super::bars::{Bars, Writing};
use super::colour::{Hue, TEXT};
use super::error::{FigureError, require, require_finite, require_len};
use super::geometry::{Area, Point};
use super::labels::{Label, Obstacles};
use super::legend::Entry;
use super::marks::Marker;
use super::panels::{Frame, Panels, Plot};
use super::sheet::{Dash, Pen, SPACE, Sheet, TICK_TEXT, Words};
use super::text::{widest, wrap};

/// Series and bars over the same two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Heading, description and size.
    pub frame: Frame,
    /// The level axis; of categories for bars.
    pub x: Axis,
    /// The upright axis.
    pub y: Axis,
    /// The series.
    pub series: Vec<Series>,
    /// Bars side by side in each category, which begin at zero.
    pub bars: Vec<Bars>,
    /// Values on the upright axis to compare with, and their words, e.g. "10 %".
    pub references: Vec<(f64, String)>,
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Words in the legend; a series without is not listed.
    pub label: String,
    /// The points, in the order they are joined in.
    pub points: Vec<Point>,
    /// Colour.
    pub hue: Hue,
    /// How the joining line is broken; none leaves the points unjoined.
    pub dash: Option<Dash>,
    /// Sign at each point.
    pub marker: Option<Marker>,
    /// How far the value may be off, at each point.
    pub spread: Spread,
    /// Words at each point, or none at all.
    pub labels: Vec<String>,
}

/// Uncertainty of a series: lower and upper ends, one pair a point.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Spread {
    /// Not known.
    #[default]
    None,
    /// An upright stroke at each point.
    Bars(Vec<[f64; 2]>),
    /// A shaded band along the series.
    Band(Vec<[f64; 2]>),
}

impl Series {
    /// The n-th series of a chart: joined points with signs, in the n-th colour.
    pub fn nth(n: usize, label: impl Into<String>, points: Vec<Point>) -> Self {
        Self {
            label: label.into(),
            points,
            hue: Hue::nth(n),
            dash: Some(Dash::Solid),
            marker: Some(Marker::nth(n)),
            spread: Spread::None,
            labels: Vec::new(),
        }
    }

    /// A dotted line without signs, to compare with.
    pub fn guide(label: impl Into<String>, points: Vec<Point>) -> Self {
        Self { hue: Hue::Neutral, dash: Some(Dash::Dotted), marker: None, ..Self::nth(0, label, points) }
    }

    fn ends(&self) -> &[[f64; 2]] {
        match &self.spread {
            Spread::None => &[],
            Spread::Bars(ends) | Spread::Band(ends) => ends,
        }
    }

    fn check(&self) -> Result<(), FigureError> {
        require(!self.points.is_empty(), FigureError::Empty, &self.label)?;
        require_finite(&self.label, self.points.iter().chain(self.ends()).flatten())?;
        if self.spread != Spread::None {
            require_len(&self.label, self.ends(), self.points.len())?;
        }
        if self.labels.is_empty() { Ok(()) } else { require_len(&self.label, &self.labels, self.points.len()) }
    }

    fn pen(&self) -> Option<Pen> {
        self.dash.map(|dash| Pen::new(self.hue.ink(), 2.6).dashed(dash))
    }

    /// A band below, then the line, then error bars and signs.
    fn draw(&self, sheet: &Sheet, plot: &Plot) -> Result<(), FigureError> {
        let (points, ink) = (plot.line(&self.points), self.hue.ink());
        let edge = |side: usize| -> Vec<Point> {
            self.points.iter().zip(self.ends()).map(|(point, ends)| plot.at([point[0], ends[side]])).collect()
        };
        let (low, high) = (edge(0), edge(1));
        if matches!(self.spread, Spread::Band(_)) {
            sheet.polygon(&low.iter().chain(high.iter().rev()).copied().collect::<Vec<_>>(), ink, 0.2)?;
        }
        if let Some(pen) = self.pen() {
            sheet.line(&points, pen)?;
        }
        if matches!(self.spread, Spread::Bars(_)) {
            let pen = Pen::new(ink, 1.6);
            for (low, high) in low.into_iter().zip(high) {
                sheet.line(&[low, high], pen)?;
                [low, high].iter().try_for_each(|[x, y]| sheet.line(&[[x - 5.0, *y], [x + 5.0, *y]], pen))?;
            }
        }
        self.marker.map_or(Ok(()), |marker| points.iter().try_for_each(|point| marker.draw(sheet, *point, ink)))
    }

    fn entry(&self) -> Entry<'_> {
        Entry::new(&self.label, |sheet, area| {
            let [left, right] = [area.left, area.right].map(|x| [x, area.centre()[1]]);
            self.pen().map_or(Ok(()), |pen| sheet.line(&[left, right], pen))?;
            self.marker.map_or(Ok(()), |marker| marker.draw(sheet, area.centre(), self.hue.ink()))
        })
    }
}

impl Chart {
    /// A chart of series alone.
    pub fn new(frame: Frame, [x, y]: [Axis; 2], series: Vec<Series>) -> Self {
        Self { frame, x, y, series, bars: Vec::new(), references: Vec::new() }
    }

    /// A chart of bars over named categories.
    pub fn of_bars(frame: Frame, axes: [Axis; 2], bars: Vec<Bars>) -> Self {
        Self { bars, ..Self::new(frame, axes, Vec::new()) }
    }

    /// The same chart with values to compare with, and their words.
    pub fn compared(self, references: impl IntoIterator<Item = (f64, String)>) -> Self {
        Self { references: references.into_iter().collect(), ..self }
    }

    /// The chart as SVG.
    ///
    /// # Errors
    /// [`FigureError`] if there is nothing to draw, or the numbers have no position on the axes.
    pub fn svg(&self) -> Result<String, FigureError> {
        require(!self.series.is_empty() || !self.bars.is_empty(), FigureError::Empty, "chart")?;
        self.series.iter().try_for_each(Series::check)?;
        self.bars.iter().try_for_each(|bars| bars.check(&self.x))?;
        let points = || self.series.iter().flat_map(|series| &series.points);
        let ends = self.series.iter().flat_map(Series::ends).flatten().copied();
        // On a logarithmic axis a lower end at or below zero ends at its foot.
        let ends = ends.filter(|end| self.y.scale == Scale::Linear || *end > 0.0);
        let of_bars = self.bars.iter().flat_map(Bars::heights);
        let up =
            points().map(|point| point[1]).chain(ends).chain(of_bars).chain(self.references.iter().map(|line| line.0));
        let words: Vec<(f64, Vec<String>)> = self
            .references
            .iter()
            .map(|(value, label)| (*value, wrap(label, TICK_TEXT, self.frame.width * 0.2)))
            .collect();
        let right = widest(words.iter().flat_map(|words| &words.1), TICK_TEXT) + 2.0 * SPACE;
        let mut panels = Panels::new(&self.frame, [&self.x, &self.y]);
        panels.data = [points().map(|point| point[0]).collect(), up.collect()];
        panels.sides[1] = right.max(3.0 * SPACE);
        panels.legend = self.bars.iter().map(Bars::entry).chain(self.series.iter().map(Series::entry)).collect();
        let writing = Writing::of(&self.bars, &self.x, self.frame.width - panels.sides[1] - 50.0);
        panels.head = writing.height;
        panels.draw(|sheet, plots, _| {
            let plot = &plots[0];
            self.bars.iter().enumerate().try_for_each(|(nth, bars)| bars.draw(sheet, plot, [nth, self.bars.len()]))?;
            draw_references(sheet, plot, words)?;
            self.bars
                .iter()
                .enumerate()
                .try_for_each(|(nth, bars)| writing.write(sheet, plot, bars, [nth, self.bars.len()]))?;
            self.series.iter().try_for_each(|series| series.draw(sheet, plot))?;
            self.draw_labels(sheet, plot)
        })
    }

    /// Writes the words at points where they hide neither lines nor points nor each other.
    fn draw_labels(&self, sheet: &Sheet, plot: &Plot) -> Result<(), FigureError> {
        let joined = self.series.iter().filter(|series| series.dash.is_some());
        let marks = self.series.iter().flat_map(|series| plot.line(&series.points));
        let labels = self.series.iter().flat_map(|series| plot.line(&series.points).into_iter().zip(&series.labels));
        let labels: Vec<Label> =
            labels.map(|(anchor, text)| Label { text: text.clone(), anchor, side: [0.7, -0.7] }).collect();
        let lines = joined.map(|series| plot.line(&series.points)).collect();
        let areas = marks.map(|at| Area::about(at, 12.0, 12.0)).collect();
        Obstacles { lines, areas, within: plot.area }.write(sheet, &labels)
    }
}

/// Draws level lines, and their words right of the plot: from the top, those that would touch the ones above move down.
fn draw_references(sheet: &Sheet, plot: &Plot, words: Vec<(f64, Vec<String>)>) -> Result<(), FigureError> {
    const LINE: f64 = TICK_TEXT * 1.2;
    let Area { left, right, .. } = plot.area;
    let mut shown: Vec<_> = words.into_iter().map(|(value, lines)| (plot.at([0.0, value])[1], lines)).collect();
    shown.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = f64::NEG_INFINITY;
    for (y, lines) in shown {
        sheet.line(&[[left, y], [right, y]], Pen::new(TEXT, 1.6).faint(0.75).dashed(Dash::Dashed))?;
        let first = (y - (lines.len() as f64 - 1.0) * LINE / 2.0).max(free);
        for (index, line) in lines.iter().enumerate() {
            sheet.words(Words::new(line, [right + SPACE, first + index as f64 * LINE]).left())?;
        }
        free = first + lines.len() as f64 * LINE;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> Chart {
        let points = vec![[1.0, 0.5], [2.0, 3.0], [3.0, 40.0]];
        let series = vec![Series::nth(0, "linear", points.clone()), Series::nth(1, "co-rotational", points)];
        let frame = Frame::half("Error over force", "error over force");
        Chart::new(frame, [Axis::linear("force, N"), Axis::log("error, %")], series)
            .compared([(10.0, "10 %".to_owned())])
    }

    #[test]
    fn every_series_has_its_line_its_markers_and_its_words() {
        let mut chart = chart();
        chart.series[0].labels = ["first", "second", "third"].map(str::to_owned).into();
        let svg = chart.svg().unwrap();
        // Three points and the legend's sample; the line and the legend's.
        assert_eq!(svg.matches("fill=\"#1f82c4\"").count(), 4);
        assert_eq!(svg.matches("stroke=\"#d55e00\"").count(), 2);
        assert!(["10 %", "first", "second", "third", "linear"].iter().all(|words| svg.contains(&format!(">{words}<"))));
    }

    #[test]
    fn a_spread_reaching_zero_on_a_log_axis_is_cut_at_its_foot() {
        let mut chart = chart();
        for spread in [Spread::Bars, Spread::Band] {
            chart.series[0].spread = spread(vec![[0.0, 1.0], [2.0, 4.0], [30.0, 50.0]]);
            let svg = chart.svg().unwrap();
            assert!(!svg.contains("NaN") && !svg.contains("inf") && !svg.contains("-2147483648"), "{svg}");
        }
    }

    #[test]
    fn what_has_no_position_on_the_axes_is_refused() {
        let broken = |change: fn(&mut Chart)| {
            let mut chart = chart();
            change(&mut chart);
            chart.svg().unwrap_err()
        };
        assert!(matches!(broken(|chart| chart.series[0].points[0][1] = 0.0), FigureError::NotPositive(_)));
        assert!(matches!(broken(|chart| chart.series[0].points[0][1] = f64::NAN), FigureError::NotFinite(_)));
        assert!(matches!(broken(|chart| chart.series[0].points.clear()), FigureError::Empty(_)));
        assert!(matches!(broken(|chart| chart.series.clear()), FigureError::Empty(_)));
        assert!(matches!(broken(|chart| chart.series[0].labels.push(String::new())), FigureError::Mismatch(_, 3, 1)));
        let short = |chart: &mut Chart| chart.series[0].spread = Spread::Band(vec![[0.4, 1.0]]);
        assert!(matches!(broken(short), FigureError::Mismatch(_, 3, 1)));
    }
}
