//! Sparsity pattern of a matrix, sorted once for all matrices with entries at the same indices.

use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat, Triplet};

/// Indices of a square matrix's entries, in the order of their list.
#[derive(Clone)]
pub struct Pattern {
    places: Vec<Pair<usize, usize>>,
    symbolic: SymbolicSparseColMat<usize>,
    order: Argsort<usize>,
}

impl Pattern {
    /// Pattern of a list of entries; entries with equal indices add up. `None` if an index is out of range.
    pub fn of(count: usize, entries: &[Triplet<usize, usize, f64>]) -> Option<Pattern> {
        let places: Vec<_> = entries.iter().map(|entry| Pair::new(entry.row, entry.col)).collect();
        let (symbolic, order) = SymbolicSparseColMat::try_new_from_indices(count, count, &places).ok()?;
        Some(Pattern { places, symbolic, order })
    }

    /// Whether a list of entries has these indices, in this order.
    pub fn fits(&self, count: usize, entries: &[Triplet<usize, usize, f64>]) -> bool {
        self.symbolic.nrows() == count
            && self.places.len() == entries.len()
            && entries.iter().zip(&self.places).all(|(entry, place)| (entry.row, entry.col) == (place.row, place.col))
    }

    /// The symbolic pattern, for the order of an elimination.
    pub fn symbolic(&self) -> &SymbolicSparseColMat<usize> {
        &self.symbolic
    }

    /// Matrix with the values of a list that [fits](Pattern::fits); `None` if memory runs out.
    pub fn matrix(&self, entries: &[Triplet<usize, usize, f64>]) -> Option<SparseColMat<usize, f64>> {
        let values: Vec<f64> = entries.iter().map(|entry| entry.val).collect();
        SparseColMat::new_from_argsort(self.symbolic.clone(), &self.order, &values).ok()
    }
}
