//! Small multiples: many maps over the same two quantities, in a few shades, to be compared at a glance.

use plotters::style::text_anchor::{HPos, VPos};

use super::axis::{Axis, Ruler, Scale};
use super::canvas::{Canvas, Pen, Words, draw};
use super::colour::Ink;
use super::error::{FigureError, require_finite, require_len, require_some};
use super::frame::{Frame, LABEL_TEXT, TICK_TEXT};
use super::heat_map::bounds;
use super::legend::{Legend, Sample};
use super::map_layers::fill;
use super::plot::{Heading, SPACE};
use super::stroke::Area;
use super::text::wrap;

/// Maps in rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub struct MapGrid {
    /// Heading, description and width.
    pub frame: Frame,
    /// What all maps share across, e.g. "place, mm".
    pub x: Axis,
    /// What all maps share upwards, e.g. "direction, deg".
    pub y: Axis,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<MapRow>,
    /// Values up to the first belong to the first of the three shades, up to the second to the next; the last has the rest.
    pub limits: [f64; 2],
    /// What the three shades mean.
    pub shades: [String; 3],
    /// What a place without value means.
    pub missing_label: String,
}

/// Maps beside each other.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRow {
    /// Name of the row.
    pub label: String,
    /// One for each column; none where there is no map.
    pub maps: Vec<Option<SmallMap>>,
}

/// One of many maps.
#[derive(Debug, Clone, PartialEq)]
pub struct SmallMap {
    /// What is said above it.
    pub note: String,
    /// Places of the columns, rising.
    pub x: Vec<f64>,
    /// Places of the rows, rising.
    pub y: Vec<f64>,
    /// One row for each entry of `y`, one value for each of `x`; none where there is no value.
    pub values: Vec<Vec<Option<f64>>>,
}

/// From clear to dark, the same in light and dark mode: the order of lightness carries the meaning.
const SHADES: [[u8; 3]; 3] = [[0xd9, 0xee, 0xdf], [0xa4, 0xac, 0xb5], [0x41, 0x49, 0x53]];
/// A map of a single row is drawn this share of the axis high, to be seen at all.
const LONE_ROW: f64 = 0.1;
const MAP_HEIGHT: f64 = 104.0;
const NOTE_HEIGHT: f64 = TICK_TEXT * 1.5;
const ROW_LABEL: f64 = 92.0;
const TICK_LABELS: f64 = 44.0;
const BELOW: f64 = TICK_TEXT * 1.4 + LABEL_TEXT * 1.4 + SPACE;

/// Draws the maps.
///
/// # Errors
/// [`FigureError`] if there is nothing to draw, or the numbers do not fit together.
pub fn map_grid(grid: &MapGrid) -> Result<String, FigureError> {
    check(grid)?;
    let heading = Heading::new(&grid.frame);
    let left = SPACE + ROW_LABEL + TICK_LABELS;
    let right = grid.frame.width - 2.0 * SPACE;
    let column_width = (right - left) / grid.columns.len() as f64;
    let first = heading.height() + LABEL_TEXT * 1.5 + LABEL_TEXT * 1.5;
    let row_height = NOTE_HEIGHT + MAP_HEIGHT + SPACE;
    let area = |row: usize, column: usize| {
        let (x, y) = (left + column as f64 * column_width, first + row as f64 * row_height + NOTE_HEIGHT);
        Area { left: x, top: y, right: x + column_width - 2.0 * SPACE, bottom: y + MAP_HEIGHT }
    };
    let bottom = first + grid.rows.len() as f64 * row_height;
    let legend = Legend::lay_out(&legend_entries(grid), SPACE, right);
    let legend_top = bottom + BELOW;
    draw(&grid.frame, legend_top + legend.height() + SPACE, |canvas| {
        heading.draw(canvas)?;
        let y_label = Words::new(&grid.y.label, [SPACE, heading.height() + LABEL_TEXT * 0.7], LABEL_TEXT);
        canvas.words(y_label.anchored(HPos::Left, VPos::Center))?;
        for (column, name) in grid.columns.iter().enumerate() {
            let at = [area(0, column).left, first - LABEL_TEXT * 0.7];
            let words = Words::new(name, at, LABEL_TEXT).anchored(HPos::Left, VPos::Center);
            canvas.words(Words { bold: true, ..words })?;
        }
        for (number, row) in grid.rows.iter().enumerate() {
            draw_row_label(canvas, &row.label, area(number, 0))?;
            for (column, map) in row.maps.iter().enumerate() {
                if let Some(map) = map {
                    draw_map(canvas, grid, map, area(number, column))?;
                }
            }
            draw_y_ticks(canvas, &grid.y, area(number, 0))?;
        }
        let last = grid.rows.len() - 1;
        for column in 0..grid.columns.len() {
            draw_x_ticks(canvas, &grid.x, area(last, column))?;
        }
        let at = [(left + right) / 2.0, bottom + TICK_TEXT * 1.4 + LABEL_TEXT];
        canvas.words(Words::new(&grid.x.label, at, LABEL_TEXT))?;
        legend.draw(canvas, legend_top)
    })
}

