//! A map of values over two quantities, with lines at chosen levels.

use super::axis::{Axis, Scale, ticks};
use super::canvas::draw;
use super::colour::ColourScale;
use super::colour_bar::{self, ColourBar};
use super::error::{FigureError, require_finite, require_len, require_some};
use super::frame::{Frame, TICK_TEXT};
use super::legend::{Legend, Sample};
use super::map_layers::{dash_of, draw_cells, draw_contours, draw_marks};
use super::plot::{self, Heading, Plot, SPACE, Side};
use super::stroke::Area;
use super::text::{number, width_of};

/// Values over a grid of places (across) and directions (up).
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Heading, description and size.
    pub frame: Frame,
    /// Label of the level axis, e.g. "place along the front plate, mm".
    pub x_label: String,
    /// Places of the columns; rising or falling, not necessarily evenly.
    pub x: Vec<f64>,
    /// Label of the upright axis, e.g. "force direction, °".
    pub y_label: String,
    /// Places of the rows; rising or falling, not necessarily evenly.
    pub y: Vec<f64>,
    /// Values on the upright axis to mark; chosen when absent.
    pub y_ticks: Option<Vec<f64>>,
    /// One row for each entry of `y`, one value for each of `x`; none where there is no value.
    pub values: Vec<Vec<Option<f64>>>,
    /// What the colours mean, e.g. "force error, %".
    pub value_label: String,
    /// Which value has which colour; give the same to maps that are to be compared.
    pub colours: ColourScale,
    /// Levels to draw a line at.
    pub contours: Vec<f64>,
    /// Written after a level, e.g. " %".
    pub contour_unit: String,
    /// What a place without value means, e.g. "no equilibrium found".
    pub missing_label: String,
    /// Name of the marks along the top, e.g. "node".
    pub marks_label: String,
    /// Marks along the top.
    pub marks: Vec<PlaceMark>,
}

/// A name for a place on the level axis.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceMark {
    /// The place.
    pub x: f64,
    /// Its name, e.g. a node number.
    pub label: String,
}

/// Draws the map.
pub fn heat_map(map: &HeatMap) -> Result<String, FigureError> {
    check(map)?;
    let (columns, rows) = (bounds(&map.x), bounds(&map.y));
    let (x_span, y_span) = (ends(&columns), ends(&rows));
    let plot_height = map.frame.height_of_plot();
    let y_axis = Axis { ticks: map.y_ticks.clone(), ..Axis::linear(map.y_label.clone()) };
    let y = Side {
        label: map.y_label.clone(),
        scale: Scale::Linear,
        span: y_span,
        ticks: y_axis.marks(y_span, plot::most_ticks(plot_height, 44.0)),
    };
    let marks_name = width_of(&map.marks_label, TICK_TEXT) + 2.0 * SPACE;
    let marks_height = if map.marks.is_empty() { 0.0 } else { 26.0 };
    let heading = Heading::new(&map.frame);
    let left = plot::left_margin(&y).max(if map.marks.is_empty() { 0.0 } else { marks_name });
    let top = heading.height() + plot::Y_LABEL_HEIGHT + marks_height;
    let area = Area { left, top, right: map.frame.width - 4.0 * SPACE, bottom: top + plot_height };
    let most = plot::most_ticks(area.right - area.left, 55.0);
    let x = Side {
        label: map.x_label.clone(),
        scale: Scale::Linear,
        span: x_span,
        ticks: ticks(Scale::Linear, x_span, most),
    };
    let plot = Plot::new(area, &x, &y);
    let bar = ColourBar { label: &map.value_label, colours: map.colours, beyond: beyond(map) };
    let bar_top = area.bottom + plot::X_LABELS_HEIGHT + SPACE;
    let legend = Legend::lay_out(&legend_entries(map), SPACE, map.frame.width - SPACE);
    let legend_top = bar_top + colour_bar::HEIGHT + SPACE;
    draw(&map.frame, legend_top + legend.height() + SPACE, |canvas| {
        heading.draw(canvas)?;
        plot.draw_y_label(canvas, &map.y_label, top - marks_height)?;
        draw_cells(canvas, map, &plot, &columns, &rows)?;
        draw_contours(canvas, map, &plot)?;
        plot.draw_axes(canvas, &x, &y)?;
        draw_marks(canvas, map, &plot)?;
        bar.draw(canvas, &map.contours, [area.left, area.right], bar_top)?;
        legend.draw(canvas, legend_top)
    })
}

