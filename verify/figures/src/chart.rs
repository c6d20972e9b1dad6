//! Charts: series, grouped bars, reference lines, and drawings to scale.

use plotters::style::Color;

use super::axis::{Axis, Scale};
use super::bars::{Bars, Writing};
use super::colour::TEXT;
use super::error::{FigureError, require};
use super::geometry::{Area, Lines};
use super::labels::{Label, Obstacles};
use super::panels::{Frame, Panels, Plot};
use super::patch::Patch;
use super::series::Series;
use super::sheet::{Dash, LEFT, SPACE, Sheet, TICK_TEXT, font, pen};
use super::text::{widest, wrap};

/// Series, bars and areas over a horizontal and a vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Heading, description and size of the figure.
    pub frame: Frame,
    /// Horizontal axis; an axis of categories if there are bars.
    pub x: Axis,
    /// Vertical axis of the chart.
    pub y: Axis,
    /// An additional axis along the top, for instance node numbers.
    pub top: Option<Axis>,
    /// Filled areas, drawn behind everything else.
    pub patches: Vec<Patch>,
    /// Series of points.
    pub series: Vec<Series>,
    /// Sets of bars, side by side in each category; all bars start at 0.
    pub bars: Vec<Bars>,
    /// Horizontal reference lines: value on the vertical axis, and text beside the line, for instance "10 %".
    pub references: Vec<(f64, String)>,
    /// Whether both axes have the same scale, in mm, as in a drawing.
    pub equal_axes: bool,
}

/// Space around a drawing to scale, px: the first number for drawings with symbols or labels of points, the second for all others.
const MARGINS: [f64; 2] = [44.0, 18.0];
/// Space beside a drawing to scale, px: on the left for tick labels of four characters, and on the right.
pub(super) const SIDES: [f64; 2] = [58.0, 2.0 * SPACE];

impl Chart {
    /// A chart with only series.
    pub fn new(frame: Frame, [x, y]: [Axis; 2], series: Vec<Series>) -> Self {
        Self {
            frame,
            x,
            y,
            top: None,
            patches: Vec::new(),
            series,
            bars: Vec::new(),
            references: Vec::new(),
            equal_axes: false,
        }
    }

    /// A chart with only bars, over named categories.
    pub fn of_bars(frame: Frame, axes: [Axis; 2], bars: Vec<Bars>) -> Self {
        Self { bars, ..Self::new(frame, axes, Vec::new()) }
    }

    /// A drawing in which both axes have the same scale, in mm.
    pub fn to_scale(frame: Frame, labels: [&str; 2], series: Vec<Series>) -> Self {
        Self { equal_axes: true, ..Self::new(frame, labels.map(Axis::linear), series) }
    }

    /// Adds horizontal reference lines at these values, with their texts.
    pub fn compared(self, references: impl IntoIterator<Item = (f64, String)>) -> Self {
        Self { references: references.into_iter().collect(), ..self }
    }

    /// Draws the chart as SVG.
    ///
    /// # Errors
    /// [`FigureError`] if there is nothing to draw, or if numbers cannot be drawn on the axes.
    pub fn svg(&self) -> Result<String, FigureError> {
        require(!self.series.is_empty() || !self.bars.is_empty(), FigureError::Empty, "chart")?;
        self.series.iter().try_for_each(Series::check)?;
        self.patches.iter().try_for_each(Patch::check)?;
        self.bars.iter().try_for_each(|bars| bars.check(&self.x))?;
        let outlines = self.patches.iter().map(|patch| &patch.outline);
        let points = || self.series.iter().map(|series| &series.points).chain(outlines.clone()).flatten();
        let ends = self.series.iter().flat_map(|series| &series.spread).flatten().copied();
        // On a logarithmic axis, an error bar whose lower end is zero or less is drawn from the lower end of the axis.
        let ends = ends.filter(|end| self.y.scale == Scale::Linear || *end > 0.0);
        let of_bars = self.bars.iter().flat_map(Bars::heights);
        let up =
            points().map(|point| point[1]).chain(ends).chain(of_bars).chain(self.references.iter().map(|line| line.0));
        let data = [points().map(|point| point[0]).collect(), up.collect()];
        let lines = |(value, label): &(f64, String)| (*value, wrap(label, TICK_TEXT, self.frame.width * 0.2));
        let words: Vec<(f64, Vec<String>)> = self.references.iter().map(lines).collect();
        let right = widest(words.iter().flat_map(|words| &words.1), TICK_TEXT) + 2.0 * SPACE;
        let (axes, height) =
            if self.equal_axes { self.scaled(&data) } else { ([self.x.clone(), self.y.clone()], None) };
        let mut panels = Panels::new(&self.frame, [&axes[0], &axes[1]]);
        (panels.data, panels.height, panels.top) = (data, height.unwrap_or(panels.height), self.top.as_ref());
        panels.sides = if self.equal_axes { SIDES } else { [0.0, right.max(3.0 * SPACE)] };
        let of_bars = self.bars.iter().map(Bars::entry).chain(self.series.iter().map(Series::entry));
        panels.legend = Patch::legend(&self.patches).into_iter().chain(of_bars).collect();
        let writing = Writing::of(&self.bars, &self.x, self.frame.width - panels.sides[1] - 50.0);
        (panels.head, panels.grid) = (writing.height, [self.bars.is_empty(), true]);
        panels.draw(|sheet, plots| {
            let (plot, bars) =
                (&plots[0], || self.bars.iter().enumerate().map(|(nth, bars)| (bars, [nth, self.bars.len()])));
            self.patches.iter().try_for_each(|patch| patch.draw(sheet, plot))?;
            bars().try_for_each(|(bars, nth)| bars.draw(sheet, plot, nth))?;
            draw_references(sheet, plot, words)?;
            bars().try_for_each(|(bars, nth)| writing.write(sheet, plot, bars, nth))?;
            self.series.iter().try_for_each(|series| series.draw(sheet, plot))?;
            self.draw_labels(sheet, plot)
        })
    }

