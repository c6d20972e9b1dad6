//! Maps: coloured cells over two quantities, as a single plot or small multiples.

use plotters::style::Color;

use super::axis::Axis;
use super::cells::{Cells, edges};
use super::colour::{ON_MAP, TEXT};
use super::error::{FigureError, require, require_len};
use super::geometry::Area;
use super::legend::Entry;
use super::panels::{Frame, Panels, Plot};
use super::shades::{self, Class, class};
use super::sheet::{LEFT, SPACE, Sheet, TICK_TEXT, font, pen};
use super::text::{width_of, wrap};

/// Cells over two quantities, in a single plot or in rows and columns of small plots.
#[derive(Debug, Clone)]
pub struct Map {
    /// Heading, description and size of the figure.
    pub frame: Frame,
    /// Horizontal axis; an axis without given limits ends at the outermost cells.
    pub x: Axis,
    /// Vertical axis of every plot.
    pub y: Axis,
    /// Classes of the values, in ascending order.
    pub classes: Vec<Class>,
    /// Cells of each plot, row by row; `None` for a plot without data.
    pub plots: Vec<Option<Cells>>,
    /// Names of the rows of small plots; empty for a single plot.
    pub rows: Vec<String>,
    /// Names of the columns of small plots; empty for a single plot.
    pub columns: Vec<String>,
    /// Text in the legend for cells without a value, for instance "no equilibrium"; these cells are hatched.
    pub missing_label: String,
    /// Text in the legend for the parts of the plots that have no cells, for instance "not computed"; these parts are shaded. Empty: they stay blank.
    pub rest_label: String,
    /// An additional axis along the top, for instance node numbers.
    pub top: Option<Axis>,
    /// Format of the values written into the cells; `None` writes no values.
    pub written: Option<fn(f64) -> String>,
    /// Whether the cell at a row and column has no meaning and is left blank.
    pub blank: fn(usize, usize) -> bool,
}

const SMALL_HEIGHT: f64 = 104.0;
const NOTE_TEXT: f64 = 15.0;
const NOTE_LINE: f64 = NOTE_TEXT * 1.3;
/// Overlap of neighbouring cells, px. Without the overlap, printers leave fine gaps between the cells.
const OVERLAP: f64 = 1.0;
/// Opacity of the parts of a plot that have no cells.
const REST: f64 = 0.1;

impl Map {
    /// A map whose plots have no names of rows and columns, no values in the cells and no second axis.
    pub fn new(frame: Frame, [x, y]: [Axis; 2], classes: Vec<Class>, plots: Vec<Option<Cells>>) -> Self {
        Self {
            frame,
            x,
            y,
            classes,
            plots,
            rows: Vec::new(),
            columns: Vec::new(),
            missing_label: String::new(),
            rest_label: String::new(),
            top: None,
            written: None,
            blank: |_, _| false,
        }
    }

    /// Draws the map as SVG.
    ///
    /// # Errors
    /// [`FigureError`] if there is nothing to draw, or if lists have different lengths.
    pub fn svg(&self) -> Result<String, FigureError> {
        self.check()?;
        let cells: Vec<&Cells> = self.plots.iter().flatten().collect();
        let reach = |axis: &Axis, positions: fn(&Cells) -> &[f64]| {
            let edges: Vec<f64> = cells.iter().flat_map(|cells| edges(positions(cells), axis.limits)).collect();
            let [low, high] = [f64::min, f64::max].map(|of| edges.iter().copied().reduce(of).unwrap_or(0.0));
            Axis { limits: axis.limits.or(Some([low, high])), ..axis.clone() }
        };
        let axes = [reach(&self.x, |cells| &cells.x), reach(&self.y, |cells| &cells.y)];
        let mut panels = Panels::new(&self.frame, [&axes[0], &axes[1]]);
        (panels.grid, panels.rows, panels.columns, panels.legend) =
            ([false; 2], &self.rows, &self.columns, self.legend());
        panels.sides[1] = if self.columns.is_empty() { 4.0 * SPACE } else { 2.0 * SPACE };
        // Notes are as wide as their plots. The space above every plot is enough for the longest note.
        let note_width = (self.frame.width - 160.0) / self.columns.len().max(1) as f64 - 2.0 * SPACE;
        let notes: Vec<Vec<String>> = (self.plots.iter())
            .map(|plot| plot.as_ref().map_or(Vec::new(), |cells| wrap(&cells.note, NOTE_TEXT, note_width)))
            .collect();
        panels.above = notes.iter().map(Vec::len).max().unwrap_or(0) as f64 * NOTE_LINE;
        if !self.rows.is_empty() {
            panels.height = SMALL_HEIGHT;
        }
        if let Some(top) = &self.top {
            panels.top = Some(top);
            panels.sides[0] = width_of(&top.label, TICK_TEXT) + 2.0 * SPACE;
        }
        panels.draw(|sheet, plots| {
            for ((plot, cells), note) in plots.iter().zip(&self.plots).zip(&notes) {
                for (index, line) in note.iter().rev().enumerate() {
                    sheet.words(
                        line,
                        [plot.area.left, plot.area.top - (index as f64 + 0.6) * NOTE_LINE],
                        &font(NOTE_TEXT).pos(LEFT),
                    )?;
                }
                // A plot without data shows a dash, unlike a plot whose cells have no values.
                let Some(cells) = cells else {
                    sheet.words("–", plot.area.centre(), &font(TICK_TEXT))?;
                    continue;
                };
                if !self.rest_label.is_empty() {
                    sheet.cell(plot.area, TEXT.mix(REST))?;
                }
                self.fill(sheet, plot, cells)?;
            }
            Ok(())
        })
    }

