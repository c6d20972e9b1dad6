//! The layout that all figures share: heading, vertical axis label, plots, horizontal axis label, legend.

use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::cartesian::Cartesian2d;
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::{Axis, Ruler};
use super::colour::TEXT;
use super::error::FigureError;
use super::geometry::{Area, Point};
use super::legend::{Entry, Legend};
use super::sheet::{LABEL_TEXT, LEFT, SPACE, Sheet, TICK_TEXT, axis_pen, bold, font, pen, units};
use super::svg::{Svg, escape};
use super::text::{widest, width_of, wrap};

/// Heading, description and size of a figure.
///
/// A figure scales with the page. The frame's width, px, sets the size of text and lines relative to the figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Heading; empty for a figure without heading.
    pub(super) title: String,
    alt: String,
    /// Width of the figure, px.
    pub(super) width: f64,
    /// Height of a plot, px; `None` for the default height.
    pub(super) plot_height: Option<f64>,
}

impl Frame {
    /// A figure as wide as the page (900 px). The heading may be empty. `alt` describes the figure for readers who cannot see it.
    pub fn full(title: impl Into<String>, alt: impl Into<String>) -> Self {
        Self { title: title.into(), alt: alt.into(), width: 900.0, plot_height: None }
    }

    /// A figure for half the width of the page, or for the width of a phone (560 px).
    pub fn half(title: impl Into<String>, alt: impl Into<String>) -> Self {
        Self { width: 560.0, ..Self::full(title, alt) }
    }

    /// A figure for a third of the width of the page (400 px).
    pub fn third(title: impl Into<String>, alt: impl Into<String>) -> Self {
        Self { width: 400.0, ..Self::full(title, alt) }
    }

    /// Sets the height of a plot, px. For a drawing to scale, this is the largest height.
    pub fn with_plot_height(self, pixels: f64) -> Self {
        Self { plot_height: Some(pixels), ..self }
    }

    /// Height of a single plot, px. The ratio of height to width is larger for a narrow plot, so that its curves are not flattened.
    pub(super) fn height(&self) -> f64 {
        self.plot_height.unwrap_or(self.width * if self.width > 700.0 { 0.46 } else { 0.62 })
    }

    fn opening(&self, height: f64) -> String {
        let (width, height) = (self.width, height.round());
        let name = escape(if self.title.is_empty() { &self.alt } else { &self.title });
        let label = name.replace('"', "&quot;");
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"100%\" \
             style=\"display:block;height:auto;max-width:{width}px\" role=\"img\" aria-label=\"{label}\" stroke-linejoin=\"round\">\
             <title>{name}</title><desc>{}</desc>\n",
            escape(&self.alt)
        )
    }
}

/// A plot with its two axes.
pub(super) struct Plot {
    chart: ChartContext<'static, Svg, Cartesian2d<Ruler, Ruler>>,
    pub(super) area: Area,
}

impl Plot {
    /// Draws both axes, and grid lines at the ticks of x and y if `grid` requests them. `left`, `top` and `bottom` are the space for tick labels, px.
    pub(super) fn new(
        sheet: &Sheet,
        area: Area,
        [x, y]: [Ruler; 2],
        [left, top, bottom]: [f64; 3],
        grid: [bool; 2],
    ) -> Result<Self, FigureError> {
        let corner = (units(area.left - left), units(area.top - top));
        let size = (units(area.width() + left), units(area.height() + top + bottom));
        let mut chart = ChartBuilder::on(&sheet.0.clone().shrink(corner, size))
            .set_label_area_size(LabelAreaPosition::Left, units(left))
            .set_label_area_size(LabelAreaPosition::Top, units(top))
            .set_label_area_size(LabelAreaPosition::Bottom, units(bottom))
            .build_cartesian_2d(x, y)?;
        let mut mesh = chart.configure_mesh();
        if !grid[0] {
            mesh.disable_x_mesh();
        }
        if !grid[1] {
            mesh.disable_y_mesh();
        }
        mesh.label_style(font(TICK_TEXT)).axis_style(axis_pen()).bold_line_style(pen(TEXT.mix(0.14), 1.0));
        mesh.set_all_tick_mark_size(units(4.0)).draw()?;
        Ok(Self { chart, area })
    }

