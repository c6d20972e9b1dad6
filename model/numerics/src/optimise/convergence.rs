//! Convergence criteria of a search.

/// Default limit of the relative decrease. With this limit, the search ends within 1e-6 standard deviations of the minimum.
const RELATIVE_DECREASE: f64 = 2e-13;

/// Limits below which the next step counts as negligible. A search ends when the step is below either limit.
///
/// # Reference
/// The decrease is the squared relative offset of Bates and Watts, Nonlinear Regression Analysis, sec. 2.2.3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Limit of the predicted decrease of the sum of squares, as a share of a reference: the sum of squares or a variance.
    pub relative_decrease: f64,
    /// Limit of the largest change of an unknown, in the unknown's unit. The value 0 disables the limit, for problems whose unknowns have different
    /// units.
    pub step: f64,
}

impl Default for Convergence {
    fn default() -> Convergence {
        Convergence { relative_decrease: RELATIVE_DECREASE, step: 0.0 }
    }
}

impl Convergence {
    /// Whether a predicted decrease is negligible compared with a reference.
    #[inline]
    pub fn is_small_decrease(&self, decrease: f64, reference: f64) -> bool {
        decrease <= self.relative_decrease * reference
    }

    /// Whether the largest change of an unknown is negligible.
    #[inline]
    pub fn is_small_step(&self, largest_change: f64) -> bool {
        largest_change <= self.step
    }
}
