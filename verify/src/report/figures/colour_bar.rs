//! The bar that says which value has which colour.

use plotters::style::text_anchor::{HPos, VPos};

use super::axis::{Ruler, ticks};
use super::canvas::{Canvas, Pen, Words};
use super::colour::{ColourScale, Ink, viridis};
use super::error::FigureError;
use super::frame::{LABEL_TEXT, TICK_TEXT};
use super::plot::most_ticks;
use super::stroke::Area;

/// Height of label, bar and tick labels together.
pub(super) const HEIGHT: f64 = LABEL_HEIGHT + BAR_HEIGHT + TICKS_HEIGHT;
const LABEL_HEIGHT: f64 = LABEL_TEXT * 1.5;
const BAR_HEIGHT: f64 = 18.0;
const TICKS_HEIGHT: f64 = 6.0 + TICK_TEXT * 1.4;
/// Steps of colour; so many that none is seen as a step.
pub(super) const STEPS: usize = 64;

/// A colour scale with its meaning.
pub(super) struct ColourBar<'a> {
    pub(super) label: &'a str,
    pub(super) colours: ColourScale,
    /// Whether values lie below the lowest and above the highest colour.
    pub(super) beyond: [bool; 2],
}

impl ColourBar<'_> {
    /// Draws the bar between two places across, below `top`, with the contour levels marked.
    pub(super) fn draw(
        &self,
        canvas: &mut Canvas,
        levels: &[f64],
        [left, right]: [f64; 2],
        top: f64,
    ) -> Result<(), FigureError> {
        let label = Words::new(self.label, [left, top + LABEL_HEIGHT * 0.45], LABEL_TEXT);
        canvas.words(label.anchored(HPos::Left, VPos::Center))?;
        let bar = Area { left, right, top: top + LABEL_HEIGHT, bottom: top + LABEL_HEIGHT + BAR_HEIGHT };
        let place = |part: f64| left + part * (right - left);
        for step in 0..STEPS {
            let [from, to] = [step, step + 1].map(|step| step as f64 / STEPS as f64);
            let area = Area {
                left: place(from),
                // A pixel over, as printers leave hairlines between areas that only touch.
                right: (place(to) + 1.0).min(right),
                ..bar
            };
            canvas.cell(area, Ink::Rgb(viridis((from + to) / 2.0)))?;
        }
        for level in levels {
            let x = place(self.colours.fraction(*level));
            let line = [[x, bar.top], [x, bar.bottom]];
            canvas.line(&line, Pen::new(Ink::Rgb([0x14, 0x17, 0x1a]), 4.0))?;
            canvas.line(&line, Pen::new(Ink::Rgb([255, 255, 255]), 1.8))?;
        }
        let pen = Pen::new(Ink::Text, 1.2).faint(0.65);
        canvas.line(&bar.outline(), pen)?;
        self.draw_ticks(canvas, bar)
    }

    fn draw_ticks(&self, canvas: &mut Canvas, bar: Area) -> Result<(), FigureError> {
        let colours = self.colours;
        let ruler = Ruler::new(colours.scale, colours.limits, [bar.left, bar.right]);
        let marks = ticks(colours.scale, colours.limits, most_ticks(bar.right - bar.left, 90.0));
        let near = |value: f64, end: f64| (value - end).abs() <= 1e-9 * end.abs();
        for tick in marks {
            let x = ruler.place(tick.value);
            let below = bar.bottom + 5.0;
            let pen = Pen::new(Ink::Text, 1.2).faint(0.65);
            canvas.line(&[[x, bar.bottom], [x, below]], pen)?;
            // An end's colour also stands for everything beyond it.
            let sign = if self.beyond[0] && near(tick.value, colours.limits[0]) {
                "≤ "
            } else if self.beyond[1] && near(tick.value, colours.limits[1]) {
                "≥ "
            } else {
                ""
            };
            let text = format!("{sign}{}", tick.label);
            let words = Words::new(&text, [x, below + 3.0], TICK_TEXT);
            canvas.words(words.anchored(HPos::Center, VPos::Top))?;
        }
        Ok(())
    }
}
