//! Maps: cells over two quantities in colours, alone or as small multiples.

use plotters::style::RGBColor;

use super::axis::{Axis, Scale};
use super::colour::{ColourScale, DARK, LIGHT, ON_MAP, TEXT};
use super::colour_bar;
use super::contour::contour;
use super::error::{FigureError, require, require_finite, require_len};
use super::geometry::{Area, Lines, length};
use super::legend::Entry;
use super::panels::{Frame, Panels, Plot};
use super::sheet::{Dash, Pen, SPACE, Sheet, TICK_TEXT, Words};
use super::text::{number, width_of, wrap};

/// Cells over two quantities, in one plot or in rows and columns of small ones.
#[derive(Debug, Clone)]
pub struct Map {
    /// Heading, description and size.
    pub frame: Frame,
    /// The level axis; it ends with the cells if nothing else is said.
    pub x: Axis,
    /// The upright axis.
    pub y: Axis,
    /// What values are painted with.
    pub shades: Shades,
    /// The cells of each plot, row by row; none where there is nothing to show.
    pub plots: Vec<Option<Cells>>,
    /// Names of the rows of small plots; none for a lone plot.
    pub rows: Vec<String>,
    /// Names of their columns.
    pub columns: Vec<String>,
    /// Levels to draw a line at; where values are written into the cells, to mark on the colour bar alone.
    pub contours: Vec<f64>,
    /// What is written after a level, e.g. " %".
    pub contour_unit: &'static str,
    /// What a cell without value means, e.g. "no equilibrium"; such cells are hatched.
    pub missing_label: String,
    /// A further scale along the top, e.g. node numbers.
    pub top: Option<Axis>,
    /// How values are written into their cells.
    pub written: Option<fn(f64) -> String>,
    /// Cells that have no meaning and are left blank, by row and column.
    pub blank: fn(usize, usize) -> bool,
}

/// Values over a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Words above the plot.
    pub note: String,
    /// Positions of the columns; rising or falling, not necessarily evenly.
    pub x: Vec<f64>,
    /// Positions of the rows, likewise.
    pub y: Vec<f64>,
    /// One row for each entry of `y`, one value for each of `x`; none where there is no value.
    pub values: Vec<Vec<Option<f64>>>,
}

/// What values are painted with.
#[derive(Debug, Clone, PartialEq)]
pub enum Shades {
    /// A colour scale and what its values mean, e.g. "force error, %".
    Scale(ColourScale, String),
    /// A few classes, in rising order.
    Classes(Vec<Class>),
}

/// Values that share a colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Class {
    /// The largest value of the class; those of the class before are smaller.
    pub up_to: f64,
    /// Words in the legend; classes that are nowhere are not listed.
    pub label: String,
    /// Written on the map, so that colour is not the only sign; nothing where empty.
    pub sign: String,
    /// Red, green and blue.
    pub colour: [u8; 3],
}

/// A plot of a single row or column of cells gives it this share of its axis, to be seen at all.
const LONE: f64 = 0.1;
/// How far cells reach under their neighbours, px: printers leave hairlines between areas that only touch.
const OVERLAP: f64 = 1.0;
/// Colours up to this fraction of the scale are dark.
const DARK_COLOURS: f64 = 0.6;
const SMALL_HEIGHT: f64 = 104.0;
const NOTE_LINE: f64 = TICK_TEXT * 1.25;

impl Map {
    /// A lone map without contours and further scales.
    pub fn new(frame: Frame, axes: [Axis; 2], shades: Shades, cells: Cells) -> Self {
        Self::grid(frame, axes, shades, Vec::new(), vec![Some(cells)])
    }

    /// Small maps, row by row, under the names of their rows.
    pub fn grid(frame: Frame, [x, y]: [Axis; 2], shades: Shades, rows: Vec<String>, plots: Vec<Option<Cells>>) -> Self {
        let (columns, contours, contour_unit, missing_label) = (Vec::new(), Vec::new(), "", String::new());
        let (top, written, blank) = (None, None, |_, _| false);
        Self { frame, x, y, shades, plots, rows, columns, contours, contour_unit, missing_label, top, written, blank }
    }