    /// Axes with the same scale that contain the data, and the height of the plot, px.
    pub(super) fn scaled(&self, data: &[Vec<f64>; 2]) -> ([Axis; 2], Option<f64>) {
        let ends = |data: &Vec<f64>| [f64::min, f64::max].map(|of| data.iter().copied().reduce(of).unwrap_or(0.0));
        let [[left, right], [low, high]] = [ends(&data[0]), ends(&data[1])];
        let width = self.frame.width - SIDES[0] - SIDES[1];
        let most = self.frame.plot_height.unwrap_or(self.frame.width * 0.75);
        let has_symbols = self.series.iter().any(|series| series.marker.is_some() || !series.labels.is_empty());
        let margin = MARGINS[usize::from(!has_symbols)];
        let per_mm = |room: f64, size: f64| (room - 2.0 * margin) / size.max(1e-9);
        let per_mm = per_mm(width, right - left).min(per_mm(most, high - low));
        let height = (high - low) * per_mm + 2.0 * margin;
        let axis = |axis: &Axis, middle: f64, pixels: f64| {
            axis.clone().within(middle - pixels / per_mm / 2.0, middle + pixels / per_mm / 2.0)
        };
        ([axis(&self.x, (left + right) / 2.0, width), axis(&self.y, (low + high) / 2.0, height)], Some(height))
    }

    /// Writes the labels of points at positions where they hide neither lines nor symbols nor other labels.
    fn draw_labels(&self, sheet: &Sheet, plot: &Plot) -> Result<(), FigureError> {
        let joined = self.series.iter().filter(|series| series.dash != Dash::None);
        let lines: Lines = joined.map(|series| plot.line(&series.points)).collect();
        let middle = Area::around(self.series.iter().flat_map(|series| plot.line(&series.points))).centre();
        let middle = self.equal_axes.then_some(middle);
        let labels: Vec<Label> = self.series.iter().flat_map(|series| series.words(plot, &lines, middle)).collect();
        let areas = self.series.iter().flat_map(|series| series.taken(plot)).collect();
        Obstacles { lines, areas, within: plot.area }.write(sheet, &labels)
    }
}

/// Draws horizontal reference lines, with their texts right of the plot. A text that would touch the text above is moved down. A text near the plot's
/// lower edge is moved up, so that it ends above the names of the ticks.
fn draw_references(sheet: &Sheet, plot: &Plot, words: Vec<(f64, Vec<String>)>) -> Result<(), FigureError> {
    const LINE: f64 = TICK_TEXT * 1.2;
    let Area { left, right, bottom, .. } = plot.area;
    let mut shown: Vec<_> = words.into_iter().map(|(value, lines)| (plot.at([0.0, value])[1], lines)).collect();
    shown.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = f64::NEG_INFINITY;
    for (y, lines) in shown {
        sheet.dashed(&[[left, y], [right, y]], pen(TEXT.mix(0.75), 1.6), Dash::Dashed)?;
        let height = (lines.len() as f64 - 1.0) * LINE;
        let first = (y - height / 2.0).min(bottom - height - LINE / 2.0).max(free);
        for (index, line) in lines.iter().enumerate() {
            sheet.words(line, [right + SPACE, first + index as f64 * LINE], &font(TICK_TEXT).pos(LEFT))?;
        }
        free = first + lines.len() as f64 * LINE;
    }
    Ok(())
}
