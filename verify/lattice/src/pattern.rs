//! Sparsity pattern of a matrix. The entries of a pattern are sorted once, for all matrices with entries at the same indices.

use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat, Triplet};

/// Indices (row, column) of a square matrix's entries. The indices have the order of the entry list from which matrices are built.
#[derive(Clone)]
pub struct Pattern {
    places: Vec<Pair<usize, usize>>,
    symbolic: SymbolicSparseColMat<usize>,
    order: Argsort<usize>,
}

impl Pattern {
    /// Pattern of a matrix with `count` rows. Entries with equal indices are added. `None` if an index is out of range.
    pub fn of(count: usize, entries: &[Triplet<usize, usize, f64>]) -> Option<Pattern> {
        let places: Vec<_> = entries.iter().map(|entry| Pair::new(entry.row, entry.col)).collect();
        let (symbolic, order) = SymbolicSparseColMat::try_new_from_indices(count, count, &places).ok()?;
        Some(Pattern { places, symbolic, order })
    }

    /// Whether the entries of a list have the indices of this pattern, in the same order.
    pub fn fits(&self, count: usize, entries: &[Triplet<usize, usize, f64>]) -> bool {
        self.symbolic.nrows() == count
            && self.places.len() == entries.len()
            && entries.iter().zip(&self.places).all(|(entry, place)| (entry.row, entry.col) == (place.row, place.col))
    }

    /// The pattern in faer's form, from which an elimination order is computed.
    pub fn symbolic(&self) -> &SymbolicSparseColMat<usize> {
        &self.symbolic
    }

    /// Matrix with the values of a list that [fits](Pattern::fits) this pattern; `None` if memory runs out.
    pub fn matrix(&self, entries: &[Triplet<usize, usize, f64>]) -> Option<SparseColMat<usize, f64>> {
        let values: Vec<f64> = entries.iter().map(|entry| entry.val).collect();
        SparseColMat::new_from_argsort(self.symbolic.clone(), &self.order, &values).ok()
    }
}
