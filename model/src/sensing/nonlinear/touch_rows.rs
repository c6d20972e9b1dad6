//! Rows of the least squares problem below the markers and priors: an object of known shape touches the plate.

/// What geometry asks of a state, as rows of the least squares problem.
#[derive(Debug, Clone, Default)]
pub(super) struct TouchRows {
    /// By how much it is missed, mm of noise.
    pub misses_mm: Vec<f64>,
    /// By the unknowns, one after the other.
    by_unknown: Vec<f64>,
}

impl TouchRows {
    pub fn count(&self) -> usize {
        self.misses_mm.len()
    }

    /// Takes over what is missed, and makes room for its derivatives.
    pub fn reset(&mut self, misses_mm: Vec<f64>, unknowns: usize) {
        self.by_unknown.clear();
        self.by_unknown.resize(misses_mm.len() * unknowns, 0.0);
        self.misses_mm = misses_mm;
    }

    /// Derivatives by an unknown.
    pub fn by_unknown(&self, unknown: usize) -> &[f64] {
        &self.by_unknown[unknown * self.count()..][..self.count()]
    }

    pub fn by_unknown_mut(&mut self, unknown: usize) -> impl Iterator<Item = &mut f64> {
        let count = self.count();
        self.by_unknown[unknown * count..][..count].iter_mut()
    }
}
