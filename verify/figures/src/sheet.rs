//! The sheet on which a figure is drawn: lines, areas and text, in pixels.

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoFont, ShapeStyle, TextStyle};

use super::colour::TEXT;
use super::error::FigureError;
use super::geometry::{Area, Point};
use super::svg::{Svg, UNITS};

/// Text size of tick labels, legends and node numbers, px.
pub(super) const TICK_TEXT: f64 = 16.0;
/// Text size of axis labels, px.
pub(super) const LABEL_TEXT: f64 = 17.0;
/// Space between neighbouring elements, px.
pub(super) const SPACE: f64 = 8.0;

/// Alignment of text whose left edge is at the given position.
pub(super) const LEFT: Pos = Pos { h_pos: HPos::Left, v_pos: VPos::Center };

type DrawResult = Result<(), FigureError>;

/// How a line joins the points of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// The points are not joined.
    None,
    /// An arrow from the first point to the last.
    Arrow,
    /// A solid line.
    Solid,
    /// A line of long dashes.
    Dashed,
    /// A dotted line.
    Dotted,
}

/// Style of a line with the given colour and width, px.
pub(super) fn pen(ink: impl Color, width: f64) -> ShapeStyle {
    ink.stroke_width(units(width) as u32)
}

/// Style of axes, ticks and outlines.
pub(super) fn axis_pen() -> ShapeStyle {
    pen(TEXT.mix(0.65), 1.2)
}

/// Style of text of the given size, px, centred at its position.
pub(super) fn font(size: f64) -> TextStyle<'static> {
    let font = ("sans-serif", size * UNITS).into_font();
    TextStyle::from(font).color(&TEXT).pos(Pos::new(HPos::Center, VPos::Center))
}

/// Style of bold text of the given size, px, that begins at its position.
pub(super) fn bold(size: f64) -> TextStyle<'static> {
    TextStyle { font: font(size).font.style(FontStyle::Bold), ..font(size).pos(LEFT) }
}

/// Converts pixels to drawing units, rounded to a whole number.
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * UNITS).round() as i32
}

fn path(points: &[Point]) -> Vec<(i32, i32)> {
    points.iter().map(|[x, y]| (units(*x), units(*y))).collect()
}

/// The drawing area, and the SVG text that it writes.
pub(super) struct Sheet(pub(super) DrawingArea<Svg, Shift>, pub(super) Svg);

impl Sheet {
    /// An empty sheet that writes to `svg`.
    pub(super) fn new(svg: &Svg) -> Sheet {
        Sheet(svg.clone().into_drawing_area(), svg.clone())
    }

    /// Writes markup without escaping.
    pub(super) fn markup(&self, text: &str) {
        self.1.text.borrow_mut().push_str(text);
    }

    /// Draws a solid line through points, px.
    pub(super) fn line(&self, points: &[Point], pen: ShapeStyle) -> DrawResult {
        Ok(self.0.draw(&PathElement::new(path(points), pen))?)
    }

    /// Draws a line through points, px, in the given style.
    pub(super) fn dashed(&self, points: &[Point], pen: ShapeStyle, dash: Dash) -> DrawResult {
        let (size, gap) = match dash {
            Dash::None => return Ok(()),
            Dash::Solid | Dash::Arrow => return self.line(points, pen),
            Dash::Dashed => (90, 50),
            Dash::Dotted => (30, 40),
        };
        Ok(self.0.draw(&DashedPathElement::new(path(points), size, gap, pen))?)
    }

    /// Fills a polygon with these corners, px.
    pub(super) fn polygon(&self, points: &[Point], ink: impl Color) -> DrawResult {
        Ok(self.0.draw(&Polygon::new(path(points), ink.filled()))?)
    }

    /// Fills a rectangle.
    pub(super) fn cell(&self, area: Area, ink: impl Color) -> DrawResult {
        let corners = path(&[[area.left, area.top], [area.right, area.bottom]]);
        Ok(self.0.draw(&Rectangle::new([corners[0], corners[1]], ink.filled()))?)
    }

    /// Fills a circle; centre and radius in px.
    pub(super) fn disc(&self, centre: Point, radius: f64, ink: impl Color) -> DrawResult {
        Ok(self.0.draw(&Circle::new(path(&[centre])[0], units(radius), ink.filled()))?)
    }

    /// Writes text at a position, px.
    pub(super) fn words(&self, text: &str, at: Point, style: &TextStyle) -> DrawResult {
        Ok(self.0.draw_text(text, style, path(&[at])[0])?)
    }

    /// Fills an area with slanted lines, for cells without data. The lines of neighbouring areas continue each other.
    pub(super) fn hatch(&self, area: Area, rising: bool) -> DrawResult {
        const STEP: f64 = 8.0;
        // On one slanted line, the sum (or difference) of the coordinates is constant.
        let sign = if rising { 1.0 } else { -1.0 };
        let sums = [area.top, area.bottom].map(|y| [area.left, area.right].map(|x| y + sign * x));
        let ends = |of: fn(f64, f64) -> f64| sums.as_flattened().iter().copied().reduce(of).unwrap_or(0.0) / STEP;
        let (first, last) = (ends(f64::min).floor() as i64, ends(f64::max).ceil() as i64);
        let line = |index: i64| [area.left, area.right].map(|x| [x, index as f64 * STEP - sign * x]);
        let mut pieces = (first..=last).map(line).filter_map(|[from, to]| area.clip(from, to));
        pieces.try_for_each(|piece| self.line(&piece, pen(TEXT.mix(0.45), 1.2)))
    }
}