    /// Position of a data point on the sheet, px. A point beyond an axis is moved to the end of the axis.
    pub(super) fn at(&self, [x, y]: Point) -> Point {
        let (x, y) = self.chart.backend_coord(&(x, y));
        [f64::from(x), f64::from(y)].map(|units| units / super::svg::UNITS)
    }

    /// Positions of data points on the sheet, px.
    pub(super) fn line(&self, points: &[Point]) -> Vec<Point> {
        points.iter().map(|point| self.at(*point)).collect()
    }
}

/// All parts of a figure around its plots: heading, axes, names of rows and columns, and legend.
pub(super) struct Panels<'a> {
    pub(super) frame: &'a Frame,
    pub(super) axes: [&'a Axis; 2],
    /// Values in x and y that the axes must include if their limits are not given.
    pub(super) data: [Vec<f64>; 2],
    /// Height of each plot, px.
    pub(super) height: f64,
    /// Space kept free in each plot above the upper limit of the vertical axis, px.
    pub(super) head: f64,
    /// An additional axis along the top, for instance node numbers.
    pub(super) top: Option<&'a Axis>,
    /// Space left of the plots (at least; tick labels may need more), and space right of the plots, px.
    pub(super) sides: [f64; 2],
    /// Whether to draw grid lines at the ticks of x and y.
    pub(super) grid: [bool; 2],
    /// Names of the rows of small multiples; empty for a single plot.
    pub(super) rows: &'a [String],
    /// Names of the columns of small multiples; empty for a single plot.
    pub(super) columns: &'a [String],
    /// Space above each plot for its note, px.
    pub(super) above: f64,
    pub(super) legend: Vec<Entry<'a>>,
}

/// Least space left of the plots for the names of rows, px.
const ROW_NAMES: f64 = 92.0;
/// Width of bold letters relative to plain ones.
const BOLD: f64 = 1.16;
const HEADING_TEXT: f64 = 18.0;
const HEADING_LINE: f64 = HEADING_TEXT * 1.3;
const LABEL_LINE: f64 = LABEL_TEXT * 1.5;
const TICKS: f64 = TICK_TEXT * 1.3 + SPACE;

