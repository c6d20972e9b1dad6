//! When a search has converged.

/// Decrease at which a search ends unless told otherwise: the unknowns are then within 1e-6 of their standard deviations.
const RELATIVE_DECREASE: f64 = 2e-13;

/// Limits below which the next step is too small to count. Either ends the search.
///
/// # Reference
/// The decrease is the squared relative offset of Bates and Watts, Nonlinear Regression Analysis, sec. 2.2.3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Predicted decrease of the sum of squares, as a share of a reference: the sum of squares or a variance.
    pub relative_decrease: f64,
    /// Largest change of an unknown. 0 where unknowns have different units, and none of them is this limit's.
    pub step: f64,
}

impl Default for Convergence {
    fn default() -> Convergence {
        Convergence { relative_decrease: RELATIVE_DECREASE, step: 0.0 }
    }
}

impl Convergence {
    /// Whether a predicted decrease is too small to count beside a reference.
    #[inline]
    pub fn is_small_decrease(&self, decrease: f64, reference: f64) -> bool {
        decrease <= self.relative_decrease * reference
    }

    /// Whether the largest change of an unknown is too small to count.
    #[inline]
    pub fn is_small_step(&self, largest_change: f64) -> bool {
        largest_change <= self.step
    }
}
