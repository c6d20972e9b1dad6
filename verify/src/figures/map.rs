//! Maps: cells over two quantities in colours, alone or as small multiples.

use plotters::style::Color;

use super::axis::Axis;
use super::cells::{Cells, edges};
use super::colour::TEXT;
use super::error::{FigureError, require, require_len};
use super::geometry::Area;
use super::legend::Entry;
use super::panels::{Frame, Panels};
use super::shades::{self, Class};
use super::sheet::{LEFT, SPACE, TICK_TEXT, font, pen};
use super::text::{width_of, wrap};

/// Cells over two quantities, in one plot or in rows and columns of small ones.
#[derive(Debug, Clone)]
pub struct Map {
    /// Heading, description and size.
    pub frame: Frame,
    /// The level axis; it ends with the cells if nothing else is said.
    pub x: Axis,
    /// The upright axis.
    pub y: Axis,
    /// What values are painted with, in rising order.
    pub classes: Vec<Class>,
    /// The cells of each plot, row by row; none where there is nothing to show.
    pub plots: Vec<Option<Cells>>,
    /// Names of the rows of small plots; none for a lone plot.
    pub rows: Vec<String>,
    /// Names of their columns.
    pub columns: Vec<String>,
    /// What a cell without value means, e.g. "no equilibrium"; such cells are hatched.
    pub missing_label: String,
    /// A further scale along the top, e.g. node numbers.
    pub top: Option<Axis>,
    /// How values are written into their cells.
    pub written: Option<fn(f64) -> String>,
    /// Cells that have no meaning and are left blank, by row and column.
    pub blank: fn(usize, usize) -> bool,
}

const SMALL_HEIGHT: f64 = 104.0;
const NOTE_TEXT: f64 = 15.0;
const NOTE_LINE: f64 = NOTE_TEXT * 1.3;

impl Map {
    /// A lone map without further scales.
    pub fn new(frame: Frame, axes: [Axis; 2], classes: Vec<Class>, cells: Cells) -> Self {
        Self::grid(frame, axes, classes, Vec::new(), vec![Some(cells)])
    }

