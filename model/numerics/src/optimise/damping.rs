//! Damping of the steps of a search.

/// Factor on the damping after an accepted step.
const LOWERED: f64 = 0.1;
/// Factor on the damping after a rejected step.
const RAISED: f64 = 10.0;
/// Smallest damping; a smaller one would change a step only by rounding.
const LEAST: f64 = 1e-14;
/// Largest damping; with a larger one, no significant step remains, and the search ends.
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