impl<'a> Panels<'a> {
    /// A single plot with grid lines.
    pub(super) fn new(frame: &'a Frame, axes: [&'a Axis; 2]) -> Self {
        let (height, sides) = (frame.height(), [30.0, 3.0 * SPACE]);
        let (data, rows, columns, legend) = ([vec![], vec![]], &[], &[], vec![]);
        Self {
            frame,
            axes,
            data,
            height,
            head: 0.0,
            top: None,
            sides,
            grid: [true; 2],
            rows,
            columns,
            above: 0.0,
            legend,
        }
    }

    /// Draws everything around the plots, and returns the SVG. `paint` draws into the plots, which are ordered row by row.
    pub(super) fn draw(
        self,
        paint: impl FnOnce(&Sheet, &[Plot]) -> Result<(), FigureError>,
    ) -> Result<String, FigureError> {
        let frame = self.frame;
        let heading = wrap(&frame.title, HEADING_TEXT * BOLD, frame.width - 2.0 * SPACE);
        let heading_height = heading.len() as f64 * HEADING_LINE + SPACE;
        let [x_axis, y_axis] = self.axes;
        let mut y = y_axis.ruler(&self.data[1], self.height - self.head, true)?;
        y.span[1] += (y.span[1] - y.span[0]) * self.head / (self.height - self.head);
        let tick_room = (widest(y.ticks.iter().map(|tick| &tick.1), TICK_TEXT) + 2.5 * SPACE).max(self.sides[0]);
        // Row names are broken only between words, so the longest word sets the space; bold letters are wider than plain ones.
        let words = self.rows.iter().flat_map(|name| name.split_whitespace());
        let longest = words.map(|word| width_of(word, LABEL_TEXT * BOLD) + SPACE).fold(ROW_NAMES, f64::max);
        let left = tick_room + if self.rows.is_empty() { 0.0 } else { longest };
        let [rows, columns] = [self.rows, self.columns].map(|names| names.len().max(1));
        let gap = if columns > 1 { 2.0 * SPACE } else { 0.0 };
        let width = (frame.width - self.sides[1] - left + gap) / columns as f64 - gap;
        let x = x_axis.ruler(&self.data[0], width, false)?;
        let top = if self.top.is_some() { TICKS } else { 0.0 };
        let names = if self.columns.is_empty() { 0.0 } else { LABEL_LINE };
        let first = heading_height + LABEL_LINE + SPACE / 2.0 + names + self.above + top;
        let pitch = self.above + self.height + SPACE;
        let bottom = first + rows as f64 * pitch - self.above - SPACE;
        let under = bottom + TICKS + LABEL_LINE + SPACE;
        let legend = Legend::lay_out(self.legend, [SPACE, frame.width - SPACE]);
        let end = under + legend.height() + SPACE;

        let svg = Svg { size: (units(frame.width) as u32, units(end) as u32), ..Svg::default() };
        svg.text.borrow_mut().push_str(&frame.opening(end));
        let sheet = Sheet::new(&svg);
        for (index, line) in heading.iter().enumerate() {
            let at = [SPACE, (index as f64 + 0.5) * HEADING_LINE];
            sheet.words(line, at, &bold(HEADING_TEXT))?;
        }
        // The label of the vertical axis is written horizontally, above the plots, so that it is easy to read.
        sheet.words(&y_axis.label, [SPACE, heading_height + LABEL_LINE * 0.4], &font(LABEL_TEXT).pos(LEFT))?;
        let middle = (left + frame.width - self.sides[1]) / 2.0;
        sheet.words(&x_axis.label, [middle, bottom + TICKS + LABEL_LINE * 0.4], &font(LABEL_TEXT))?;
        let area = |row: usize, column: usize| {
            let corner = [left + column as f64 * (width + gap), first + row as f64 * pitch];
            Area::between(corner, [corner[0] + width, corner[1] + self.height])
        };
        for (column, name) in self.columns.iter().enumerate() {
            sheet.words(name, [area(0, column).left, first - self.above - LABEL_LINE * 0.5], &bold(LABEL_TEXT))?;
        }
        for (row, name) in self.rows.iter().enumerate() {
            for (index, line) in wrap(name, LABEL_TEXT * BOLD, longest).iter().enumerate() {
                let y = area(row, 0).top + (index as f64 + 0.5) * LABEL_TEXT * 1.25;
                sheet.words(line, [SPACE, y], &bold(LABEL_TEXT))?;
            }
        }
        if let Some(axis) = self.top {
            let ruler = axis.clone().within(x.span[0], x.span[1]).ruler(&[], width, false)?;
            Plot::new(&sheet, area(0, 0), [ruler, y.clone()], [0.0, top, 0.0], [false; 2])?;
            let right = font(TICK_TEXT).pos(Pos::new(HPos::Right, VPos::Bottom));
            sheet.words(&axis.label, [left - SPACE, first - SPACE], &right)?;
        }
        let mut plots = Vec::new();
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let room = [if column == 0 { tick_room } else { 0.0 }, 0.0, if row + 1 == rows { TICKS } else { 0.0 }];
            plots.push(Plot::new(&sheet, area(row, column), [x.clone(), y.clone()], room, self.grid)?);
        }
        paint(&sheet, &plots)?;
        plots.iter().try_for_each(|plot| sheet.line(&plot.area.outline(), axis_pen()))?;
        legend.draw(&sheet, under)?;
        let drawn = svg.text.borrow().clone();
        Ok(drawn + "</svg>\n")
    }
}
