//! How much of everything is computed.

use crate::networks::accuracy;

/// How much is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Coarse maps, for a look or a test.
    Quick,
    /// Fine maps.
    Full,
}

impl Effort {
    /// Random cases for each set of contacts of Table II and of the networks.
    pub(super) fn sensed_cases(self) -> [usize; 2] {
        match self {
            Effort::Quick => [40, 40],
            Effort::Full => [accuracy::ENOUGH_CASES; 2],
        }
    }

    /// Noise samples for each set of contacts and model of the displacements' noise.
    pub(super) fn displacement_noise_cases(self) -> usize {
        match self {
            Effort::Quick => 20,
            Effort::Full => 200,
        }
    }

    /// Places along the front plate, degrees between two directions and noise samples a cell, for which stated intervals are
    /// held against the truth: 816 samples, or 12 240, of which a share of 95 % is known to 0.8 or 0.2 %.
    pub(super) fn covered_cells(self) -> (usize, f64, usize) {
        match self {
            Effort::Quick => (17, 40.0, 3),
            Effort::Full => (60, 20.0, 6),
        }
    }

    /// Noise samples a force at each contact node, for the networks.
    pub(super) fn covered_at_nodes(self) -> usize {
        match self {
            Effort::Quick => 20,
            Effort::Full => 100,
        }
    }

    /// Calibrations of the digital twin, forces a node that are sensed on it, and sets of zones that are fitted.
    pub(super) fn twin(self) -> [usize; 3] {
        match self {
            Effort::Quick => [3, 40, 1],
            Effort::Full => [10, 400, usize::MAX],
        }
    }

    /// Places along the front plate, degrees between two directions, and noise pictures a cell.
    pub(super) fn resolution(self) -> (usize, f64, usize) {
        match self {
            Effort::Quick => (24, 20.0, 100),
            Effort::Full => (48, 5.0, 400),
        }
    }

    /// The same where an answer costs much, or maps differ by more than by their cells: every place and direction is also
    /// one of [`resolution`](Effort::resolution).
    pub(super) fn coarse_resolution(self) -> (usize, f64, usize) {
        match self {
            Effort::Quick => (12, 40.0, 4),
            Effort::Full => (24, 10.0, 12),
        }
    }

    /// The same where the nonlinear estimator cannot explain what it sees.
    pub(super) fn coarsest_resolution(self) -> (usize, f64, usize) {
        match self {
            Effort::Quick => (6, 40.0, 1),
            Effort::Full => (24, 20.0, 1),
        }
    }
}
