//! Sparse Cholesky factorisation (faer). The fill-reducing ordering is computed once.

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::mat::MatMut;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use sprs::CsMat;

/// A fill-reducing ordering of the unknowns and, after [`factorise`](Cholesky::factorise), the factor L of K = L L^T.
#[derive(Debug, Clone, Default)]
pub struct Cholesky {
    symbolic: Option<SymbolicLlt<usize>>,
    numeric: Option<Llt<usize, f64>>,
}

impl Cholesky {
    /// Factorises a symmetric matrix. Returns `false` and keeps no factor if the matrix is not positive definite or not finite.
    pub fn factorise(&mut self, matrix: &CsMat<f64>) -> bool {
        self.numeric = None;
        let count = matrix.rows();
        let indptr = matrix.indptr();
        let pattern = SymbolicSparseColMatRef::new_checked(count, count, indptr.raw_storage(), None, matrix.indices());
        if self.symbolic.is_none() {
            self.symbolic = SymbolicLlt::try_new(pattern, Side::Lower).ok();
        }
        let values = SparseColMatRef::new(pattern, matrix.data());
        self.numeric =
            self.symbolic.clone().and_then(|symbolic| Llt::try_new_with_symbolic(symbolic, values, Side::Lower).ok());
        self.numeric.is_some()
    }

    /// Whether a factor exists: there was a factorisation, and the last one succeeded.
    pub fn is_there(&self) -> bool {
        self.numeric.is_some()
    }

    /// Overwrites each column x of `columns` with K^-1 x; columns are stored one after the other and have `unknowns` entries each.
    ///
    /// Returns `false` if there is no factor or a result is not finite. The columns stay unchanged only if there is no factor.
    pub fn solve_in_place(&self, columns: &mut [f64], unknowns: usize) -> bool {
        let Some(numeric) = &self.numeric else { return false };
        if unknowns == 0 {
            return true;
        }
        let count = columns.len() / unknowns;
        numeric.solve_in_place(MatMut::from_column_major_slice_mut(columns, unknowns, count));
        columns.iter().all(|value| value.is_finite())
    }
}