fn check(grid: &MapGrid) -> Result<(), FigureError> {
    grid.frame.check()?;
    require_some("rows of maps", &grid.rows)?;
    require_some("columns of maps", &grid.columns)?;
    require_finite("limits of shades", &grid.limits)?;
    for row in &grid.rows {
        require_len("a row of maps", &row.maps, grid.columns.len())?;
        for map in row.maps.iter().flatten() {
            require_some("map columns", &map.x)?;
            require_some("map rows", &map.y)?;
            for places in [&map.x, &map.y] {
                require_finite("places of a map", places)?;
                if places.windows(2).any(|pair| pair[0] >= pair[1]) {
                    return Err(FigureError::NotMonotone { what: "places of a map".into() });
                }
            }
            require_len("map values", &map.values, map.y.len())?;
            for row in &map.values {
                require_len("a row of map values", row, map.x.len())?;
                require_finite("map values", row.iter().flatten())?;
            }
        }
    }
    Ok(())
}

fn legend_entries(grid: &MapGrid) -> Vec<(Sample, String)> {
    let patches = SHADES.iter().zip(&grid.shades).map(|(shade, text)| (Sample::Patch(Ink::Rgb(*shade)), text.clone()));
    let maps = || grid.rows.iter().flat_map(|row| row.maps.iter().flatten());
    let holes = maps().any(|map| map.values.iter().flatten().any(Option::is_none));
    patches.chain(holes.then(|| (Sample::Hatch, grid.missing_label.clone()))).collect()
}

/// The shade of a value.
fn shade(limits: &[f64; 2], value: f64) -> Ink {
    Ink::Rgb(SHADES[limits.iter().filter(|limit| value > **limit).count()])
}

/// From the ends of an axis, which are given, to a side of an area.
fn ruler(axis: &Axis, ends: [f64; 2]) -> Result<(Ruler, [f64; 2]), FigureError> {
    let span = axis.span(&[])?;
    Ok((Ruler::new(Scale::Linear, span, ends), span))
}

fn draw_map(canvas: &mut Canvas, grid: &MapGrid, map: &SmallMap, area: Area) -> Result<(), FigureError> {
    let (x, x_span) = ruler(&grid.x, [area.left, area.right])?;
    let (y, y_span) = ruler(&grid.y, [area.bottom, area.top])?;
    let edges = |places: &[f64], span: [f64; 2]| match places {
        [lone] => vec![lone - LONE_ROW / 2.0 * (span[1] - span[0]), lone + LONE_ROW / 2.0 * (span[1] - span[0])],
        places => bounds(places),
    };
    let within = |edges: Vec<f64>, span: [f64; 2], ruler: &Ruler| -> Vec<f64> {
        edges.into_iter().map(|edge| ruler.place(edge.clamp(span[0], span[1]))).collect()
    };
    let columns = within(edges(&map.x, x_span), x_span, &x);
    let rows = within(edges(&map.y, y_span), y_span, &y);
    for (values, ends) in map.values.iter().zip(rows.windows(2)) {
        let inks: Vec<Option<Ink>> = values.iter().map(|value| value.map(|v| shade(&grid.limits, v))).collect();
        fill(canvas, &inks, &columns, [ends[0], ends[1]], area)?;
    }
    canvas.line(&area.outline(), Pen::new(Ink::Text, 1.2).faint(0.65))?;
    let note = Words::new(&map.note, [area.left, area.top - NOTE_HEIGHT * 0.42], TICK_TEXT);
    canvas.words(note.anchored(HPos::Left, VPos::Center))
}

fn draw_row_label(canvas: &mut Canvas, label: &str, area: Area) -> Result<(), FigureError> {
    for (index, line) in wrap(label, LABEL_TEXT * 1.08, ROW_LABEL).iter().enumerate() {
        let at = [SPACE, area.top + (index as f64 + 0.5) * LABEL_TEXT * 1.25];
        let words = Words::new(line, at, LABEL_TEXT).anchored(HPos::Left, VPos::Center);
        canvas.words(Words { bold: true, ..words })?;
    }
    Ok(())
}