    /// Fills the cells row by row, combines neighbours of one class into one rectangle, and hatches cells without a value.
    fn fill(&self, sheet: &Sheet, plot: &Plot, cells: &Cells) -> Result<(), FigureError> {
        let columns = edges(&cells.x, self.x.limits);
        for (row, (values, ys)) in cells.values.iter().zip(edges(&cells.y, self.y.limits).windows(2)).enumerate() {
            let shown = values.iter().enumerate().map(|(column, value)| {
                let paint = value.map(|value| {
                    let Class { fill, sign, .. } = class(&self.classes, value);
                    (*fill, self.written.map_or_else(|| sign.clone(), |written| written(value)))
                });
                (paint, (self.blank)(row, column), self.written.map_or(0, |_| column))
            });
            let mut first = 0;
            for run in shown.collect::<Vec<_>>().chunk_by(|a, b| a == b) {
                let corners =
                    [[columns[first], ys[0]], [columns[first + run.len()], ys[1]]].map(|corner| plot.at(corner));
                let mut area = Area::between(corners[0], corners[1]);
                let (centre, room) = (area.centre(), area.width().min(area.height()));
                area.right = (area.right + OVERLAP).min(plot.area.right);
                area.bottom = (area.bottom + OVERLAP).min(plot.area.bottom);
                first += run.len();
                match &run[0] {
                    (_, true, _) => {}
                    (None, ..) => sheet.hatch(area, true)?,
                    (Some((fill, text)), ..) => {
                        fill.draw(sheet, area)?;
                        if room >= TICK_TEXT * 0.8 && !text.is_empty() {
                            let size = if self.written.is_some() { 14.0 } else { TICK_TEXT };
                            sheet.words(text, centre, &font(size).color(&ON_MAP))?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn check(&self) -> Result<(), FigureError> {
        require(self.plots.iter().any(Option::is_some), FigureError::Empty, "map")?;
        require_len("plots of a map", &self.plots, self.rows.len().max(1) * self.columns.len().max(1))?;
        self.plots.iter().flatten().try_for_each(Cells::check)?;
        shades::check(&self.classes, self.values().flatten().fold(0.0, f64::max))
    }

    /// The values of all cells that are not left blank; `None` for a missing value.
    fn values(&self) -> impl Iterator<Item = Option<f64>> {
        let rows = self.plots.iter().flatten().flat_map(|cells| cells.values.iter().enumerate());
        let values =
            rows.flat_map(|(row, values)| values.iter().enumerate().map(move |(column, value)| (row, column, value)));
        values.filter(|(row, column, _)| !(self.blank)(*row, *column)).map(|(.., value)| *value)
    }

    fn legend(&self) -> Vec<Entry<'_>> {
        let mut entries = shades::legend(&self.classes, self.values().flatten());
        if self.values().any(|value| value.is_none()) {
            entries.push(Entry::new(&self.missing_label, |sheet, area| {
                let patch = Area::about(area.centre(), 26.0, 15.0);
                sheet.hatch(patch, true)?;
                sheet.line(&patch.outline(), pen(TEXT.mix(0.6), 1.0))
            }));
        }
        entries.push(Entry::patch(&self.rest_label, TEXT.mix(REST)));
        entries
    }
}
