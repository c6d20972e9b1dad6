//! Sparse linear equations whose pattern mostly stays from one step of Newton's method to the next: it is sorted and ordered once.

use crate::lattice::pattern::Pattern;
use faer::linalg::solvers::Solve;
use faer::mat::MatMut;
use faer::sparse::Triplet;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};

/// LU elimination that keeps pattern and order of the last matrix.
#[derive(Clone, Default)]
pub(super) struct Elimination {
    kept: Option<(Pattern, SymbolicLu<usize>)>,
}

impl std::fmt::Debug for Elimination {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Elimination").field("is_kept", &self.kept.is_some()).finish()
    }
}

impl Elimination {
    /// Solves for `right`, in place; entries of the matrix at the same place add up. `None` for a singular matrix.
    pub fn solve(&mut self, entries: &[Triplet<usize, usize, f64>], right: &mut [f64]) -> Option<()> {
        let count = right.len();
        if !self.kept.as_ref().is_some_and(|(pattern, _)| pattern.fits(count, entries)) {
            let pattern = Pattern::of(count, entries)?;
            let order = SymbolicLu::try_new(pattern.symbolic().as_ref()).ok()?;
            self.kept = Some((pattern, order));
        }
        let (pattern, order) = self.kept.as_ref()?;
        let matrix = pattern.matrix(entries)?;
        let factorised = Lu::try_new_with_symbolic(order.clone(), matrix.as_ref()).ok()?;
        factorised.solve_in_place(MatMut::from_column_major_slice_mut(right, count, 1));
        right.iter().all(|x| x.is_finite()).then_some(())
    }
}