fn check(map: &HeatMap) -> Result<(), FigureError> {
    map.frame.check()?;
    map.colours.check()?;
    for (what, places) in [("map columns", &map.x), ("map rows", &map.y)] {
        require_some(what, places)?;
        require_finite(what, places)?;
        let rising = places.windows(2).all(|pair| pair[0] < pair[1]);
        let falling = places.windows(2).all(|pair| pair[0] > pair[1]);
        if !rising && !falling {
            let what = what.into();
            return Err(FigureError::NotMonotone { what });
        }
    }
    require_len("map values", &map.values, map.y.len())?;
    for row in &map.values {
        require_len("a row of map values", row, map.x.len())?;
        require_finite("map values", row.iter().flatten())?;
    }
    require_finite("contour levels", &map.contours)?;
    require_finite("map marks", map.marks.iter().map(|mark| &mark.x))?;
    let values = map.values.iter().flatten().flatten();
    let negative = values.chain(&map.contours).any(|value| *value < 0.0);
    if map.colours.scale == Scale::Log && negative {
        let what = "map values".into();
        return Err(FigureError::NotPositive { what });
    }
    Ok(())
}

/// Edges of the cells: halfway between neighbours, and as far beyond the first and last.
pub(super) fn bounds(places: &[f64]) -> Vec<f64> {
    let (first, last) = (places[0], places[places.len() - 1]);
    if places.len() == 1 {
        return vec![first - 0.5, first + 0.5];
    }
    let mut bounds = vec![first - (places[1] - first) / 2.0];
    bounds.extend(places.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0));
    bounds.push(last + (last - places[places.len() - 2]) / 2.0);
    bounds
}

pub(super) fn ends(bounds: &[f64]) -> [f64; 2] {
    let (first, last) = (bounds[0], bounds[bounds.len() - 1]);
    [first.min(last), first.max(last)]
}

/// Whether values lie below and above the colour scale.
fn beyond(map: &HeatMap) -> [bool; 2] {
    let values = || map.values.iter().flatten().flatten();
    let [low, high] = map.colours.limits;
    [values().any(|value| *value < low), values().any(|value| *value > high)]
}

fn legend_entries(map: &HeatMap) -> Vec<(Sample, String)> {
    let mut entries: Vec<_> = map
        .contours
        .iter()
        .enumerate()
        .map(|(index, level)| {
            let text = format!("{}{}", number(*level), map.contour_unit);
            (Sample::Contour(dash_of(index)), text)
        })
        .collect();
    if map.values.iter().flatten().any(Option::is_none) {
        entries.push((Sample::Hatch, map.missing_label.clone()));
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> HeatMap {
        let x = vec![10.0, 20.0, 35.0];
        let y = vec![-30.0, 0.0, 30.0, 60.0];
        let values = (0..4).map(|row| (0..3).map(|column| Some(0.1 * 3f64.powi(row + column))).collect()).collect();
        HeatMap {
            frame: Frame::full("Error", "error over place and direction"),
            x_label: "place, mm".into(),
            x,
            y_label: "direction, °".into(),
            y,
            y_ticks: None,
            values,
            value_label: "error, %".into(),
            colours: ColourScale::log(0.01, 100.0),
            contours: vec![10.0],
            contour_unit: " %".into(),
            missing_label: "no equilibrium".into(),
            marks_label: "node".into(),
            marks: vec![PlaceMark { x: 20.0, label: "24".into() }],
        }
    }

    /// Filled cells of the map itself, the colour bar's left out.
    fn cells(svg: &str) -> usize {
        svg.matches("<rect ").count() - colour_bar::STEPS
    }

    #[test]
    fn every_cell_of_every_row_is_drawn() {
        assert_eq!(cells(&heat_map(&map()).unwrap()), 12);
    }

    #[test]
    fn a_place_without_value_is_hatched_and_explained() {
        let mut holed = map();
        holed.values[1][1] = None;
        let svg = heat_map(&holed).unwrap();
        assert_eq!(cells(&svg), 11);
        assert!(svg.contains("no equilibrium"));
        assert!(!heat_map(&map()).unwrap().contains("no equilibrium"));
    }

    #[test]
    fn cells_meet_halfway_and_reach_as_far_beyond_the_ends() {
        assert_eq!(bounds(&[10.0, 20.0, 35.0]), [5.0, 15.0, 27.5, 42.5]);
        assert_eq!(ends(&bounds(&[35.0, 20.0, 10.0])), [5.0, 42.5]);
    }

    #[test]
    fn data_that_do_not_fit_together_are_refused() {
        let mut short = map();
        short.values.pop();
        let refusal = heat_map(&short).unwrap_err();
        assert!(matches!(refusal, FigureError::Mismatch { expected: 4, found: 3, .. }));
        let mut unordered = map();
        unordered.x = vec![10.0, 35.0, 20.0];
        assert!(matches!(heat_map(&unordered), Err(FigureError::NotMonotone { .. })));
        let mut broken = map();
        broken.values[0][0] = Some(f64::NAN);
        assert!(matches!(heat_map(&broken), Err(FigureError::NotFinite { .. })));
        let mut negative = map();
        negative.values[0][0] = Some(-1.0);
        assert!(matches!(heat_map(&negative), Err(FigureError::NotPositive { .. })));
    }

    #[test]
    fn values_beyond_the_scale_are_told_at_its_ends() {
        let mut far = map();
        far.values[0][0] = Some(1000.0);
        assert!(heat_map(&far).unwrap().contains("≥ 100"));
        assert!(!heat_map(&map()).unwrap().contains("≥ 100"));
    }
}
