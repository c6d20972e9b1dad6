//! Rows of the least-squares problem for an object of known shape that touches the plate, below the markers and priors.

/// Conditions of contacts with an object, as rows of the least-squares problem.
#[derive(Debug, Clone, Default)]
pub(super) struct TouchRows {
    /// Violation of each condition in its standard deviations, times the noise, mm.
    pub misses_mm: Vec<f64>,
    /// Derivatives of the violations with respect to the unknowns, mm per unit of the unknown, one unknown after the other.
    by_unknown: Vec<f64>,
}

impl TouchRows {
    /// Number of conditions.
    pub fn count(&self) -> usize {
        self.misses_mm.len()
    }

    /// Sets the violations to `misses_mm`, and their derivatives with respect to `unknowns` unknowns to zero.
    pub fn reset(&mut self, misses_mm: Vec<f64>, unknowns: usize) {
        self.by_unknown.clear();
        self.by_unknown.resize(misses_mm.len() * unknowns, 0.0);
        self.misses_mm = misses_mm;
    }

    /// Derivatives of the violations with respect to an unknown, mm per unit of the unknown.
    pub fn by_unknown(&self, unknown: usize) -> &[f64] {
        &self.by_unknown[unknown * self.count()..][..self.count()]
    }

    /// Mutable derivatives of the violations with respect to an unknown, mm per unit of the unknown.
    pub fn by_unknown_mut(&mut self, unknown: usize) -> impl Iterator<Item = &mut f64> {
        let count = self.count();
        self.by_unknown[unknown * count..][..count].iter_mut()
    }
}
