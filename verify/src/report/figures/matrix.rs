//! A square of values over pairs: one half for each of two things that are to be compared.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, Pen, Words, draw};
use super::colour::{ColourScale, Ink};
use super::colour_bar::{self, ColourBar};
use super::error::{FigureError, require_finite, require_len};
use super::frame::{Frame, LABEL_TEXT, TICK_TEXT};
use super::marks::hatch;
use super::plot::{Heading, SPACE};
use super::stroke::Area;

/// Values of pairs of things, twice: above and below the diagonal.
#[derive(Debug, Clone, PartialEq)]
pub struct PairMatrix {
    /// Heading, description and size.
    pub frame: Frame,
    /// Names of the things, along both sides.
    pub names: Vec<String>,
    /// What stands above the diagonal, and what below it.
    pub halves: [String; 2],
    /// By row, then column; none where there is no value, and on the diagonal.
    pub cells: Vec<Vec<Option<PairCell>>>,
    /// What the colours mean.
    pub value_label: String,
    /// Which value has which colour.
    pub colours: ColourScale,
    /// Values that are marked on the colour bar.
    pub levels: Vec<f64>,
}

/// A value, and how it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct PairCell {
    /// Decides the colour.
    pub value: f64,
    /// Written into the cell.
    pub text: String,
}

const CELL_TEXT: f64 = 14.0;
/// Colours up to this fraction of the scale are dark.
const DARK: f64 = 0.6;
const ON_DARK: Ink = Ink::Rgb([255, 255, 255]);
const ON_LIGHT: Ink = Ink::Rgb([0x14, 0x17, 0x1a]);
const NAME_ROOM: f64 = 30.0;
const LABEL_ROOM: f64 = LABEL_TEXT * 1.6;

/// Draws the matrix.
///
/// # Errors
/// [`FigureError`] for rows of another length than the names, and values that are no numbers.
pub fn pair_matrix(matrix: &PairMatrix) -> Result<String, FigureError> {
    matrix.frame.check()?;
    matrix.colours.check()?;
    let count = matrix.names.len();
    require_len("rows of pairs", &matrix.cells, count)?;
    for row in &matrix.cells {
        require_len("a row of pairs", row, count)?;
        require_finite("pairs", row.iter().flatten().map(|cell| &cell.value))?;
    }
    let heading = Heading::new(&matrix.frame);
    // Room for half of the last label of the colour bar.
    let (left, right) = (NAME_ROOM + SPACE, matrix.frame.width - 2.5 * SPACE);
    let top = heading.height() + LABEL_ROOM + NAME_ROOM;
    let side = right - left;
    let bar_top = top + side + LABEL_ROOM + SPACE;
    let values = || matrix.cells.iter().flatten().flatten().map(|cell| cell.value);
    let [low, high] = matrix.colours.limits;
    let beyond = [values().any(|value| value < low), values().any(|value| value > high)];
    let bar = ColourBar { label: &matrix.value_label, colours: matrix.colours, beyond };
    draw(&matrix.frame, bar_top + colour_bar::HEIGHT + SPACE, |canvas| {
        heading.draw(canvas)?;
        let area = Area { left, right, top, bottom: top + side };
        draw_cells(canvas, matrix, area)?;
        let above = Words::new(&matrix.halves[0], [right, heading.height() + LABEL_ROOM / 2.0], LABEL_TEXT);
        canvas.words(above.anchored(HPos::Right, VPos::Center))?;
        let below = Words::new(&matrix.halves[1], [left, area.bottom + LABEL_ROOM / 2.0], LABEL_TEXT);
        canvas.words(below.anchored(HPos::Left, VPos::Center))?;
        bar.draw(canvas, &matrix.levels, [left, right], bar_top)
    })
}

fn draw_cells(canvas: &mut Canvas, matrix: &PairMatrix, area: Area) -> Result<(), FigureError> {
    let step = (area.right - area.left) / matrix.names.len().max(1) as f64;
    let cell = |row: usize, column: usize| Area {
        left: area.left + step * column as f64,
        right: area.left + step * (column + 1) as f64,
        top: area.top + step * row as f64,
        bottom: area.top + step * (row + 1) as f64,
    };
    let middle = |area: Area| [(area.left + area.right) / 2.0, (area.top + area.bottom) / 2.0];
    for (i, name) in matrix.names.iter().enumerate() {
        let [x, y] = middle(cell(i, i));
        canvas.words(Words::new(name, [x, area.top - NAME_ROOM / 2.0], TICK_TEXT))?;
        canvas.words(Words::new(name, [area.left - NAME_ROOM / 2.0, y], TICK_TEXT))?;
    }
    for (row, cells) in matrix.cells.iter().enumerate() {
        for (column, value) in cells.iter().enumerate().filter(|(column, _)| *column != row) {
            let area = cell(row, column);
            match value {
                Some(value) => {
                    canvas.cell(area, matrix.colours.ink(value.value))?;
                    let ink = if matrix.colours.fraction(value.value) < DARK { ON_DARK } else { ON_LIGHT };
                    canvas.words(Words::new(&value.text, middle(area), CELL_TEXT).inked(ink))?;
                }
                None => hatch(canvas, area)?,
            }
        }
    }
    canvas.line(&area.outline(), Pen::new(Ink::Text, 1.2).faint(0.65))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix() -> PairMatrix {
        let cell = |row: usize, column: usize| {
            let value = 1.0 + row as f64 + 0.1 * column as f64;
            (row != column).then(|| PairCell { value, text: format!("{value:.1}") })
        };
        PairMatrix {
            frame: Frame::half("Errors", "errors of pairs"),
            names: (0..3).map(|n| format!("n{n}")).collect(),
            halves: ["above: one".into(), "below: the other".into()],
            cells: (0..3).map(|row| (0..3).map(|column| cell(row, column)).collect()).collect(),
            value_label: "error, %".into(),
            colours: ColourScale::log(0.1, 10.0),
            levels: vec![1.0],
        }
    }

    #[test]
    fn every_pair_is_drawn_and_written_in_both_halves() {
        let svg = pair_matrix(&matrix()).unwrap();
        assert_eq!(svg.matches("<rect ").count() - colour_bar::STEPS, 6);
        for text in ["1.1", "1.2", "2.0", "2.2", "3.0", "3.1", "above: one", "below: the other", "n2"] {
            assert!(svg.contains(text), "{text}");
        }
    }

    #[test]
    fn rows_that_do_not_fit_the_names_are_refused() {
        let mut short = matrix();
        short.cells[1].pop();
        assert!(matches!(pair_matrix(&short), Err(FigureError::Mismatch { expected: 3, found: 2, .. })));
    }
}
