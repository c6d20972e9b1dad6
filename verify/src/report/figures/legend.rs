//! The legend: samples with words, set in rows below the plot, where they hide no data.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, Pen, Words};
use super::colour::Ink;
use super::error::FigureError;
use super::frame::TICK_TEXT;
use super::marks::{self, Marker};
use super::stroke::Area;
use super::text::{width_of, wrap};

/// What stands before the words.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sample {
    /// A piece of a line, with its marker; either may be missing.
    Series(Option<Pen>, Option<Marker>, Ink),
    /// A light line on a dark one, as drawn over a map.
    Contour(super::stroke::Dash),
    /// A filled patch.
    Patch(Ink),
    /// A hatched patch.
    Hatch,
    /// A node's dot.
    Node,
    /// A clamp.
    Clamp,
}

/// Width of a sample and the gap after it.
const SAMPLE: f64 = 38.0;
const GAP: f64 = 8.0;
const BETWEEN: f64 = 24.0;
const ROW: f64 = 24.0;

/// Entries with their places, ready to draw.
pub(super) struct Legend {
    entries: Vec<Placed>,
    rows: usize,
}

struct Placed {
    sample: Sample,
    lines: Vec<String>,
    x: f64,
    row: usize,
}

impl Legend {
    /// Sets the entries in rows between `left` and `right`.
    pub(super) fn lay_out(entries: &[(Sample, String)], left: f64, right: f64) -> Self {
        let mut placed = Vec::new();
        // `row` is the row being filled, `next` the first one below everything in it.
        let (mut x, mut row, mut next) = (left, 0, 0);
        for (sample, text) in entries {
            let lines = wrap(text, TICK_TEXT, right - left - SAMPLE - GAP);
            if lines.is_empty() {
                continue;
            }
            let widest = lines.iter().map(|line| width_of(line, TICK_TEXT)).fold(0.0, f64::max);
            let width = SAMPLE + GAP + widest;
            if x > left && x + width > right {
                (x, row) = (left, next);
            }
            next = next.max(row + lines.len());
            let sample = *sample;
            placed.push(Placed { sample, lines, x, row });
            x += width + BETWEEN;
        }
        Self { entries: placed, rows: next }
    }

    /// Height of all rows.
    pub(super) fn height(&self) -> f64 {
        self.rows as f64 * ROW
    }

    /// Draws the rows below `top`.
    pub(super) fn draw(&self, canvas: &mut Canvas, top: f64) -> Result<(), FigureError> {
        for entry in &self.entries {
            let y = top + (entry.row as f64 + 0.5) * ROW;
            draw_sample(canvas, entry.sample, entry.x, y)?;
            for (index, line) in entry.lines.iter().enumerate() {
                let at = [entry.x + SAMPLE + GAP, y + index as f64 * ROW];
                let words = Words::new(line, at, TICK_TEXT).anchored(HPos::Left, VPos::Center);
                canvas.words(words)?;
            }
        }
        Ok(())
    }
}

/// Draws a line that shows on every colour of a map: light on dark.
pub(super) fn contour_stroke(
    canvas: &mut Canvas,
    points: &[super::frame::Point],
    dash: super::stroke::Dash,
) -> Result<(), FigureError> {
    canvas.line(points, Pen::new(Ink::Rgb([0x14, 0x17, 0x1a]), 4.6))?;
    let light = Pen::new(Ink::Rgb([255, 255, 255]), 2.2);
    canvas.line(points, light.dashed(dash))
}

fn draw_sample(canvas: &mut Canvas, sample: Sample, x: f64, y: f64) -> Result<(), FigureError> {
    let centre = [x + SAMPLE / 2.0, y];
    let ends = [[x, y], [x + SAMPLE, y]];
    let patch = Area::about(centre, 26.0, 15.0);
    match sample {
        Sample::Series(pen, sign, ink) => {
            if let Some(pen) = pen {
                canvas.line(&ends, pen)?;
            }
            match sign {
                Some(sign) => marks::marker(canvas, sign, centre, ink),
                None => Ok(()),
            }
        }
        Sample::Contour(dash) => contour_stroke(canvas, &ends, dash),
        Sample::Patch(ink) => canvas.cell(patch, ink),
        Sample::Hatch => {
            marks::hatch(canvas, patch)?;
            canvas.line(&patch.outline(), Pen::new(Ink::Text, 1.0).faint(0.6))
        }
        Sample::Node => canvas.disc(centre, 4.0, Ink::Text),
        Sample::Clamp => marks::clamp(canvas, [centre[0] + 8.0, y], [-1.0, 0.0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(texts: &[&str]) -> Vec<(Sample, String)> {
        texts.iter().map(|text| (Sample::Patch(Ink::Text), (*text).to_owned())).collect()
    }

    #[test]
    fn entries_go_on_in_the_next_row_when_one_is_full() {
        let legend = Legend::lay_out(&entries(&["one", "two", "three"]), 0.0, 200.0);
        let rows: Vec<usize> = legend.entries.iter().map(|entry| entry.row).collect();
        assert_eq!(rows, [0, 0, 1]);
        assert_eq!(legend.height(), 2.0 * ROW);
    }

    #[test]
    fn long_words_are_broken_and_push_the_next_entry_down() {
        let long = "a co-rotational solution with every node free to turn";
        let legend = Legend::lay_out(&entries(&[long, "next"]), 0.0, 260.0);
        let broken = legend.entries[0].lines.len();
        assert!(broken > 1);
        assert_eq!(legend.entries[1].row, broken);
    }
}
