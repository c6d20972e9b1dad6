//! Small signs: points, arrows, clamps and hatching.

use super::canvas::{Canvas, Pen};
use super::colour::Ink;
use super::error::FigureError;
use super::frame::Point;
use super::stroke::{Area, along, distance, unit};

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
        const ORDER: [Marker; 5] = [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross];
        ORDER[n % ORDER.len()]
    }
}

/// Draws a marker about a point.
pub(super) fn marker(canvas: &mut Canvas, sign: Marker, [x, y]: Point, ink: Ink) -> Result<(), FigureError> {
    // Half sizes chosen so that all signs look equally heavy.
    let corners = |half: f64, turns: &[[f64; 2]]| -> Vec<Point> {
        turns.iter().map(|[across, down]| [x + across * half, y + down * half]).collect()
    };
    match sign {
        Marker::Circle => canvas.disc([x, y], 5.0, ink),
        Marker::Square => {
            let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            canvas.polygon(&corners(4.5, &square), ink, 1.0)
        }
        Marker::Triangle => {
            let triangle = [[0.0, -1.1], [1.0, 0.8], [-1.0, 0.8]];
            canvas.polygon(&corners(5.8, &triangle), ink, 1.0)
        }
        Marker::Diamond => {
            let diamond = [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
            canvas.polygon(&corners(6.4, &diamond), ink, 1.0)
        }
        Marker::Cross => {
            let pen = Pen::new(ink, 2.2);
            canvas.line(&[[x - 4.8, y - 4.8], [x + 4.8, y + 4.8]], pen)?;
            canvas.line(&[[x - 4.8, y + 4.8], [x + 4.8, y - 4.8]], pen)
        }
    }
}

/// Draws an arrow whose point is at `to`.
pub(super) fn arrow(canvas: &mut Canvas, from: Point, to: Point, ink: Ink) -> Result<(), FigureError> {
    let Some(direction) = unit([to[0] - from[0], to[1] - from[1]]) else {
        return Ok(());
    };
    // A short arrow keeps a visible shaft.
    let head = 13.0_f64.min(distance(from, to) * 0.6);
    let neck = along(to, direction, -head);
    let across = [-direction[1], direction[0]];
    // The shaft ends inside the head, or the joint would show.
    let shaft_end = along(to, direction, -head * 0.8);
    canvas.line(&[from, shaft_end], Pen::new(ink, 2.6))?;
    let barbs = [to, along(neck, across, head * 0.42), along(neck, across, -head * 0.42)];
    canvas.polygon(&barbs, ink, 1.0)
}

/// Length of a clamp sign from its point to the end of its hatching.
pub(super) const CLAMP_DEPTH: f64 = 22.0;

/// Draws a support: a triangle whose point is at the node, standing on hatched
/// ground that lies along `ground` from it.
pub(super) fn clamp(canvas: &mut Canvas, node: Point, ground: Point) -> Result<(), FigureError> {
    let across = [-ground[1], ground[0]];
    let foot = along(node, ground, 14.0);
    let pen = Pen::new(Ink::Text, 1.6);
    let [one, other] = [8.0, -8.0].map(|half| along(foot, across, half));
    canvas.line(&[node, one, other, node], pen)?;
    canvas.line(&[along(foot, across, 11.0), along(foot, across, -11.0)], pen)?;
    for place in [-8.0, -2.5, 3.0, 8.5] {
        let start = along(foot, across, place);
        let end = along(along(start, ground, CLAMP_DEPTH - 14.0), across, -5.0);
        canvas.line(&[start, end], Pen::new(Ink::Text, 1.2))?;
    }
    Ok(())
}

/// Fills an area with slanting lines, for places without data.
///
/// The lines of neighbouring areas meet, so that they read as one.
pub(super) fn hatch(canvas: &mut Canvas, area: Area) -> Result<(), FigureError> {
    const STEP: f64 = 8.0;
    let first = ((area.left + area.top) / STEP).floor() as i64;
    let last = ((area.right + area.bottom) / STEP).ceil() as i64;
    let reach = (area.right - area.left) + (area.bottom - area.top);
    for index in first..=last {
        // Points of one slanting line share the sum of their coordinates.
        let sum = index as f64 * STEP;
        let from = [area.left - reach, sum - area.left + reach];
        let to = [area.right + reach, sum - area.right - reach];
        if let Some(piece) = area.clip(from, to) {
            canvas.line(&piece, Pen::new(Ink::Text, 1.2).faint(0.45))?;
        }
    }
    Ok(())
}
