//! Sparse LDL^T factorisation of a symmetric, possibly indefinite matrix (faer), with the signs of its pivots.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::mat::MatMut;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};
use sprs::CsMat;
use std::sync::Arc;

/// The factors of K = L D L^T with diagonal D. The ordering of the unknowns is computed at the first factorisation.
///
/// By Sylvester's law of inertia, K has as many negative eigenvalues as D has negative entries. The factorisation does not pivot, so a nearly
/// singular matrix may cost digits. Newton's method recovers the digits that the factorisation loses, because it computes the residual anew in each
/// step.
#[derive(Debug, Clone, Default)]
pub struct IndefiniteFactor {
    symbolic: Option<Arc<SymbolicCholesky<usize>>>,
    values: Vec<f64>,
}

impl IndefiniteFactor {
    /// Factorises a matrix whose sparsity pattern never changes. Returns the number of negative pivots, or `None` if a pivot is zero or not finite.
    pub fn factorise(&mut self, matrix: &CsMat<f64>) -> Option<usize> {
        let count = matrix.rows();
        let indptr = matrix.indptr();
        let pattern = SymbolicSparseColMatRef::new_checked(count, count, indptr.raw_storage(), None, matrix.indices());
        if self.symbolic.is_none() {
            // The simplicial method stores each pivot at the head of its column of L.
            let params = CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
                ..CholeskySymbolicParams::default()
            };
            let order = SymmetricOrdering::Amd;
            self.symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, order, params).ok().map(Arc::new);
        }
        let symbolic = self.symbolic.as_ref()?;
        self.values.clear();
        self.values.resize(symbolic.len_val(), 0.0);
        let need = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        symbolic
            .factorize_numeric_ldlt(
                &mut self.values,
                SparseColMatRef::new(pattern, matrix.data()),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut MemBuffer::try_new(need).ok()?),
                Default::default(),
            )
            .ok()?;
        self.pivots()?.try_fold(0, |negative, pivot| pivot.is_finite().then_some(negative + usize::from(pivot < 0.0)))
    }

    /// The diagonal of D, stored at the head of each column of L.
    fn pivots(&self) -> Option<impl Iterator<Item = f64>> {
        let SymbolicCholeskyRaw::Simplicial(columns) = self.symbolic.as_ref()?.raw() else { return None };
        let heads = columns.col_ptr();
        Some(heads[..heads.len() - 1].iter().map(|&head| self.values[head]))
    }

    /// Natural logarithm of the determinant; `None` without factors, or if any pivot is not positive.
    pub fn log_determinant(&self) -> Option<f64> {
        let sum: f64 = self.pivots()?.map(f64::ln).sum();
        sum.is_finite().then_some(sum)
    }

    /// Overwrites a vector x with K^-1 x; `None` without factors, or if the result is not finite.
    pub fn solve_in_place(&self, vector: &mut [f64]) -> Option<()> {
        let symbolic = self.symbolic.as_ref()?;
        let need = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        let mut memory = MemBuffer::try_new(need).ok()?;
        let count = vector.len();
        LdltRef::new(symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(vector, count, 1),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        vector.iter().all(|value| value.is_finite()).then_some(())
    }
}
