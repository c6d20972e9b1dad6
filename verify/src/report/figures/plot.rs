//! The plotting area with its heading, axes, grid and tick labels.

use plotters::style::text_anchor::{HPos, VPos};

use super::axis::{Ruler, Scale, Tick};
use super::canvas::{Canvas, Pen, Words};
use super::colour::Ink;
use super::error::FigureError;
use super::frame::{Frame, HEADING_TEXT, LABEL_TEXT, Point, TICK_TEXT};
use super::stroke::Area;
use super::text::{width_of, wrap};

/// Room between things that stand next to each other.
pub(super) const SPACE: f64 = 8.0;
const LINE: f64 = 1.3;
const TICK_LENGTH: f64 = 5.0;

/// The heading's lines and the room they take.
pub(super) struct Heading {
    lines: Vec<String>,
}

impl Heading {
    pub(super) fn new(frame: &Frame) -> Self {
        // Bold letters are wider than the estimate for plain ones.
        let lines = wrap(&frame.title, HEADING_TEXT * 1.08, frame.width - 2.0 * SPACE);
        Self { lines }
    }

    pub(super) fn height(&self) -> f64 {
        if self.lines.is_empty() {
            return SPACE;
        }
        self.lines.len() as f64 * HEADING_TEXT * LINE + SPACE
    }

    pub(super) fn draw(&self, canvas: &mut Canvas) -> Result<(), FigureError> {
        for (index, line) in self.lines.iter().enumerate() {
            let at = [SPACE, (index as f64 + 0.5) * HEADING_TEXT * LINE];
            let words = Words::new(line, at, HEADING_TEXT).anchored(HPos::Left, VPos::Center);
            canvas.words(Words { bold: true, ..words })?;
        }
        Ok(())
    }
}

/// One side of the plot: what it measures, from where to where, and its marks.
pub(super) struct Side {
    pub(super) label: String,
    pub(super) scale: Scale,
    pub(super) span: [f64; 2],
    pub(super) ticks: Vec<Tick>,
}

impl Side {
    /// Widest tick label.
    pub(super) fn widest(&self) -> f64 {
        self.ticks.iter().map(|tick| width_of(&tick.label, TICK_TEXT)).fold(0.0, f64::max)
    }
}

/// Room left of the plot for the labels of the upright axis.
pub(super) fn left_margin(y: &Side) -> f64 {
    (y.widest() + TICK_LENGTH + 2.0 * SPACE).max(30.0)
}

/// Height of the label above the upright axis.
pub(super) const Y_LABEL_HEIGHT: f64 = LABEL_TEXT * LINE + SPACE * 1.5;
/// Room below the plot for tick labels and the level axis's label.
pub(super) const X_LABELS_HEIGHT: f64 = TICK_LENGTH + TICK_TEXT * LINE + LABEL_TEXT * LINE + SPACE;

/// How many ticks a side of this many pixels takes without crowding.
pub(super) fn most_ticks(pixels: f64, spacing: f64) -> usize {
    ((pixels / spacing).floor() as usize).clamp(2, 12)
}

/// A plotting area and its two rulers.
pub(super) struct Plot {
    pub(super) area: Area,
    pub(super) x: Ruler,
    pub(super) y: Ruler,
}

impl Plot {
    pub(super) fn new(area: Area, x: &Side, y: &Side) -> Self {
        Self {
            area,
            x: Ruler::new(x.scale, x.span, [area.left, area.right]),
            y: Ruler::new(y.scale, y.span, [area.bottom, area.top]),
        }
    }

    /// Where a point of the data lies on the sheet.
    pub(super) fn place(&self, [x, y]: Point) -> Point {
        [self.x.place(x), self.y.place(y)]
    }

    /// Faint lines at the ticks, across the plot.
    pub(super) fn draw_grid(&self, canvas: &mut Canvas, x: &[Tick], y: &[Tick]) -> Result<(), FigureError> {
        let pen = Pen::new(Ink::Text, 1.0).faint(0.14);
        for tick in x {
            let place = self.x.place(tick.value);
            canvas.line(&[[place, self.area.top], [place, self.area.bottom]], pen)?;
        }
        for tick in y {
            let place = self.y.place(tick.value);
            canvas.line(&[[self.area.left, place], [self.area.right, place]], pen)?;
        }
        Ok(())
    }

    /// Outline, ticks, tick labels and axis labels.
    pub(super) fn draw_axes(&self, canvas: &mut Canvas, x: &Side, y: &Side) -> Result<(), FigureError> {
        let area = self.area;
        canvas.line(&area.outline(), Pen::new(Ink::Text, 1.2).faint(0.65))?;
        let pen = Pen::new(Ink::Text, 1.2).faint(0.65);
        let below = area.bottom + TICK_LENGTH;
        // Labels that would touch the one before are left out; their ticks stay.
        let mut free_from = f64::NEG_INFINITY;
        for tick in &x.ticks {
            let place = self.x.place(tick.value);
            canvas.line(&[[place, area.bottom], [place, below]], pen)?;
            let half = width_of(&tick.label, TICK_TEXT) / 2.0;
            if place - half >= free_from {
                let words = Words::new(&tick.label, [place, below + 3.0], TICK_TEXT);
                canvas.words(words.anchored(HPos::Center, VPos::Top))?;
                free_from = place + half + SPACE;
            }
        }
        let mut free_below = f64::INFINITY;
        for tick in &y.ticks {
            let place = self.y.place(tick.value);
            canvas.line(&[[area.left - TICK_LENGTH, place], [area.left, place]], pen)?;
            if place + TICK_TEXT / 2.0 <= free_below {
                let at = [area.left - TICK_LENGTH - SPACE / 2.0, place];
                let words = Words::new(&tick.label, at, TICK_TEXT);
                canvas.words(words.anchored(HPos::Right, VPos::Center))?;
                free_below = place - TICK_TEXT * 0.6;
            }
        }
        let x_label = [(area.left + area.right) / 2.0, below + TICK_TEXT * LINE + LABEL_TEXT * 0.65];
        canvas.words(Words::new(&x.label, x_label, LABEL_TEXT))
    }

    /// The upright axis's label, written level above the plot so that nobody tilts the head.
    pub(super) fn draw_y_label(&self, canvas: &mut Canvas, label: &str, bottom: f64) -> Result<(), FigureError> {
        let at = [SPACE, bottom - Y_LABEL_HEIGHT + LABEL_TEXT * 0.65];
        let words = Words::new(label, at, LABEL_TEXT);
        canvas.words(words.anchored(HPos::Left, VPos::Center))
    }
}
