//! Arrows with words: forces and directions.

use super::canvas::{Canvas, Words};
use super::colour::{Hue, Ink};
use super::error::FigureError;
use super::frame::{Point, TICK_TEXT};
use super::label_places::{Obstacles, Wish, place_labels};
use super::marks;
use super::plane::Plane;
use super::stroke::{Area, gap, unit};
use super::text::width_of;

/// An arrow with words.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrow {
    /// Where it begins, in millimetres.
    pub from: Point,
    /// Where its point lies, in millimetres.
    pub to: Point,
    /// What it is; no words are written when empty.
    pub label: String,
    /// Its colour.
    pub hue: Hue,
}

/// The places that arrows reach.
pub(super) fn arrow_ends(arrows: &[Arrow]) -> impl Iterator<Item = Point> {
    arrows.iter().flat_map(|arrow| [arrow.from, arrow.to])
}

/// Draws arrows, and their words where they hide nothing.
pub(super) fn draw_arrows(
    canvas: &mut Canvas,
    arrows: &[Arrow],
    plane: &Plane,
    lines: &[Vec<Point>],
    taken: &mut Vec<Area>,
) -> Result<(), FigureError> {
    let mut all_lines = lines.to_vec();
    let placed: Vec<[Point; 2]> =
        arrows.iter().map(|arrow| [arrow.from, arrow.to].map(|end| plane.plot.place(end))).collect();
    all_lines.extend(placed.iter().map(|ends| ends.to_vec()));
    let mut wishes = Vec::new();
    for (arrow, [from, to]) in arrows.iter().zip(&placed) {
        marks::arrow(canvas, *from, *to, arrow.hue.ink())?;
        // Words stand at the end that lies freer.
        let clear = |end: Point| {
            let pieces = lines.iter().flat_map(|line| line.windows(2));
            pieces.map(|pair| gap(end, pair)).fold(f64::INFINITY, f64::min)
        };
        let (anchor, other) = if clear(*from) >= clear(*to) { (from, to) } else { (to, from) };
        wishes.push(Wish {
            anchor: *anchor,
            side: unit([anchor[0] - other[0], anchor[1] - other[1]]).unwrap_or([0.0, -1.0]),
            width: width_of(&arrow.label, TICK_TEXT),
            height: TICK_TEXT,
        });
    }
    let obstacles = Obstacles { lines: &all_lines, areas: std::mem::take(taken), within: plane.plot.area };
    for (arrow, place) in arrows.iter().zip(place_labels(&wishes, obstacles)) {
        canvas.words(Words::new(&arrow.label, place, TICK_TEXT).inked(Ink::TextOverLines))?;
    }
    Ok(())
}
