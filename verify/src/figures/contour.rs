//! Lines of equal value on a grid.

use super::geometry::{Lines, Point, between};

/// The lines along which the values are `level`, in the coordinates of `x` and `y`.
///
/// A rectangle of four neighbours is cut into four triangles that meet at the mean of its corners; within each, values are linear. A
/// rectangle with a missing corner is left out, so lines end where the data do.
pub(super) fn contour(x: &[f64], y: &[f64], values: &[Vec<Option<f64>>], level: f64) -> Lines {
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
        let length: f64 = lines.iter().map(|line| super::super::geometry::length(line)).sum();
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
