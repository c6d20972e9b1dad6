//! The bar that says which value has which colour.

use super::axis::Axis;
use super::error::FigureError;
use super::geometry::Area;
use super::panels::Plot;
use super::shades::ColourScale;
use super::sheet::{Dash, LABEL_TEXT, LEFT, SPACE, Sheet, TICK_TEXT, axis_pen, font};

const LABEL: f64 = LABEL_TEXT * 1.5;
const BAR: f64 = 18.0;
const TICKS: f64 = SPACE + TICK_TEXT * 1.4;
/// Height of label, bar and tick labels together, px.
pub(super) const HEIGHT: f64 = LABEL + BAR + TICKS + SPACE;
/// Steps of colour; so many that none is seen as a step.
pub(super) const STEPS: usize = 64;

/// Draws the bar below `top`, as wide as a plot, with levels marked. Its ends say where values lie `beyond` them.
pub(super) fn draw(
    sheet: &Sheet,
    plot: Area,
    top: f64,
    (colours, label): (&ColourScale, &str),
    levels: &[f64],
    beyond: [bool; 2],
) -> Result<(), FigureError> {
    sheet.words(label, [plot.left, top + LABEL * 0.45], &font(LABEL_TEXT).pos(LEFT))?;
    let area = Area { top: top + LABEL, bottom: top + LABEL + BAR, ..plot };
    let mut ruler = Axis::log("").within(colours.limits[0], colours.limits[1]).ruler(&[], area.width(), false)?;
    for (value, name) in &mut ruler.ticks {
        for (end, sign) in [(0, "≤ "), (1, "≥ ")] {
            if beyond[end] && (*value - colours.limits[end]).abs() <= 1e-9 * value.abs() {
                name.insert_str(0, sign);
            }
        }
    }
    let at = |part: f64| area.left + part * area.width();
    for step in 0..STEPS {
        let [from, to] = [step, step + 1].map(|step| step as f64 / STEPS as f64);
        // A pixel over, as printers leave hairlines between areas that only touch.
        let cell = Area { left: at(from), right: (at(to) + 1.0).min(area.right), ..area };
        sheet.cell(cell, ColourScale::at((from + to) / 2.0))?;
    }
    for x in levels.iter().map(|level| at(colours.fraction(*level))) {
        sheet.contour(&[[x, area.top], [x, area.bottom]], Dash::Solid)?;
    }
    sheet.line(&area.outline(), axis_pen())?;
    let upright = Axis::linear("").within(0.0, 1.0).with_ticks([]).ruler(&[], BAR, true)?;
    Plot::new(sheet, area, [ruler, upright], [0.0, 0.0, TICKS], [false; 2]).map(|_| ())
}
