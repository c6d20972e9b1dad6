//! Series of points, their style and their labels.

use super::colour::Hue;
use super::error::{FigureError, require, require_finite, require_len};
use super::geometry::{Area, Lines, Point, direction, gap, segments};
use super::labels::Label;
use super::legend::Entry;
use super::marks::{Marker, arrow};
use super::panels::Plot;
use super::sheet::{Dash, Sheet, pen};

/// A series of points with its style, legend text and labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Text in the legend; a series with empty text is not listed.
    pub label: String,
    /// Points in the order in which the line joins them.
    pub points: Vec<Point>,
    /// Colour of the series.
    pub hue: Hue,
    /// Style of the joining line.
    pub dash: Dash,
    /// Width of the joining line, px.
    pub width: f64,
    /// Symbol at each point.
    pub marker: Option<Marker>,
    /// Vertical bars for the uncertainty, one at each point, from the first value to the second; an empty list for a series without bars.
    pub spread: Vec<[f64; 2]>,
    /// Text at each point; an empty list for a series without such texts.
    pub labels: Vec<String>,
}

impl Series {
    /// The n-th series of a chart: a solid line with symbols, in the n-th colour.
    pub fn nth(n: usize, label: impl Into<String>, points: Vec<Point>) -> Self {
        let (marker, spread, labels) = (Some(Marker::nth(n)), Vec::new(), Vec::new());
        Self { label: label.into(), points, hue: Hue::nth(n), dash: Dash::Solid, width: 2.6, marker, spread, labels }
    }

    /// A dotted reference line without symbols.
    pub fn guide(label: impl Into<String>, points: Vec<Point>) -> Self {
        Self { hue: Hue::NEUTRAL, dash: Dash::Dotted, marker: None, ..Self::nth(0, label, points) }
    }

    /// One series per line, without symbols; all have a common legend entry.
    pub fn lines(label: &str, lines: Lines, hue: Hue, width: f64) -> Vec<Self> {
        let plain = |points| Self { hue, width, marker: None, ..Self::nth(0, "", points) };
        let mut series: Vec<Self> = lines.into_iter().map(plain).collect();
        series.iter_mut().take(1).for_each(|first| first.label = label.to_owned());
        series
    }

    /// Unconnected points, each with a symbol and a text.
    pub fn marks(label: &str, marker: Marker, (points, labels): (Vec<Point>, Vec<String>)) -> Self {
        let (hue, marker) = (Hue::NEUTRAL, Some(marker));
        Self { hue, dash: Dash::None, marker, labels, ..Self::nth(0, label, points) }
    }

    /// An arrow from the first point to the second, with text at its start.
    pub fn arrow(ends: [Point; 2], words: impl Into<String>, hue: Hue) -> Self {
        let labels = vec![words.into(), String::new()];
        Self { hue, dash: Dash::Arrow, marker: None, labels, ..Self::nth(0, "", ends.into()) }
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        require(!self.points.is_empty(), FigureError::Empty, &self.label)?;
        require_finite(&self.label, self.points.iter().chain(&self.spread).flatten())?;
        if !self.spread.is_empty() {
            require_len(&self.label, &self.spread, self.points.len())?;
        }
        if self.labels.is_empty() { Ok(()) } else { require_len(&self.label, &self.labels, self.points.len()) }
    }

    /// Draws the joining line through the points `line`, and the symbols at the points `signs`, px.
    fn stroke(&self, sheet: &Sheet, line: &[Point], signs: &[Point]) -> Result<(), FigureError> {
        match (self.dash, line) {
            (Dash::Arrow, [from, .., to]) => arrow(sheet, [*from, *to], self.hue.0)?,
            _ => sheet.dashed(line, pen(self.hue.0, self.width), self.dash)?,
        }
        self.marker.map_or(Ok(()), |marker| signs.iter().try_for_each(|at| marker.draw(sheet, *at, self.hue.0)))
    }

    /// Draws the error bars, then the line and the symbols above them.
    pub(super) fn draw(&self, sheet: &Sheet, plot: &Plot) -> Result<(), FigureError> {
        let (points, ink) = (plot.line(&self.points), self.hue.0);
        let spread = self.points.iter().zip(&self.spread).map(|([x, _], ends)| ends.map(|end| plot.at([*x, end])));
        for ends in spread {
            sheet.line(&ends, pen(ink, 1.6))?;
            ends.iter().try_for_each(|[x, y]| sheet.line(&[[x - 5.0, *y], [x + 5.0, *y]], pen(ink, 1.6)))?;
        }
        self.stroke(sheet, &points, &points)
    }

    pub(super) fn entry(&self) -> Entry<'_> {
        Entry::new(&self.label, |sheet, area| {
            let [x, y] = area.centre();
            let middle = if self.marker == Some(Marker::Clamp) { [x + 8.0, y] } else { [x, y] };
            self.stroke(sheet, &area.level(), &[middle])
        })
    }

    /// Areas of the sheet that the symbols cover.
    pub(super) fn taken(&self, plot: &Plot) -> impl Iterator<Item = Area> {
        let area = |[x, y]: Point| match self.marker {
            Some(Marker::Clamp) => Area::between([x - 22.0, y - 11.0], [x + 6.0, y + 11.0]),
            _ => Area::about([x, y], 12.0, 12.0),
        };
        plot.line(&self.points).into_iter().filter(|_| self.marker.is_some()).map(area)
    }

    /// Labels of the points. The label of an arrow lies behind the arrow's start. In a drawing to scale, a label lies perpendicular to the nearest
    /// line, on the side away from the middle of the drawing. In any other plot, the label of a point lies to the upper right of the point.
    pub(super) fn words(&self, plot: &Plot, lines: &Lines, middle: Option<Point>) -> Vec<Label> {
        let points = plot.line(&self.points);
        let behind = points.windows(2).next().and_then(|ends| direction(ends[1], ends[0]));
        let side = |at| match (behind, middle) {
            (Some(behind), _) if self.dash == Dash::Arrow => behind,
            (_, Some(middle)) => outward(at, lines, middle),
            _ => [0.7, -0.7],
        };
        let labelled = points.iter().zip(&self.labels);
        labelled.map(|(at, text)| Label { text: text.clone(), anchor: *at, side: side(*at) }).collect()
    }
}

/// Unit vector away from `middle`, perpendicular to the nearest line.
fn outward(at: Point, lines: &Lines, middle: Point) -> Point {
    let away = direction(middle, at).unwrap_or([0.0, -1.0]);
    let nearest = segments(lines).min_by(|a, b| gap(at, *a).total_cmp(&gap(at, *b)));
    match nearest.and_then(|[from, to]| direction(from, to)) {
        None => away,
        Some([x, y]) if away[1] * x >= away[0] * y => [-y, x],
        Some([x, y]) => [y, -x],
    }
}
