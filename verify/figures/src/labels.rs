//! Places labels so that they hide neither lines nor other labels.

use super::colour::OVER_LINES;
use super::error::FigureError;
use super::geometry::{Area, Lines, Point, along, distance, segments};
use super::sheet::{Sheet, TICK_TEXT, font};
use super::text::width_of;

/// A text near a point.
pub(super) struct Label {
    /// Text of the label; an empty text is not drawn.
    pub(super) text: String,
    /// The point that the label names, px.
    pub(super) anchor: Point,
    /// Unit vector of the preferred direction from the anchor.
    pub(super) side: Point,
}

/// Lines and areas that labels should not cover.
pub(super) struct Obstacles {
    /// Lines on the sheet, px.
    pub(super) lines: Lines,
    /// Areas of symbols and earlier labels, px.
    pub(super) areas: Vec<Area>,
    /// Area in which labels must lie, px.
    pub(super) within: Area,
}

impl Obstacles {
    /// Writes each label in turn at the position with the least cost; later labels avoid the earlier ones.
    pub(super) fn write(&mut self, sheet: &Sheet, labels: &[Label]) -> Result<(), FigureError> {
        for label in labels.iter().filter(|label| !label.text.is_empty()) {
            sheet.words(&label.text, self.position(label), &font(TICK_TEXT).color(&OVER_LINES))?;
        }
        Ok(())
    }

    /// Centre of a label near its anchor, px: among the tried positions, the one with the least cost.
    fn position(&mut self, label: &Label) -> Point {
        let [width, height] = [width_of(&label.text, TICK_TEXT) + 4.0, TICK_TEXT + 2.0];
        let start = label.side[1].atan2(label.side[0]);
        let candidates = [5.0, 9.0, 14.0, 20.0, 28.0, 40.0].into_iter().flat_map(|gap| {
            (0..24).map(move |turn| {
                let (up, across) = (start + f64::from(turn) * std::f64::consts::TAU / 24.0).sin_cos();
                // With `reach`, the edge of the label, not its centre, is at the distance `gap` from the anchor.
                let reach = (across.abs() * width + up.abs() * height) / 2.0 - 1.0;
                along(label.anchor, [across, up], gap + reach)
            })
        });
        let costs = candidates.map(|at| (self.cost(label, Area::about(at, width, height)), at));
        let best = costs.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(label.anchor, |(_, at)| at);
        self.areas.push(Area::about(best, width, height));
        best
    }

    fn cost(&self, label: &Label, area: Area) -> f64 {
        let crossed = segments(&self.lines).filter(|[from, to]| area.clip(*from, *to).is_some()).count();
        let hidden = self.areas.iter().filter(|other| other.meets(&area)).count();
        let outside = f64::from(!self.within.holds(&area));
        let (at, from) = (area.centre(), label.anchor);
        let far = distance(from, at);
        let turned = 1.0 - ((at[0] - from[0]) * label.side[0] + (at[1] - from[1]) * label.side[1]) / far.max(1e-9);
        // Text is legible on top of a line, but not on top of other text. A label far from its anchor may seem to belong to another point.
        40.0 * crossed as f64 + 1000.0 * hidden as f64 + 1000.0 * outside + 2.0 * far + 18.0 * turned
    }
}
