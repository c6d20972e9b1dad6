//! Lines of equal value on a map.

use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::cells::Cells;
use super::colour::ON_MAP;
use super::error::FigureError;
use super::geometry::{Area, Lines, Point, between, length};
use super::panels::Plot;
use super::shades::ColourScale;
use super::sheet::{Dash, Sheet, TICK_TEXT, bold};
use super::text::{number, width_of};

/// How the line of the n-th level is broken.
pub(super) fn dash(nth: usize) -> Dash {
    [Dash::Solid, Dash::Dashed, Dash::Dotted][nth % 3]
}

/// Draws the lines at levels, and two labels of each with its unit at most.
pub(super) fn draw(
    sheet: &Sheet,
    plot: &Plot,
    cells: &Cells,
    colours: &ColourScale,
    (levels, unit): (&[f64], &str),
) -> Result<(), FigureError> {
    // Values are linear along the colour scale. One of zero has no logarithm: the scale's lower end stands for it.
    let measure = |value: f64| value.max(colours.limits[0]).log10();
    let row = |row: &Vec<Option<f64>>| row.iter().map(|value| value.map(measure)).collect();
    let values: Vec<Vec<Option<f64>>> = cells.values.iter().map(row).collect();
    let mut labels: Vec<(Area, String)> = Vec::new();
    for (nth, level) in levels.iter().enumerate() {
        let text = format!("{}{unit}", number(*level));
        let lines = contour(&cells.x, &cells.y, &values, measure(*level));
        let mut lines: Lines = lines.iter().map(|line| plot.line(line)).collect();
        lines.sort_by(|a, b| length(b).total_cmp(&length(a)));
        lines.iter().try_for_each(|line| sheet.contour(line, dash(nth)))?;
        for line in lines.iter().filter(|line| length(line) > 130.0).take(2) {
            // As near its middle as can be, where the label hides no other.
            let parts = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8];
            let at = parts.map(|part| line[((line.len() - 1) as f64 * part).round() as usize]);
            let area = |at| Area::about(at, width_of(&text, TICK_TEXT) + 8.0, TICK_TEXT * 1.3);
            let free = |area: &Area| plot.area.holds(area) && !labels.iter().any(|(other, _)| other.meets(area));
            let found = at.map(area).into_iter().find(free);
            labels.extend(found.map(|area| (area, text.clone())));
        }
    }
    let style = bold(TICK_TEXT).color(&ON_MAP).pos(Pos::new(HPos::Center, VPos::Center));
    labels.iter().try_for_each(|(area, text)| sheet.words(text, area.centre(), &style))
}

/// The lines along which the values are `level`, in the coordinates of `x` and `y`.
///
/// A rectangle of four neighbours is cut into four triangles that meet at the mean of its corners; within each, values are linear. A
/// rectangle with a missing corner is left out, so lines end where the data do.
fn contour(x: &[f64], y: &[f64], values: &[Vec<Option<f64>>], level: f64) -> Lines {
    let mut pieces = Vec::new();
    for (row, y) in y.windows(2).enumerate() {
        for (column, x) in x.windows(2).enumerate() {
            let corner = |i: usize, j: usize| Some(([x[i], y[j]], values[row + j][column + i]?));
            let Some(corners) = [[0, 0], [1, 0], [1, 1], [0, 1]].into_iter().map(|[i, j]| corner(i, j)).collect()
            else {
                continue;
            };
            let corners: Vec<(Point, f64)> = corners;
            let mean = corners.iter().map(|corner| corner.1).sum::<f64>() / 4.0;
            let centre = (between(corners[0].0, corners[2].0, 0.5), mean);
            pieces.extend((0..4).filter_map(|i| crossing([centre, corners[i], corners[(i + 1) % 4]], level)));
        }
    }
    join(pieces)
}

/// The piece of line within a triangle.
fn crossing(corners: [(Point, f64); 3], level: f64) -> Option<[Point; 2]> {
    let edges = [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|end| corners[end]));
    // From the lower end to the higher one: neighbours that share an edge find the very same point.
    let point = |[a, b]: [(Point, f64); 2]| match (a.1 < level, b.1 < level) {
        (true, false) => Some(between(a.0, b.0, (level - a.1) / (b.1 - a.1))),
        (false, true) => Some(between(b.0, a.0, (level - b.1) / (a.1 - b.1))),
        _ => None,
    };
    let mut points = edges.into_iter().filter_map(point);
    Some([points.next()?, points.next()?]).filter(|[a, b]| a != b)
}

/// Joins pieces that share an end into lines; a closed line ends where it began.
fn join(mut pieces: Vec<[Point; 2]>) -> Lines {
    let mut lines = Vec::new();
    while let Some(piece) = pieces.pop() {
        let mut line = piece.to_vec();
        // On from its end, then, turned round, from its beginning.
        for _ in 0..2 {
            while let Some(next) = pieces.iter().position(|piece| line.last().is_some_and(|end| piece.contains(end))) {
                let [a, b] = pieces.swap_remove(next);
                line.push(if line.last() == Some(&a) { b } else { a });
            }
            line.reverse();
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 5] = [0.0, 1.0, 3.0, 4.0, 7.0];
    const Y: [f64; 4] = [-2.0, 0.0, 1.0, 5.0];

    fn grid(value: impl Fn(f64, f64) -> Option<f64>) -> Vec<Vec<Option<f64>>> {
        Y.iter().map(|y| X.iter().map(|x| value(*x, *y)).collect()).collect()
    }

    #[test]
    fn the_contour_of_a_plane_is_its_straight_line_from_edge_to_edge() {
        // 2x + y = 5 on a grid of unequal steps.
        let lines = contour(&X, &Y, &grid(|x, y| Some(2.0 * x + y)), 5.0);
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].iter().all(|[x, y]| (2.0 * x + y - 5.0).abs() < 1e-12), "{lines:?}");
        let mut ends = [lines[0][0], lines[0][lines[0].len() - 1]];
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(ends, [[0.0, 5.0], [3.5, -2.0]]);
        assert!(contour(&X, &Y, &grid(|x, _| Some(x)), 8.0).is_empty());
    }

    #[test]
    fn a_hill_has_a_closed_contour() {
        let x: Vec<f64> = (-6..=6).map(f64::from).collect();
        let values: Vec<Vec<_>> = x.iter().map(|y| x.iter().map(|x| Some(-x * x - y * y)).collect()).collect();
        let lines = contour(&x, &x, &values, -16.5);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        assert!(lines[0].iter().all(|[x, y]| (x.hypot(*y) - 16.5f64.sqrt()).abs() < 0.1));
    }

    #[test]
    fn no_line_runs_through_a_rectangle_with_a_missing_corner() {
        let lines = contour(&X, &Y, &grid(|x, y| (x != 3.0 || y != 0.0).then_some(x)), 2.0);
        let length: f64 = lines.iter().map(|line| length(line)).sum();
        assert!(lines.len() == 1 && lines[0].iter().all(|point| point[0] == 2.0) && length == 4.0, "{lines:?}");
    }

    #[test]
    fn a_saddle_is_split_in_two_lines_that_do_not_cross() {
        let values = [vec![Some(1.0), Some(0.0)], vec![Some(0.0), Some(1.0)]];
        for level in [0.4, 0.6] {
            assert_eq!(contour(&[0.0, 1.0], &[0.0, 1.0], &values, level).len(), 2);
        }
    }
}
