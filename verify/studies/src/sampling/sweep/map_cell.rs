//! Cells of an accuracy map: the cells of a sweep with one true finger, one estimator and one noise level.

use super::Cell;
use serde::{Deserialize, Serialize};

/// Results for one force at one position and direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MapCell {
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Mean of |sensed / true - 1| over answered samples and over the uncertain stiffness of the scene's finger; `None` without equilibrium, or if more than half of the samples are refused.
    pub mean_error: Option<f64>,
    /// Mean of sensed / true - 1, dimensionless: the systematic error. `None` like `mean_error`.
    pub bias: Option<f64>,
    /// Standard deviation of sensed / true over the noise samples, dimensionless.
    pub spread: Option<f64>,
    /// Number of noise samples: 1 at the noise level 0, and 0 if the finger has no equilibrium.
    pub samples: usize,
    /// Number of answered samples, over which `mean_error`, `bias` and `spread` are computed.
    pub answered: usize,
    /// Number of answers with a warning; `None` if no standard deviation is stated.
    pub warned: Option<usize>,
    /// Number of answers without a warning whose interval of 1.96 stated standard deviations contains the true force.
    pub covered: Option<usize>,
    /// Number of answers with a warning whose interval of 1.96 stated standard deviations contains the true force.
    pub covered_warned: Option<usize>,
}

/// Outcome of one force, or the worst outcome of several forces, at one position and direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CellState {
    /// At least half of the samples were answered.
    Answered,
    /// The finger has an equilibrium, but the estimator refuses more than half of the samples. The answered samples are then a biased selection.
    Refused,
    /// The finger has no equilibrium under the force, so no force can be sensed.
    WithoutEquilibrium,
}

impl CellState {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            CellState::Answered => "answered",
            CellState::Refused => "refused",
            CellState::WithoutEquilibrium => "no equilibrium",
        }
    }
}

impl MapCell {
    /// Outcome of the cell.
    pub fn state(&self) -> CellState {
        match (self.samples, self.mean_error) {
            (0, _) => CellState::WithoutEquilibrium,
            (_, None) => CellState::Refused,
            (_, Some(_)) => CellState::Answered,
        }
    }

    /// Whether the mean error is above a limit. A refused cell counts as above the limit; `None` for a cell without equilibrium.
    pub fn is_above(&self, limit: f64) -> Option<bool> {
        (self.state() != CellState::WithoutEquilibrium).then(|| self.mean_error.is_none_or(|error| error > limit))
    }
}

impl From<&Cell> for MapCell {
    fn from(cell: &Cell) -> MapCell {
        MapCell {
            s_mm: cell.s_mm,
            angle_deg: cell.angle_deg,
            force_n: cell.force_n,
            mean_error: cell.mean_error,
            bias: cell.bias,
            spread: cell.spread,
            samples: cell.samples,
            answered: cell.answered,
            warned: cell.warned,
            covered: cell.covered,
            covered_warned: cell.covered_warned,
        }
    }
}
