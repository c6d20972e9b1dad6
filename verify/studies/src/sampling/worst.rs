//! The worst result among the forces of each cell (position and direction). The worst result alone decides whether a cell counts as trusted.

use super::map::AccuracyMap;
use super::sweep::{CellState, MapCell};
use crate::settings::TRUSTED_ERROR;

/// A position and direction, with the worst result among the map's forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstCell {
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Outcome of the cell: without equilibrium if any force has no equilibrium; otherwise refused if any force is refused.
    pub state: CellState,
    /// Largest mean relative error among the forces; `None` unless all are answered.
    pub worst_error: Option<f64>,
    /// Whether the error of every force is within [`TRUSTED_ERROR`]; `false` if a force is refused.
    pub is_trusted: bool,
}

/// Counts of the cells of a map, or of a region of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TrustCounts {
    /// Number of cells (pairs of position and direction).
    pub cells: usize,
    /// Number of trusted cells.
    pub trusted: usize,
    /// Number of cells with a refused force.
    pub refused: usize,
    /// Number of cells in which a force has no equilibrium, so that nothing can be sensed.
    pub without_equilibrium: usize,
}

impl AccuracyMap {
    /// Each cell with its worst result among the map's forces, ordered by position, then direction.
    pub fn worst(&self) -> Vec<WorstCell> {
        self.worst_of(None)
    }

    /// Each cell with the result for one force (N), or with the worst result among all forces if `force_n` is `None`; ordered by position, then
    /// direction.
    pub fn worst_of(&self, force_n: Option<f64>) -> Vec<WorstCell> {
        let of_group = |group: &[MapCell]| {
            let cells: Vec<MapCell> =
                group.iter().filter(|cell| force_n.is_none_or(|f| f == cell.force_n)).copied().collect();
            let state = cells.iter().map(MapCell::state).max().unwrap_or(CellState::WithoutEquilibrium);
            let errors: Option<Vec<f64>> = cells.iter().map(|cell| cell.mean_error).collect();
            let worst_error = errors.and_then(|errors| errors.into_iter().reduce(f64::max));
            let is_trusted = worst_error.is_some_and(|error| error <= TRUSTED_ERROR);
            WorstCell { s_mm: group[0].s_mm, angle_deg: group[0].angle_deg, state, worst_error, is_trusted }
        };
        self.cells.chunks(self.request.forces_n.len().max(1)).map(of_group).collect()
    }
}

impl TrustCounts {
    /// Counts the cells.
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c WorstCell>) -> TrustCounts {
        cells.into_iter().fold(TrustCounts::default(), |counts, cell| TrustCounts {
            cells: counts.cells + 1,
            trusted: counts.trusted + usize::from(cell.is_trusted),
            refused: counts.refused + usize::from(cell.state == CellState::Refused),
            without_equilibrium: counts.without_equilibrium + usize::from(cell.state == CellState::WithoutEquilibrium),
        })
    }

    /// Number of cells with equilibrium under every force.
    pub fn carried(&self) -> usize {
        self.cells - self.without_equilibrium
    }

    /// Share of trusted cells among the cells with equilibrium under every force; `None` without such cells.
    pub fn share(&self) -> Option<f64> {
        let carried = self.carried();
        (carried > 0).then(|| self.trusted as f64 / carried as f64)
    }
}
