//! The legend: samples with text, in rows below the plots, where they hide no data.

use plotters::style::Color;

use super::error::FigureError;
use super::geometry::Area;
use super::sheet::{LEFT, Sheet, TICK_TEXT, font};
use super::text::{widest, wrap};

/// Function that draws a sample of a line, symbol or colour into an area.
type Sample<'a> = Box<dyn Fn(&Sheet, Area) -> Result<(), FigureError> + 'a>;

/// An entry of the legend: a sample, and text to its right.
pub(super) struct Entry<'a> {
    text: String,
    sample: Sample<'a>,
}

impl<'a> Entry<'a> {
    pub(super) fn new(text: impl Into<String>, sample: impl Fn(&Sheet, Area) -> Result<(), FigureError> + 'a) -> Self {
        Self { text: text.into(), sample: Box::new(sample) }
    }

    /// An entry whose sample is an area of one colour.
    pub(super) fn patch(text: impl Into<String>, ink: impl Color + Copy + 'a) -> Self {
        Self::new(text, move |sheet, area| sheet.cell(Area::about(area.centre(), 26.0, 15.0), ink))
    }
}

const SAMPLE: f64 = 38.0;
const GAP: f64 = 8.0;
const BETWEEN: f64 = 24.0;
const ROW: f64 = 24.0;

/// Legend entries arranged in rows. Each entry has its sample, its lines of text, its left edge (px) and the index of its first row.
pub(super) struct Legend<'a> {
    entries: Vec<(Sample<'a>, Vec<String>, f64, usize)>,
    rows: usize,
}

impl<'a> Legend<'a> {
    /// Arranges the entries that have text in rows between the horizontal positions `left` and `right`, px.
    pub(super) fn lay_out(entries: Vec<Entry<'a>>, [left, right]: [f64; 2]) -> Self {
        let mut placed = Vec::new();
        // `row` is the current row of text; `next` is the first row below all entries of the current row.
        let (mut x, mut row, mut next) = (left, 0, 0);
        for Entry { text, sample } in entries.into_iter().filter(|entry| !entry.text.is_empty()) {
            let lines = wrap(&text, TICK_TEXT, right - left - SAMPLE - GAP);
            let width = SAMPLE + GAP + widest(&lines, TICK_TEXT);
            if x > left && x + width > right {
                (x, row) = (left, next);
            }
            next = next.max(row + lines.len());
            placed.push((sample, lines, x, row));
            x += width + BETWEEN;
        }
        Self { entries: placed, rows: next }
    }

    /// Height of the legend, px.
    pub(super) fn height(&self) -> f64 {
        self.rows as f64 * ROW
    }

    /// Draws the legend with its upper edge at `top`, px.
    pub(super) fn draw(&self, sheet: &Sheet, top: f64) -> Result<(), FigureError> {
        for (sample, lines, x, row) in &self.entries {
            let y = |line: usize| top + ((row + line) as f64 + 0.5) * ROW;
            sample(sheet, Area::about([x + SAMPLE / 2.0, y(0)], SAMPLE, 15.0))?;
            for (index, line) in lines.iter().enumerate() {
                sheet.words(line, [x + SAMPLE + GAP, y(index)], &font(TICK_TEXT).pos(LEFT))?;
            }
        }
        Ok(())
    }
}
