//! The worst force of each cell: the one criterion by which a position and direction is trusted.

use super::map::AccuracyMap;
use super::sweep::{CellState, MapCell};
use crate::settings::TRUSTED_ERROR;

/// A position and direction under the worst of a map's forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstCell {
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Outcome: without equilibrium if one force has none, else refused if one force is.
    pub state: CellState,
    /// Largest of the forces' mean errors; `None` unless all are answered.
    pub worst_error: Option<f64>,
    /// Whether every force is sensed within [`TRUSTED_ERROR`]: what is refused is not trusted.
    pub is_trusted: bool,
}

/// Counts of a map's cells, or of a region's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TrustCounts {
    /// Positions and directions.
    pub cells: usize,
    /// Those that are trusted.
    pub trusted: usize,
    /// Those of which a force is refused.
    pub refused: usize,
    /// Those at which a force has no equilibrium: there is nothing to sense.
    pub without_equilibrium: usize,
}

impl AccuracyMap {
    /// The map's cells under the worst of its forces, by position, then direction.
    pub fn worst(&self) -> Vec<WorstCell> {
        self.worst_of(None)
    }

    /// The same under one force alone, or under the worst of all.
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
    /// Counts cells.
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c WorstCell>) -> TrustCounts {
        cells.into_iter().fold(TrustCounts::default(), |counts, cell| TrustCounts {
            cells: counts.cells + 1,
            trusted: counts.trusted + usize::from(cell.is_trusted),
            refused: counts.refused + usize::from(cell.state == CellState::Refused),
            without_equilibrium: counts.without_equilibrium + usize::from(cell.state == CellState::WithoutEquilibrium),
        })
    }

    /// Cells in which the finger carries every force.
    pub fn carried(&self) -> usize {
        self.cells - self.without_equilibrium
    }

    /// Share of these that are trusted; `None` of none.
    pub fn share(&self) -> Option<f64> {
        let carried = self.carried();
        (carried > 0).then(|| self.trusted as f64 / carried as f64)
    }
}