    /// Small maps, row by row, under the names of their rows.
    pub fn grid(
        frame: Frame,
        [x, y]: [Axis; 2],
        classes: Vec<Class>,
        rows: Vec<String>,
        plots: Vec<Option<Cells>>,
    ) -> Self {
        let (columns, missing_label, top) = (Vec::new(), String::new(), None);
        Self { frame, x, y, classes, plots, rows, columns, missing_label, top, written: None, blank: |_, _| false }
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
        (panels.grid, panels.rows, panels.columns, panels.legend) =
            ([false; 2], &self.rows, &self.columns, self.legend());
        panels.sides[1] = if self.columns.is_empty() { 4.0 * SPACE } else { 2.0 * SPACE };
        // Notes are as wide as their plots, on as many lines as the longest needs.
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
                // Nothing to show is not a map without cells.
                let Some(cells) = cells else {
                    sheet.words("–", plot.area.centre(), &font(TICK_TEXT))?;
                    continue;
                };
                cells.draw(sheet, plot, self)?;
            }
            Ok(())
        })
    }

    fn check(&self) -> Result<(), FigureError> {
        require(self.plots.iter().any(Option::is_some), FigureError::Empty, "map")?;
        require_len("plots of a map", &self.plots, self.rows.len().max(1) * self.columns.len().max(1))?;
        self.plots.iter().flatten().try_for_each(Cells::check)?;
        shades::check(&self.classes, self.values().flatten().fold(0.0, f64::max))
    }

    /// All values that have a meaning, with those that are missing.
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
        entries
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::Paint;

    fn axes() -> [Axis; 2] {
        [Axis::linear("position, mm"), Axis::linear("direction, deg")]
    }

    fn cells(values: [[Option<f64>; 3]; 2]) -> Cells {
        let values = values.map(Vec::from).into();
        Cells { note: "all clear".to_owned(), x: vec![10.0, 20.0, 35.0], y: vec![-30.0, 0.0], values }
    }

    fn classes(plots: Vec<Option<Cells>>) -> Map {
        let class = |up_to, label: &str, sign: &str, grey| Class {
            up_to,
            label: label.into(),
            sign: sign.into(),
            fill: Paint::Colour([grey; 3]),
        };
        let classes = vec![class(10.0, "clear", "", 9), class(25.0, "grey", "G", 8), class(99.0, "dark", "D", 7)];
        let rows = vec!["linear".to_owned(); plots.len()];
        Map {
            missing_label: "refused".to_owned(),
            ..Map::grid(Frame::full("Errors", "errors"), axes(), classes, rows, plots)
        }
    }

    fn map(values: [[f64; 3]; 2]) -> Map {
        let top = Some(Axis::linear("node").named(vec![(20.0, "n24".to_owned())]));
        let classes = classes(Vec::new()).classes;
        let lone = Map::new(Frame::half("Error", "error"), axes(), classes, cells(values.map(|row| row.map(Some))));
        Map { missing_label: "no equilibrium".to_owned(), top, ..lone }
    }

    /// Filled cells, those of the legend left out.
    fn filled(map: &Map, others: usize) -> usize {
        map.svg().unwrap().matches("<rect ").count() - others
    }

    const VALUES: [[f64; 3]; 2] = [[0.1, 12.0, 0.9], [12.7, 8.1, 24.3]];

    #[test]
    fn every_cell_is_drawn_and_one_without_value_is_hatched_and_explained() {
        let mut map = map(VALUES);
        assert_eq!(filled(&map, 2), 6);
        assert!(!map.svg().unwrap().contains("no equilibrium") && map.svg().unwrap().contains(">n24<"));
        map.plots[0] = Some(cells([[Some(0.1), None, Some(3.0)], [Some(7.0), Some(19.0), Some(2.0)]]));
        assert!(filled(&map, 2) == 5 && map.svg().unwrap().contains(">no equilibrium<"));
    }

    #[test]
    fn values_are_written_into_their_cells_and_blank_ones_stay_empty() {
        let written =
            Map { written: Some(|value| format!("v{value}")), blank: |row, column| row == column, ..map(VALUES) };
        let svg = written.svg().unwrap();
        assert!(filled(&written, 2) == 4 && svg.contains(">v12<") && !svg.contains(">v0.1<"));
        assert!(!svg.contains("no equilibrium"));
    }

    #[test]
    fn neighbours_of_a_class_are_one_and_only_classes_that_are_there_are_listed() {
        let one = cells([[Some(10.0), Some(25.0), Some(25.0)], [None, Some(1.0), Some(1.0)]]);
        let lone = Cells { y: vec![0.0], values: vec![vec![Some(1.0); 3]], ..one.clone() };
        let map = classes(vec![Some(one), None, Some(lone)]);
        let svg = map.svg().unwrap();
        assert_eq!(filled(&map, 2), 2 + 1 + 1);
        assert!(
            [">clear<", ">G: grey<", ">refused<", ">linear<", ">all clear<"].iter().all(|words| svg.contains(words))
        );
        assert!(!svg.contains("dark"));
    }

    #[test]
    fn data_that_do_not_fit_together_are_refused() {
        let refusal = |change: fn(&mut Cells)| {
            let mut broken = map(VALUES);
            broken.plots.iter_mut().flatten().for_each(change);
            broken.svg().unwrap_err()
        };
        assert!(matches!(refusal(|cells| cells.values.truncate(1)), FigureError::Mismatch(_, 2, 1)));
        assert!(matches!(refusal(|cells| cells.values[0].truncate(1)), FigureError::Mismatch(_, 3, 1)));
        assert!(matches!(refusal(|cells| cells.x.swap(1, 2)), FigureError::NotMonotone(_)));
        assert!(matches!(refusal(|cells| cells.values[0][0] = Some(f64::NAN)), FigureError::NotFinite(_)));
        assert!(matches!(classes(vec![]).svg(), Err(FigureError::Empty(_))));
        let unknown = cells([[Some(100.0); 3]; 2]);
        assert!(matches!(classes(vec![Some(unknown)]).svg(), Err(FigureError::Empty(_))));
    }
}
