//! How much a step is damped.

/// Factors on the damping after a step that was taken and after one that was not.
const LOWERED: f64 = 0.1;
const RAISED: f64 = 10.0;
/// Damping that changes a step by no more than rounding, and damping that leaves nothing of it.
const LEAST: f64 = 1e-14;
const MOST: f64 = 1e10;

/// The damping of the next step, as a share of the diagonal of the normal equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Damping(pub f64);

impl Damping {
    /// After a step that was taken.
    pub(super) fn lower(&mut self) {
        self.0 = (self.0 * LOWERED).max(LEAST);
    }

    /// After a step that was not taken; whether a shorter one is left.
    pub(super) fn raise(&mut self) -> bool {
        self.0 = (self.0 * RAISED).max(LEAST);
        self.0 <= MOST
    }
}
