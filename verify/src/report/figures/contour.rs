//! Lines of equal value on a grid (marching squares).

use std::collections::BTreeMap;

use super::frame::Point;

/// A grid edge that a line crosses: between a grid point and its neighbour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Edge {
    /// From (row, column) to the next column.
    Across(usize, usize),
    /// From (row, column) to the next row.
    Up(usize, usize),
}

/// The lines along which the values are `level`, in the coordinates of `x` and `y`.
///
/// Between grid points values are taken to run straight. A square with a
/// missing corner is left out, so lines end where the data do.
pub(super) fn contour(x: &[f64], y: &[f64], values: &[Vec<Option<f64>>], level: f64) -> Vec<Vec<Point>> {
    let mut pieces = Vec::new();
    for row in 0..y.len().saturating_sub(1) {
        for column in 0..x.len().saturating_sub(1) {
            if let Some(corners) = corners(values, row, column) {
                pieces.extend(crossings(corners, row, column, level));
            }
        }
    }
    let point = |edge: Edge| crossing_point(x, y, values, level, edge);
    join(&pieces).into_iter().map(|edges| edges.into_iter().filter_map(point).collect()).collect()
}

/// Values at a square's corners, anticlockwise from the first row and column.
fn corners(values: &[Vec<Option<f64>>], row: usize, column: usize) -> Option<[f64; 4]> {
    let at = |row: usize, column: usize| values.get(row)?.get(column).copied()?;
    Some([at(row, column)?, at(row, column + 1)?, at(row + 1, column + 1)?, at(row + 1, column)?])
}

/// The pieces of line within one square, as the two edges each joins.
fn crossings(corners: [f64; 4], row: usize, column: usize, level: f64) -> Vec<[Edge; 2]> {
    let [bottom, right, top, left] =
        [Edge::Across(row, column), Edge::Up(row, column + 1), Edge::Across(row + 1, column), Edge::Up(row, column)];
    let above = corners.map(|value| value >= level);
    match above {
        [false, false, false, false] | [true, true, true, true] => vec![],
        [true, false, false, false] | [false, true, true, true] => vec![[left, bottom]],
        [false, true, false, false] | [true, false, true, true] => vec![[bottom, right]],
        [false, false, true, false] | [true, true, false, true] => vec![[right, top]],
        [false, false, false, true] | [true, true, true, false] => vec![[top, left]],
        [true, true, false, false] | [false, false, true, true] => vec![[left, right]],
        [true, false, false, true] | [false, true, true, false] => vec![[bottom, top]],
        [true, false, true, false] | [false, true, false, true] => {
            // A saddle: the middle decides which of the two corners hang together.
            let middle_above = corners.iter().sum::<f64>() / 4.0 >= level;
            if middle_above == above[0] {
                vec![[left, top], [bottom, right]]
            } else {
                vec![[left, bottom], [top, right]]
            }
        }
    }
}

/// Joins pieces that share an edge into lines; a closed line ends where it began.
fn join(pieces: &[[Edge; 2]]) -> Vec<Vec<Edge>> {
    let mut at_edge: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
    for (index, piece) in pieces.iter().enumerate() {
        for edge in piece {
            at_edge.entry(*edge).or_default().push(index);
        }
    }
    // Open lines must be followed from an end; what is left then is closed.
    let ends = at_edge.iter().filter(|(_, pieces)| pieces.len() == 1);
    let starts: Vec<Edge> = ends.chain(at_edge.iter()).map(|(edge, _)| *edge).collect();
    let mut used = vec![false; pieces.len()];
    let mut lines = Vec::new();
    for start in starts {
        let mut line = vec![start];
        let mut here = start;
        while let Some(next) = at_edge[&here].iter().copied().find(|index| !used[*index]) {
            used[next] = true;
            let [one, other] = pieces[next];
            here = if one == here { other } else { one };
            line.push(here);
        }
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

fn crossing_point(x: &[f64], y: &[f64], values: &[Vec<Option<f64>>], level: f64, edge: Edge) -> Option<Point> {
    let ([row, column], [next_row, next_column]) = match edge {
        Edge::Across(row, column) => ([row, column], [row, column + 1]),
        Edge::Up(row, column) => ([row, column], [row + 1, column]),
    };
    let (from, to) = (values[row][column]?, values[next_row][next_column]?);
    let part = (level - from) / (to - from);
    Some([x[column] + (x[next_column] - x[column]) * part, y[row] + (y[next_row] - y[row]) * part])
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
        for [x, y] in &lines[0] {
            assert!((2.0 * x + y - 5.0).abs() < 1e-12, "({x}, {y})");
        }
        let mut ends = [lines[0][0], lines[0][lines[0].len() - 1]];
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(ends, [[0.0, 5.0], [3.5, -2.0]]);
    }

    #[test]
    fn a_hill_has_a_closed_contour() {
        let x: Vec<f64> = (-6..=6).map(f64::from).collect();
        let values: Vec<Vec<Option<f64>>> =
            x.iter().map(|y| x.iter().map(|x| Some(-x * x - y * y)).collect()).collect();
        let lines = contour(&x, &x, &values, -16.5);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        let off = |[x, y]: &Point| (x.hypot(*y) - 16.5f64.sqrt()).abs();
        assert!(lines[0].iter().all(|point| off(point) < 0.1));
    }

    #[test]
    fn no_line_runs_through_a_square_with_a_missing_corner() {
        let whole = grid(|x, _| Some(x));
        assert_eq!(contour(&X, &Y, &whole, 2.0)[0].len(), 4);
        let holed = grid(|x, y| (x != 3.0 || y != 0.0).then_some(x));
        let lines = contour(&X, &Y, &holed, 2.0);
        assert_eq!(lines, [[[2.0, 1.0], [2.0, 5.0]]]);
    }

    #[test]
    fn a_saddle_is_split_in_two_lines_that_do_not_cross() {
        let values = vec![vec![Some(1.0), Some(0.0)], vec![Some(0.0), Some(1.0)]];
        let axis = [0.0, 1.0];
        assert_eq!(contour(&axis, &axis, &values, 0.4).len(), 2);
        assert_eq!(contour(&axis, &axis, &values, 0.6).len(), 2);
    }

    #[test]
    fn a_level_out_of_reach_has_no_line() {
        assert!(contour(&X, &Y, &grid(|x, _| Some(x)), 8.0).is_empty());
    }
}
