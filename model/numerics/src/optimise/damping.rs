//! Damping of the steps of a search.

/// Factors on the damping after an accepted and after a rejected step.
const LOWERED: f64 = 0.1;
const RAISED: f64 = 10.0;
/// Damping below which a step changes by rounding only, and damping above which no significant step remains.
const LEAST: f64 = 1e-14;
const MOST: f64 = 1e10;

/// Damping of the next step, as a share of the diagonal of the normal equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Damping(pub f64);

impl Damping {
    /// Lowers the damping after an accepted step.
    pub(super) fn lower(&mut self) {
        self.0 = (self.0 * LOWERED).max(LEAST);
    }

    /// Raises the damping after a rejected step. Returns whether a shorter step is still worth trying.
    pub(super) fn raise(&mut self) -> bool {
        self.0 = (self.0 * RAISED).max(LEAST);
        self.0 <= MOST
    }
}