fn draw_y_ticks(canvas: &mut Canvas, axis: &Axis, area: Area) -> Result<(), FigureError> {
    let (ruler, span) = ruler(axis, [area.bottom, area.top])?;
    for tick in axis.marks(span, 3) {
        let y = ruler.place(tick.value);
        canvas.line(&[[area.left - 5.0, y], [area.left, y]], Pen::new(Ink::Text, 1.2).faint(0.65))?;
        let words = Words::new(&tick.label, [area.left - 8.0, y], TICK_TEXT);
        canvas.words(words.anchored(HPos::Right, VPos::Center))?;
    }
    Ok(())
}

fn draw_x_ticks(canvas: &mut Canvas, axis: &Axis, area: Area) -> Result<(), FigureError> {
    let (ruler, span) = ruler(axis, [area.left, area.right])?;
    for tick in axis.marks(span, 3) {
        let x = ruler.place(tick.value);
        canvas.line(&[[x, area.bottom], [x, area.bottom + 5.0]], Pen::new(Ink::Text, 1.2).faint(0.65))?;
        let words = Words::new(&tick.label, [x, area.bottom + 8.0], TICK_TEXT);
        canvas.words(words.anchored(HPos::Center, VPos::Top))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> MapGrid {
        let map = |values: [[Option<f64>; 2]; 2]| SmallMap {
            note: "mean 3 %".into(),
            x: vec![10.0, 20.0],
            y: vec![-40.0, 40.0],
            values: values.map(Vec::from).into(),
        };
        let lone =
            SmallMap { note: "nodes".into(), x: vec![10.0, 20.0], y: vec![0.0], values: vec![vec![Some(1.0); 2]] };
        MapGrid {
            frame: Frame::full("Errors", "errors of two truths by two estimators"),
            x: Axis::linear("place, mm").within(0.0, 30.0),
            y: Axis::linear("direction, deg").within(-80.0, 80.0).with_ticks(vec![-60.0, 0.0, 60.0]),
            columns: vec!["one".into(), "two".into()],
            rows: vec![
                MapRow {
                    label: "linear".into(),
                    maps: vec![Some(map([[Some(1.0), Some(20.0)], [Some(30.0); 2]])), None],
                },
                MapRow { label: "twin".into(), maps: vec![Some(map([[Some(1.0); 2]; 2])), Some(lone)] },
            ],
            limits: [10.0, 25.0],
            shades: ["up to 10", "up to 25", "more"].map(str::to_owned),
            missing_label: "refused".into(),
        }
    }

    /// Filled rectangles, those of the legend left out.
    fn cells(svg: &str) -> usize {
        svg.matches("<rect ").count() - SHADES.len()
    }

    #[test]
    fn neighbours_of_one_shade_are_one_rectangle() {
        // Rows of the first map: two shades and one; of the second one each; the lone row.
        assert_eq!(cells(&map_grid(&grid()).unwrap()), 3 + 2 + 1);
    }

    #[test]
    fn limits_belong_to_the_lighter_shade() {
        let limits = [10.0, 25.0];
        for (value, index) in [(10.0, 0), (10.1, 1), (25.0, 1), (25.1, 2)] {
            assert_eq!(shade(&limits, value), Ink::Rgb(SHADES[index]), "{value}");
        }
    }

    #[test]
    fn a_place_without_value_is_hatched_and_explained() {
        let mut holed = grid();
        if let Some(map) = &mut holed.rows[1].maps[0] {
            map.values[0][1] = None;
        }
        let svg = map_grid(&holed).unwrap();
        assert_eq!(cells(&svg), 3 + 2 + 1);
        assert!(svg.contains("refused") && !map_grid(&grid()).unwrap().contains("refused"));
    }

    #[test]
    fn data_that_do_not_fit_together_are_refused() {
        let mut short = grid();
        short.rows[0].maps.pop();
        assert!(matches!(map_grid(&short), Err(FigureError::Mismatch { expected: 2, found: 1, .. })));
        let mut unordered = grid();
        if let Some(map) = &mut unordered.rows[0].maps[0] {
            map.x = vec![20.0, 10.0];
        }
        assert!(matches!(map_grid(&unordered), Err(FigureError::NotMonotone { .. })));
        let mut broken = grid();
        if let Some(map) = &mut broken.rows[0].maps[0] {
            map.values[0][0] = Some(f64::NAN);
        }
        assert!(matches!(map_grid(&broken), Err(FigureError::NotFinite { .. })));
    }
}
