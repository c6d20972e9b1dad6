//! Marks: markers of series, arrows and clamps.

use super::colour::TEXT;
use super::error::FigureError;
use super::geometry::{Point, along, direction, distance};
use super::sheet::{Pen, Sheet};
use plotters::style::RGBColor;

/// The sign at each point of a series, so that series differ by more than colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Filled circle.
    Circle,
    /// Filled square.
    Square,
    /// Filled triangle, point up.
    Triangle,
    /// Filled square on its corner.
    Diamond,
    /// Two crossing strokes.
    Cross,
}

impl Marker {
    /// The n-th sign of a series, starting again after the fifth.
    pub fn nth(n: usize) -> Self {
        [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross][n % 5]
    }

    /// Draws the marker about a point; half sizes are such that all look equally heavy.
    pub(super) fn draw(self, sheet: &Sheet, [x, y]: Point, ink: RGBColor) -> Result<(), FigureError> {
        let filled = |half: f64, corners: &[Point]| {
            let corners: Vec<Point> =
                corners.iter().map(|[across, down]| [x + across * half, y + down * half]).collect();
            sheet.polygon(&corners, ink, 1.0)
        };
        match self {
            Self::Circle => sheet.disc([x, y], 5.0, ink),
            Self::Square => filled(4.5, &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
            Self::Triangle => filled(5.8, &[[0.0, -1.1], [1.0, 0.8], [-1.0, 0.8]]),
            Self::Diamond => filled(6.4, &[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
            Self::Cross => [4.8, -4.8]
                .into_iter()
                .try_for_each(|half| sheet.line(&[[x - half, y - 4.8], [x + half, y + 4.8]], Pen::new(ink, 2.2))),
        }
    }
}

/// Draws an arrow whose point is at `to`.
pub(super) fn arrow(sheet: &Sheet, from: Point, to: Point, ink: RGBColor) -> Result<(), FigureError> {
    let Some(forward) = direction(from, to) else { return Ok(()) };
    // A short arrow keeps a visible shaft, which ends inside the head: the joint would show.
    let head = 13.0_f64.min(distance(from, to) * 0.6);
    let (neck, across) = (along(to, forward, -head), [-forward[1], forward[0]]);
    sheet.line(&[from, along(to, forward, -head * 0.8)], Pen::new(ink, 2.6))?;
    sheet.polygon(&[to, along(neck, across, head * 0.42), along(neck, across, -head * 0.42)], ink, 1.0)
}

/// Length of a clamp from its point to the end of its hatching, px.
pub(super) const CLAMP_DEPTH: f64 = 22.0;

/// Draws a support: a triangle with its point at the node, on hatched ground in the direction `ground`.
pub(super) fn clamp(sheet: &Sheet, node: Point, ground: Point) -> Result<(), FigureError> {
    let across = [-ground[1], ground[0]];
    let foot = along(node, ground, 14.0);
    let on_foot = |offset: f64| along(foot, across, offset);
    sheet.line(&[node, on_foot(8.0), on_foot(-8.0), node], Pen::new(TEXT, 1.6))?;
    sheet.line(&[on_foot(11.0), on_foot(-11.0)], Pen::new(TEXT, 1.6))?;
    [-8.0, -2.5, 3.0, 8.5].into_iter().try_for_each(|offset| {
        let end = along(on_foot(offset - 5.0), ground, CLAMP_DEPTH - 14.0);
        sheet.line(&[on_foot(offset), end], Pen::new(TEXT, 1.2))
    })
}
