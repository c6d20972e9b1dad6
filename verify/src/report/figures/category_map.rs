//! A map of which of several things holds, over two quantities.

use super::axis::{Axis, Scale, ticks};
use super::canvas::{Canvas, Words, draw};
use super::colour::Ink;
use super::error::{FigureError, require_finite, require_len, require_some};
use super::frame::{Frame, TICK_TEXT};
use super::heat_map::{bounds, ends};
use super::legend::{Legend, Sample};
use super::marks::hatch;
use super::plot::{self, Heading, Plot, SPACE, Side};
use super::stroke::Area;

/// Something that may hold at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Category {
    /// Words in the legend.
    pub label: String,
    /// Written on the map, so that colour is not all that tells it; nothing where empty.
    pub sign: String,
    /// Red, green and blue.
    pub colour: [u8; 3],
}

/// Categories over a grid of places (across) and directions (up).
#[derive(Debug, Clone, PartialEq)]
pub struct CategoryMap {
    /// Heading, description and size.
    pub frame: Frame,
    /// Label of the level axis.
    pub x_label: String,
    /// Places of the columns, rising.
    pub x: Vec<f64>,
    /// Label of the upright axis.
    pub y_label: String,
    /// Places of the rows, rising.
    pub y: Vec<f64>,
    /// Values on the upright axis to mark.
    pub y_ticks: Vec<f64>,
    /// The categories; those that are nowhere are left out of the legend.
    pub categories: Vec<Category>,
    /// One row for each entry of `y`, one position in `categories` for each of `x`; none where nothing is known.
    pub values: Vec<Vec<Option<usize>>>,
    /// What a place without value means.
    pub missing_label: String,
}

/// Draws the map.
pub fn category_map(map: &CategoryMap) -> Result<String, FigureError> {
    check(map)?;
    let (columns, rows) = (bounds(&map.x), bounds(&map.y));
    let (x_span, y_span) = (ends(&columns), ends(&rows));
    let plot_height = map.frame.height_of_plot();
    let y_axis = Axis { ticks: Some(map.y_ticks.clone()), ..Axis::linear(map.y_label.clone()) };
    let y = Side {
        label: map.y_label.clone(),
        scale: Scale::Linear,
        span: y_span,
        ticks: y_axis.marks(y_span, plot::most_ticks(plot_height, 44.0)),
    };
    let heading = Heading::new(&map.frame);
    let top = heading.height() + plot::Y_LABEL_HEIGHT;
    let area =
        Area { left: plot::left_margin(&y), top, right: map.frame.width - 4.0 * SPACE, bottom: top + plot_height };
    let most = plot::most_ticks(area.right - area.left, 55.0);
    let x = Side {
        label: map.x_label.clone(),
        scale: Scale::Linear,
        span: x_span,
        ticks: ticks(Scale::Linear, x_span, most),
    };
    let plot = Plot::new(area, &x, &y);
    let legend_top = area.bottom + plot::X_LABELS_HEIGHT + SPACE;
    let legend = Legend::lay_out(&legend_entries(map), SPACE, map.frame.width - SPACE);
    draw(&map.frame, legend_top + legend.height() + SPACE, |canvas| {
        heading.draw(canvas)?;
        plot.draw_y_label(canvas, &map.y_label, top)?;
        draw_cells(canvas, map, &plot, &columns, &rows)?;
        plot.draw_axes(canvas, &x, &y)?;
        legend.draw(canvas, legend_top)
    })
}

fn check(map: &CategoryMap) -> Result<(), FigureError> {
    map.frame.check()?;
    for (what, places) in [("map columns", &map.x), ("map rows", &map.y)] {
        require_some(what, places)?;
        require_finite(what, places)?;
        if !places.windows(2).all(|pair| pair[0] < pair[1]) {
            let what = what.into();
            return Err(FigureError::NotMonotone { what });
        }
    }
    require_len("map values", &map.values, map.y.len())?;
    for row in &map.values {
        require_len("a row of map values", row, map.x.len())?;
    }
    let largest = map.values.iter().flatten().flatten().max().map_or(0, |largest| largest + 1);
    if largest > map.categories.len() {
        let what = "map categories".into();
        return Err(FigureError::Mismatch { what, expected: largest, found: map.categories.len() });
    }
    Ok(())
}

