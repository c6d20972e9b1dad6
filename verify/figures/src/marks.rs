//! Symbols at the points of a series.

use plotters::style::RGBAColor;

use super::error::FigureError;
use super::geometry::{Point, along, direction, distance};
use super::sheet::{Sheet, pen};

/// Symbol at each point of a series. Different symbols distinguish the series even without colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Filled circle.
    Circle,
    /// Filled square.
    Square,
    /// Filled triangle, point up.
    Triangle,
    /// Filled square, standing on a corner.
    Diamond,
    /// Two crossing strokes.
    Cross,
    /// A small filled circle, for a mesh node or rod.
    Node,
    /// A triangle with hatched ground to its left, for a clamped node.
    Clamp,
}

impl Marker {
    /// The n-th symbol; the sequence repeats after the fifth.
    pub fn nth(n: usize) -> Self {
        [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross][n % 5]
    }

    /// Draws the symbol centred at a point. The sizes of the symbols differ with their shapes, so that all symbols appear equally large.
    pub(super) fn draw(self, sheet: &Sheet, [x, y]: Point, ink: RGBAColor) -> Result<(), FigureError> {
        let at = |corners: &[Point]| corners.iter().map(|[dx, dy]| [x + dx, y + dy]).collect::<Vec<Point>>();
        match self {
            Self::Circle => sheet.disc([x, y], 5.0, ink),
            Self::Square => sheet.polygon(&at(&[[-4.5, -4.5], [4.5, -4.5], [4.5, 4.5], [-4.5, 4.5]]), ink),
            Self::Triangle => sheet.polygon(&at(&[[0.0, -6.4], [5.8, 4.6], [-5.8, 4.6]]), ink),
            Self::Diamond => sheet.polygon(&at(&[[0.0, -6.4], [6.4, 0.0], [0.0, 6.4], [-6.4, 0.0]]), ink),
            Self::Cross => {
                sheet.line(&at(&[[-4.8, -4.8], [4.8, 4.8]]), pen(ink, 2.2))?;
                sheet.line(&at(&[[-4.8, 4.8], [4.8, -4.8]]), pen(ink, 2.2))
            }
            Self::Node => sheet.disc([x, y], 4.0, ink),
            Self::Clamp => {
                sheet.line(&at(&[[0.0, 0.0], [-14.0, 8.0], [-14.0, -8.0], [0.0, 0.0]]), pen(ink, 1.6))?;
                sheet.line(&at(&[[-14.0, -11.0], [-14.0, 11.0]]), pen(ink, 1.6))?;
                let hatching = [-8.5, -3.0, 2.5, 8.0].map(|down| at(&[[-14.0, down], [-22.0, down + 5.0]]));
                hatching.iter().try_for_each(|line| sheet.line(line, pen(ink, 1.2)))?;
                sheet.disc([x, y], 4.0, ink)
            }
        }
    }
}

/// Draws an arrow with its head at the point `to`.
pub(super) fn arrow(sheet: &Sheet, [from, to]: [Point; 2], ink: RGBAColor) -> Result<(), FigureError> {
    let Some(forward) = direction(from, to) else { return Ok(()) };
    // The head of a short arrow is smaller, so that its shaft stays visible. The shaft ends inside the head.
    let head = 13.0_f64.min(distance(from, to) * 0.6);
    let (neck, across) = (along(to, forward, -head), [-forward[1], forward[0]]);
    sheet.line(&[from, along(to, forward, -head * 0.8)], pen(ink, 2.6))?;
    sheet.polygon(&[to, along(neck, across, head * 0.42), along(neck, across, -head * 0.42)], ink)
}
