//! What lies on a map: cells, lines of equal value, and marks along the top.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, Pen, Words};
use super::colour::Ink;
use super::contour::contour;
use super::error::FigureError;
use super::frame::{Point, TICK_TEXT};
use super::heat_map::HeatMap;
use super::legend::contour_stroke;
use super::marks::hatch;
use super::plot::{Plot, SPACE};
use super::stroke::{Area, Dash, distance};
use super::text::{number, width_of};

/// How the line of the n-th level is broken.
pub(super) fn dash_of(level: usize) -> Dash {
    [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::DashDotted][level % 4]
}

/// How far cells reach under their neighbours: printers leave hairlines between
/// areas that only touch.
const OVERLAP: f64 = 1.0;

/// Fills the map, hatching the places without value.
pub(super) fn draw_cells(
    canvas: &mut Canvas,
    map: &HeatMap,
    plot: &Plot,
    columns: &[f64],
    rows: &[f64],
) -> Result<(), FigureError> {
    for (row, values) in map.values.iter().enumerate() {
        let ys = [rows[row], rows[row + 1]].map(|bound| plot.y.place(bound));
        let inks: Vec<Option<Ink>> = values.iter().map(|value| value.map(|value| map.colours.ink(value))).collect();
        let columns: Vec<f64> = columns.iter().map(|bound| plot.x.place(*bound)).collect();
        fill(canvas, &inks, &columns, ys, plot.area)?;
    }
    Ok(())
}

/// Fills one row of cells between their edges on the sheet; what has no ink is hatched.
pub(super) fn fill(
    canvas: &mut Canvas,
    inks: &[Option<Ink>],
    columns: &[f64],
    ys: [f64; 2],
    within: Area,
) -> Result<(), FigureError> {
    // Neighbours of one colour are drawn as one cell.
    let mut first = 0;
    for run in inks.chunk_by(|one, next| one == next) {
        let xs = [columns[first], columns[first + run.len()]];
        first += run.len();
        let area = Area {
            left: xs[0].min(xs[1]),
            right: (xs[0].max(xs[1]) + OVERLAP).min(within.right),
            top: ys[0].min(ys[1]),
            bottom: (ys[0].max(ys[1]) + OVERLAP).min(within.bottom),
        };
        match run[0] {
            Some(ink) => canvas.cell(area, ink)?,
            None => hatch(canvas, area)?,
        }
    }
    Ok(())
}

/// Draws and labels the lines of equal value.
pub(super) fn draw_contours(canvas: &mut Canvas, map: &HeatMap, plot: &Plot) -> Result<(), FigureError> {
    // Values run evenly along the colour scale, so lines are found there too.
    let measure = |value: f64| map.colours.evenly(value);
    let values: Vec<Vec<Option<f64>>> =
        map.values.iter().map(|row| row.iter().map(|value| value.map(measure)).collect()).collect();
    let mut labels: Vec<(Area, String)> = Vec::new();
    for (index, level) in map.contours.iter().enumerate() {
        let text = format!("{}{}", number(*level), map.contour_unit);
        let mut lines: Vec<Vec<Point>> = contour(&map.x, &map.y, &values, measure(*level))
            .into_iter()
            .map(|line| line.into_iter().map(|point| plot.place(point)).collect())
            .collect();
        lines.sort_by(|one, other| length(other).total_cmp(&length(one)));
        for line in &lines {
            contour_stroke(canvas, line, dash_of(index))?;
        }
        // Two labels a level are enough to read a map by; short loops need none.
        for line in lines.iter().filter(|line| length(line) > 130.0).take(2) {
            let taken: Vec<Area> = labels.iter().map(|(area, _)| *area).collect();
            if let Some(area) = label_area(line, &text, plot.area, &taken) {
                labels.push((area, text.clone()));
            }
        }
    }
    for (area, text) in &labels {
        let centre = [(area.left + area.right) / 2.0, (area.top + area.bottom) / 2.0];
        let words = Words::new(text, centre, TICK_TEXT).inked(Ink::OnMap);
        canvas.words(Words { bold: true, ..words })?;
    }
    Ok(())
}

fn length(line: &[Point]) -> f64 {
    line.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
}

/// A place on the line, as near its middle as can be, where the label fits and hides no other.
fn label_area(line: &[Point], text: &str, within: Area, taken: &[Area]) -> Option<Area> {
    let (width, height) = (width_of(text, TICK_TEXT) + 8.0, TICK_TEXT * 1.3);
    [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8]
        .iter()
        .map(|part| line[((line.len() - 1) as f64 * part).round() as usize])
        .map(|point| Area::about(point, width, height))
        .find(|area| {
            let inside = within.holds([area.left, area.top]) && within.holds([area.right, area.bottom]);
            inside && !taken.iter().any(|other| other.meets(area))
        })
}

/// Draws the marks along the top, leaving out names that would touch.
pub(super) fn draw_marks(canvas: &mut Canvas, map: &HeatMap, plot: &Plot) -> Result<(), FigureError> {
    if map.marks.is_empty() {
        return Ok(());
    }
    let (top, y) = (plot.area.top, plot.area.top - 8.0);
    let name = Words::new(&map.marks_label, [plot.area.left - SPACE, y], TICK_TEXT);
    canvas.words(name.anchored(HPos::Right, VPos::Bottom))?;
    let mut marks: Vec<(f64, &str)> = map
        .marks
        .iter()
        .map(|mark| (plot.x.place(mark.x), mark.label.as_str()))
        .filter(|(x, _)| *x >= plot.area.left - 0.5 && *x <= plot.area.right + 0.5)
        .collect();
    marks.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut free_from = f64::NEG_INFINITY;
    for (x, label) in marks {
        canvas.line(&[[x, top], [x, top - 6.0]], Pen::new(Ink::Text, 1.2).faint(0.65))?;
        let half = width_of(label, TICK_TEXT) / 2.0;
        if x - half >= free_from {
            let words = Words::new(label, [x, y], TICK_TEXT);
            canvas.words(words.anchored(HPos::Center, VPos::Bottom))?;
            free_from = x + half + 5.0;
        }
    }
    Ok(())
}