/// Fills the map row by row, neighbours of one category as one, with a sign in each where there is room.
fn draw_cells(
    canvas: &mut Canvas,
    map: &CategoryMap,
    plot: &Plot,
    columns: &[f64],
    rows: &[f64],
) -> Result<(), FigureError> {
    for (row, values) in map.values.iter().enumerate() {
        let ys = [rows[row], rows[row + 1]].map(|bound| plot.y.place(bound));
        let mut first = 0;
        for run in values.chunk_by(|one, next| one == next) {
            let xs = [columns[first], columns[first + run.len()]].map(|bound| plot.x.place(bound));
            first += run.len();
            let area = Area {
                left: xs[0].min(xs[1]),
                right: xs[0].max(xs[1]),
                top: ys[0].min(ys[1]),
                bottom: ys[0].max(ys[1]),
            };
            let Some(category) = run[0].map(|number| &map.categories[number]) else {
                hatch(canvas, area)?;
                continue;
            };
            canvas.cell(area, Ink::Rgb(category.colour))?;
            let room = (area.right - area.left).min(area.bottom - area.top);
            if room >= TICK_TEXT * 0.8 {
                let centre = [(area.left + area.right) / 2.0, (area.top + area.bottom) / 2.0];
                canvas.words(Words::new(&category.sign, centre, TICK_TEXT).inked(Ink::OnMap))?;
            }
        }
    }
    Ok(())
}

fn legend_entries(map: &CategoryMap) -> Vec<(Sample, String)> {
    let shown = |number: usize| map.values.iter().flatten().any(|value| *value == Some(number));
    let words = |category: &Category| match category.sign.as_str() {
        "" => category.label.clone(),
        sign => format!("{sign}: {}", category.label),
    };
    let mut entries: Vec<_> = map
        .categories
        .iter()
        .enumerate()
        .filter(|(number, _)| shown(*number))
        .map(|(_, category)| (Sample::Patch(Ink::Rgb(category.colour)), words(category)))
        .collect();
    if map.values.iter().flatten().any(Option::is_none) {
        entries.push((Sample::Hatch, map.missing_label.clone()));
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> CategoryMap {
        let category = |label: &str, sign: &str, colour| Category { label: label.into(), sign: sign.into(), colour };
        CategoryMap {
            frame: Frame::half("Causes", "largest cause by place and direction"),
            x_label: "place, mm".into(),
            x: vec![10.0, 20.0, 35.0],
            y_label: "direction, deg".into(),
            y: vec![-30.0, 0.0],
            y_ticks: vec![-30.0, 0.0],
            categories: vec![
                category("noise", "N", [1, 2, 3]),
                category("place", "P", [4, 5, 6]),
                category("nowhere", "X", [7, 8, 9]),
            ],
            values: vec![vec![Some(0), Some(0), Some(1)], vec![Some(1), None, Some(1)]],
            missing_label: "no answer".into(),
        }
    }

    #[test]
    fn neighbours_alike_are_one_and_only_what_is_shown_is_in_the_legend() {
        let svg = category_map(&map()).unwrap();
        // One run of two, three of one, and two patches in the legend.
        assert_eq!(svg.matches("<rect ").count(), 4 + 2);
        assert!(svg.contains("N: noise") && svg.contains("no answer") && !svg.contains("nowhere"));
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let mut foreign = map();
        foreign.values[0][0] = Some(3);
        assert!(matches!(category_map(&foreign), Err(FigureError::Mismatch { expected: 4, found: 3, .. })));
        let mut short = map();
        short.values.pop();
        assert!(matches!(category_map(&short), Err(FigureError::Mismatch { .. })));
        let mut falling = map();
        falling.x.reverse();
        assert!(matches!(category_map(&falling), Err(FigureError::NotMonotone { .. })));
    }
}
