//! Level lines across a chart at values worth comparing with.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, Pen, Words};
use super::colour::Ink;
use super::error::FigureError;
use super::frame::{Frame, TICK_TEXT};
use super::plot::{Plot, SPACE};
use super::stroke::Dash;
use super::text::{width_of, wrap};

/// A value that the data are to be compared with, drawn across the chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The value.
    pub value: f64,
    /// Its words, e.g. "10 %".
    pub label: String,
}

const LINE: f64 = TICK_TEXT * 1.2;

/// Words broken so that they take no more than a fifth of the figure.
fn broken(frame: &Frame, reference: &Reference) -> Vec<String> {
    wrap(&reference.label, TICK_TEXT, frame.width * 0.2)
}

/// Room right of the plot for the words, where they hide no data.
pub(super) fn right_margin(frame: &Frame, references: &[Reference]) -> f64 {
    references
        .iter()
        .flat_map(|reference| broken(frame, reference))
        .map(|line| width_of(&line, TICK_TEXT) + 2.0 * SPACE)
        .fold(3.0 * SPACE, f64::max)
}

/// Draws the lines, and their words right of the plot.
pub(super) fn draw_references(
    canvas: &mut Canvas,
    frame: &Frame,
    plot: &Plot,
    references: &[Reference],
) -> Result<(), FigureError> {
    let area = plot.area;
    let mut shown: Vec<(f64, Vec<String>)> = references
        .iter()
        .map(|reference| (plot.y.place(reference.value), broken(frame, reference)))
        .filter(|(y, _)| *y >= area.top - 0.5 && *y <= area.bottom + 0.5)
        .collect();
    shown.sort_by(|one, other| one.0.total_cmp(&other.0));
    let pen = Pen::new(Ink::Text, 1.6).faint(0.75).dashed(Dash::Dashed);
    // From top to bottom, words that would touch the ones above move down.
    let mut free_from = f64::NEG_INFINITY;
    for (y, lines) in shown {
        canvas.line(&[[area.left, y], [area.right, y]], pen)?;
        let first = (y - (lines.len() as f64 - 1.0) * LINE / 2.0).max(free_from);
        for (index, line) in lines.iter().enumerate() {
            let at = [area.right + SPACE, first + index as f64 * LINE];
            let words = Words::new(line, at, TICK_TEXT);
            canvas.words(words.anchored(HPos::Left, VPos::Center))?;
        }
        free_from = first + lines.len() as f64 * LINE;
    }
    Ok(())
}
