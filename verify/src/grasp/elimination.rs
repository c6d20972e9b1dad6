//! Sparse linear equations whose pattern mostly stays from one step of Newton's method to the next: it is sorted and ordered once.

use faer::linalg::solvers::Solve;
use faer::mat::MatMut;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat, Triplet};

/// LU elimination that keeps the order of the last pattern.
#[derive(Clone, Default)]
pub(super) struct Elimination {
    kept: Option<Kept>,
}

#[derive(Clone)]
struct Kept {
    indices: Vec<Pair<usize, usize>>,
    pattern: SymbolicSparseColMat<usize>,
    order_of_entries: Argsort<usize>,
    order: SymbolicLu<usize>,
}

impl std::fmt::Debug for Elimination {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Elimination").field("is_kept", &self.kept.is_some()).finish()
    }
}

impl Elimination {
    /// Solves for `right`, in place; entries of the matrix at the same place add up. `None` for a singular matrix.
    pub fn solve(&mut self, entries: &[Triplet<usize, usize, f64>], right: &mut [f64]) -> Option<()> {
        let indices = || entries.iter().map(|entry| Pair::new(entry.row, entry.col));
        let count = right.len();
        let fits = |kept: &Kept| {
            kept.pattern.nrows() == count
                && kept.indices.len() == entries.len()
                && indices().zip(&kept.indices).all(|(a, b)| (a.row, a.col) == (b.row, b.col))
        };
        let kept = match self.kept.take().filter(fits) {
            Some(kept) => kept,
            None => {
                let indices: Vec<_> = indices().collect();
                let (pattern, order_of_entries) =
                    SymbolicSparseColMat::try_new_from_indices(count, count, &indices).ok()?;
                let order = SymbolicLu::try_new(pattern.as_ref()).ok()?;
                Kept { indices, pattern, order_of_entries, order }
            }
        };
        let values: Vec<f64> = entries.iter().map(|entry| entry.val).collect();
        let matrix = SparseColMat::new_from_argsort(kept.pattern.clone(), &kept.order_of_entries, &values).ok()?;
        let factorised = Lu::try_new_with_symbolic(kept.order.clone(), matrix.as_ref());
        self.kept = Some(kept);
        factorised.ok()?.solve_in_place(MatMut::from_column_major_slice_mut(right, count, 1));
        right.iter().all(|x| x.is_finite()).then_some(())
    }
}
