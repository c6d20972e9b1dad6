//! Cells of a map: values on a rectangular grid.

use super::error::{FigureError, require, require_finite, require_len};

/// Values on a rectangular grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Text above the plot of the cells.
    pub note: String,
    /// Positions of the columns, ascending or descending, not necessarily equidistant.
    pub x: Vec<f64>,
    /// Positions of the rows, ascending or descending.
    pub y: Vec<f64>,
    /// Values by row, then column: one row per entry of `y`, one value per entry of `x`; `None` for a missing value.
    pub values: Vec<Vec<Option<f64>>>,
}

/// A single row or column of cells has no neighbours that determine its width. A single row or column occupies this share of the axis.
const LONE: f64 = 0.1;

impl Cells {
    /// Values by row and column, at horizontal positions `x` and vertical positions `y`.
    pub fn new(x: &[f64], y: &[f64], values: Vec<Vec<Option<f64>>>) -> Self {
        Self { note: String::new(), x: x.to_vec(), y: y.to_vec(), values }
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        for (what, positions) in [("map columns", &self.x), ("map rows", &self.y)] {
            require(!positions.is_empty(), FigureError::Empty, what)?;
            require_finite(what, positions.iter())?;
            let all = |holds: fn(f64, f64) -> bool| positions.windows(2).all(|pair| holds(pair[0], pair[1]));
            require(all(|a, b| a < b) || all(|a, b| a > b), FigureError::NotMonotone, what)?;
        }
        require_len("map values", &self.values, self.y.len())?;
        self.values.iter().try_for_each(|row| require_len("a row of map values", row, self.x.len()))?;
        require_finite("map values", self.values.iter().flatten().flatten())
    }
}

/// Edges of cells: midway between neighbouring positions. The outer edge of the first and last cell is as far from the cell's position as its inner edge.
pub(super) fn edges(positions: &[f64], limits: Option<[f64; 2]>) -> Vec<f64> {
    let [first, .., last] = positions else {
        let half = limits.map_or(0.5, |[low, high]| LONE / 2.0 * (high - low));
        return positions.iter().flat_map(|lone| [lone - half, lone + half]).collect();
    };
    let mut edges: Vec<f64> = positions.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
    edges.insert(0, 2.0 * first - edges[0]);
    edges.push(2.0 * last - edges[edges.len() - 1]);
    edges
}
