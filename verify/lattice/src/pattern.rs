//! Where the entries of a sparse matrix are: sorted once for all matrices that have theirs at the same places.

use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat, Triplet};

/// Places of a square matrix's entries, in the order in which they are handed in.
#[derive(Clone)]
pub struct Pattern {
    places: Vec<Pair<usize, usize>>,
    symbolic: SymbolicSparseColMat<usize>,
    order: Argsort<usize>,
}

impl Pattern {
    /// The pattern of some entries; entries at the same place add up. `None` if one is outside the matrix.
    pub fn of(count: usize, entries: &[Triplet<usize, usize, f64>]) -> Option<Pattern> {
        let places: Vec<_> = entries.iter().map(|entry| Pair::new(entry.row, entry.col)).collect();
        let (symbolic, order) = SymbolicSparseColMat::try_new_from_indices(count, count, &places).ok()?;
        Some(Pattern { places, symbolic, order })
    }

    /// Whether these entries have their places in this order.
    pub fn fits(&self, count: usize, entries: &[Triplet<usize, usize, f64>]) -> bool {
        self.symbolic.nrows() == count
            && self.places.len() == entries.len()
            && entries.iter().zip(&self.places).all(|(entry, place)| (entry.row, entry.col) == (place.row, place.col))
    }

    /// Where the entries are, for the order of an elimination.
    pub fn symbolic(&self) -> &SymbolicSparseColMat<usize> {
        &self.symbolic
    }

    /// The matrix of entries that fit; `None` without memory.
    pub fn matrix(&self, entries: &[Triplet<usize, usize, f64>]) -> Option<SparseColMat<usize, f64>> {
        let values: Vec<f64> = entries.iter().map(|entry| entry.val).collect();
        SparseColMat::new_from_argsort(self.symbolic.clone(), &self.order, &values).ok()
    }
}