    /// The map as SVG.
    ///
    /// # Errors
    /// [`FigureError`] if there is nothing to draw, or the numbers do not fit together.
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
        (panels.grid, panels.rows, panels.columns, panels.legend) = (0.0, &self.rows, &self.columns, self.legend());
        panels.sides[1] = if self.columns.is_empty() { 4.0 * SPACE } else { 2.0 * SPACE };
        // Notes are as wide as their plots, on as many lines as the longest needs.
        let note_width = (self.frame.width - 160.0) / self.columns.len().max(1) as f64 - 2.0 * SPACE;
        let notes: Vec<Vec<String>> = (self.plots.iter())
            .map(|plot| plot.as_ref().map_or(Vec::new(), |cells| wrap(&cells.note, TICK_TEXT, note_width)))
            .collect();
        panels.above = notes.iter().map(Vec::len).max().unwrap_or(0) as f64 * NOTE_LINE;
        if !self.rows.is_empty() {
            panels.height = SMALL_HEIGHT;
        }
        if let Some(top) = &self.top {
            panels.top = Some(top);
            panels.sides[0] = width_of(&top.label, TICK_TEXT) + 2.0 * SPACE;
        }
        if let Shades::Scale(..) = self.shades {
            panels.below = colour_bar::HEIGHT;
        }
        panels.draw(|sheet, plots, under| {
            for ((plot, cells), note) in plots.iter().zip(&self.plots).zip(&notes) {
                for (index, line) in note.iter().rev().enumerate() {
                    sheet.words(
                        Words::new(line, [plot.area.left, plot.area.top - (index as f64 + 0.6) * NOTE_LINE]).left(),
                    )?;
                }
                if let Some(cells) = cells {
                    self.draw_cells(sheet, plot, cells)?;
                    self.draw_contours(sheet, plot, cells)?;
                }
            }
            let Shades::Scale(colours, label) = &self.shades else { return Ok(()) };
            let values = || self.values().flatten();
            let beyond =
                [values().any(|value| value < colours.limits[0]), values().any(|value| value > colours.limits[1])];
            colour_bar::draw(sheet, plots[0].area, under, (colours, label), &self.contours, beyond)
        })
    }

    fn check(&self) -> Result<(), FigureError> {
        require(self.plots.iter().any(Option::is_some), FigureError::Empty, "map")?;
        require_len("plots of a map", &self.plots, self.rows.len().max(1) * self.columns.len().max(1))?;
        let mut least = 0.0_f64;
        for cells in self.plots.iter().flatten() {
            for (what, positions) in [("map columns", &cells.x), ("map rows", &cells.y)] {
                require(!positions.is_empty(), FigureError::Empty, what)?;
                require_finite(what, positions.iter())?;
                let all = |holds: fn(f64, f64) -> bool| positions.windows(2).all(|pair| holds(pair[0], pair[1]));
                require(all(|a, b| a < b) || all(|a, b| a > b), FigureError::NotMonotone, what)?;
            }
            require_len("map values", &cells.values, cells.y.len())?;
            for row in &cells.values {
                require_len("a row of map values", row, cells.x.len())?;
                require_finite("map values", row.iter().flatten())?;
                least = row.iter().flatten().copied().fold(least, f64::min);
            }
        }
        require_finite("contour levels", self.contours.iter())?;
        match &self.shades {
            Shades::Scale(colours, _) => {
                colours.check()?;
                require(colours.scale == Scale::Linear || least >= 0.0, FigureError::NotPositive, "map values")
            }
            Shades::Classes(classes) => {
                let last = classes.last().map_or(f64::NEG_INFINITY, |class| class.up_to);
                require(self.values().flatten().all(|value| value <= last), FigureError::Empty, "class of a value")
            }
        }
    }

    /// All values that have a meaning, with those that are missing.
    fn values(&self) -> impl Iterator<Item = Option<f64>> {
        let rows = self.plots.iter().flatten().flat_map(|cells| cells.values.iter().enumerate());
        let values =
            rows.flat_map(|(row, values)| values.iter().enumerate().map(move |(column, value)| (row, column, value)));
        values.filter(|(row, column, _)| !(self.blank)(*row, *column)).map(|(.., value)| *value)
    }

    /// Levels at which a line is drawn.
    fn lines(&self) -> &[f64] {
        if self.written.is_none() { &self.contours } else { &[] }
    }

    fn legend(&self) -> Vec<Entry<'_>> {
        let mut entries = Vec::new();
        for (nth, level) in self.lines().iter().enumerate() {
            entries.push(Entry::new(format!("{}{}", number(*level), self.contour_unit), move |sheet, area| {
                sheet.contour(&[area.left, area.right].map(|x| [x, area.centre()[1]]), dash(nth))
            }));
        }
        let Shades::Classes(classes) = &self.shades else { return self.with_missing(entries) };
        for (nth, Class { label, sign, colour: [r, g, b], .. }) in classes.iter().enumerate() {
            if self.values().flatten().any(|value| class(classes, value) == nth) {
                let words = if sign.is_empty() { label.clone() } else { format!("{sign}: {label}") };
                entries.push(Entry::patch(words, RGBColor(*r, *g, *b)));
            }
        }
        self.with_missing(entries)
    }

    fn with_missing<'a>(&self, mut entries: Vec<Entry<'a>>) -> Vec<Entry<'a>> {
        if self.values().any(|value| value.is_none()) {
            entries.push(Entry::new(&self.missing_label, |sheet, area| {
                let patch = Area::about(area.centre(), 26.0, 15.0);
                sheet.hatch(patch)?;
                sheet.line(&patch.outline(), Pen::new(TEXT, 1.0).faint(0.6))
            }));
        }
        entries
    }

    /// Colour of a value, what is written into its cell, and in which ink.
    fn paint(&self, value: f64) -> (RGBColor, String, RGBColor) {
        match &self.shades {
            Shades::Scale(colours, _) => {
                let ink = if colours.fraction(value) < DARK_COLOURS { LIGHT } else { DARK };
                (colours.ink(value), self.written.map_or(String::new(), |written| written(value)), ink)
            }
            Shades::Classes(classes) => {
                let Class { sign, colour: [r, g, b], .. } = &classes[class(classes, value)];
                (RGBColor(*r, *g, *b), sign.clone(), ON_MAP)
            }
        }
    }

    /// Fills the cells row by row, neighbours that look alike as one; hatches those without value.
    fn draw_cells(&self, sheet: &Sheet, plot: &Plot, cells: &Cells) -> Result<(), FigureError> {
        let columns = edges(&cells.x, self.x.limits);
        for (row, (values, ys)) in cells.values.iter().zip(edges(&cells.y, self.y.limits).windows(2)).enumerate() {
            let shown = values.iter().enumerate().map(|(column, value)| {
                let paint = value.map(|value| self.paint(value));
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
                    (None, ..) => sheet.hatch(area)?,
                    (Some((colour, text, ink)), ..) => {
                        sheet.cell(area, *colour)?;
                        if room >= TICK_TEXT * 0.8 && !text.is_empty() {
                            let size = if self.written.is_some() { 14.0 } else { TICK_TEXT };
                            sheet.words(Words::new(text, centre).size(size).ink(*ink))?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Draws the lines of equal value, and two labels a level at most.
    fn draw_contours(&self, sheet: &Sheet, plot: &Plot, cells: &Cells) -> Result<(), FigureError> {
        let Shades::Scale(colours, _) = &self.shades else { return Ok(()) };
        // Values are linear along the colour scale. One of zero has no logarithm: the scale's lower end stands for it.
        let measure = |value: f64| match colours.scale {
            Scale::Linear => value,
            Scale::Log => value.max(colours.limits[0]).log10(),
        };
        let values: Vec<Vec<_>> =
            cells.values.iter().map(|row| row.iter().map(|value| value.map(measure)).collect()).collect();
        let mut labels: Vec<(Area, String)> = Vec::new();
        for (nth, level) in self.lines().iter().enumerate() {
            let text = format!("{}{}", number(*level), self.contour_unit);
            let lines = contour(&cells.x, &cells.y, &values, measure(*level));
            let mut lines: Lines = lines.iter().map(|line| plot.line(line)).collect();
            lines.sort_by(|a, b| length(b).total_cmp(&length(a)));
            lines.iter().try_for_each(|line| sheet.contour(line, dash(nth)))?;
            for line in lines.iter().filter(|line| length(line) > 130.0).take(2) {
                // As near its middle as can be, where the label hides no other.
                let at = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8]
                    .map(|part| line[((line.len() - 1) as f64 * part).round() as usize]);
                let mut areas =
                    at.into_iter().map(|at| Area::about(at, width_of(&text, TICK_TEXT) + 8.0, TICK_TEXT * 1.3));
                let free =
                    areas.find(|area| plot.area.holds(area) && !labels.iter().any(|(other, _)| other.meets(area)));
                labels.extend(free.map(|area| (area, text.clone())));
            }
        }
        labels.iter().try_for_each(|(area, text)| sheet.words(Words::new(text, area.centre()).ink(ON_MAP).bold()))
    }
}

/// How the line of the n-th level is broken.
fn dash(nth: usize) -> Dash {
    [Dash::Solid, Dash::Dashed, Dash::Dotted][nth % 3]
}

/// The class of a value.
fn class(classes: &[Class], value: f64) -> usize {
    classes.iter().take_while(|class| value > class.up_to).count()
}

/// Edges of cells: halfway between neighbours, and as far beyond the first and last.
fn edges(positions: &[f64], limits: Option<[f64; 2]>) -> Vec<f64> {
    let [first, .., last] = positions else {
        let half = limits.map_or(0.5, |[low, high]| LONE / 2.0 * (high - low));
        return positions.iter().flat_map(|lone| [lone - half, lone + half]).collect();
    };
    let mut edges: Vec<f64> = positions.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
    edges.insert(0, 2.0 * first - edges[0]);
    edges.push(2.0 * last - edges[edges.len() - 1]);
    edges
}
