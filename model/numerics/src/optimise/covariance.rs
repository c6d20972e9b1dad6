//! Covariance of the unknowns of a problem, linearised at its minimum.

use nalgebra::{DMatrix, DVector};

/// Covariance (J^T J)^-1 of the unknowns, for residuals of standard deviation 1; `None` if the inverse does not exist.
///
/// The covariance is valid if the problem is linear within the standard deviations of the unknowns, and no unknown is at a bound.
pub fn covariance(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    jacobian.tr_mul(jacobian).cholesky().map(|factor| factor.inverse())
}

/// Singular values and right singular vectors of the derivatives. Singular values and vectors show which combinations of unknowns the residuals
/// determine.
#[derive(Debug, Clone, PartialEq)]
pub struct SingularParts {
    values: DVector<f64>,
    /// Transposed right singular vectors, one row per singular value.
    vectors: DMatrix<f64>,
}

impl SingularParts {
    /// Decomposes derivatives J, or the triangle R of J = Q R, which has the same singular values and right singular vectors.
    pub fn of(jacobian: DMatrix<f64>) -> SingularParts {
        let svd = jacobian.svd(false, true);
        let count = svd.singular_values.len();
        // The decomposition was asked to compute these vectors, so they exist.
        let vectors = svd.v_t.unwrap_or_else(|| DMatrix::identity(count, count));
        SingularParts { values: svd.singular_values, vectors }
    }

    /// The singular values in descending order.
    pub fn descending(&self) -> Vec<f64> {
        let mut values: Vec<f64> = self.values.iter().copied().collect();
        values.sort_by(|a, b| b.total_cmp(a));
        values
    }

    /// Ratio of the largest to the smallest singular value.
    pub fn span(&self) -> f64 {
        let values = self.descending();
        values[0] / values[values.len() - 1]
    }

    /// The combination of unknowns that the residuals determine least, as a unit vector.
    pub fn weakest(&self) -> DVector<f64> {
        self.vectors.row(self.values.imin()).transpose()
    }

    /// Covariance of unknowns `i` and `j`, for residuals of standard deviation 1: (J^T J)^-1 = V S^-2 V^T.
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        let of = |k: usize| self.vectors[(k, i)] * self.vectors[(k, j)] / self.values[k].powi(2);
        (0..self.values.len()).map(of).sum()
    }
}
