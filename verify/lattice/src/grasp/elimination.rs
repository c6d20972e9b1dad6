//! Block elimination of a finger's bodies, three unknowns each, in a fixed order. A contact adds no block between two bodies of the finger.

use nalgebra::Matrix3;
use std::collections::{BTreeMap, BTreeSet};

/// The elimination step of one body (the pivot).
#[derive(Debug, Clone)]
struct Pivot {
    body: usize,
    /// Bodies that share blocks with the pivot and are eliminated later.
    later: Vec<CoupledBody>,
    /// Indices of the blocks that this step changes: one for each pair (row, column) of bodies in `later`, row by row.
    changed: Vec<usize>,
}

/// A body that shares blocks with a pivot, and indices of these blocks.
#[derive(Debug, Clone, Copy)]
struct CoupledBody {
    body: usize,
    /// Index of the coupling block in the pivot's row.
    right: usize,
    /// Index of the coupling block in the pivot's column.
    below: usize,
}

/// Elimination order of the free bodies, and indices of the blocks. The diagonal blocks come first, body by body.
#[derive(Debug, Clone)]
pub(super) struct Order {
    pivots: Vec<Pivot>,
    /// For each link between two bodies, the indices of its two blocks: in the row of the first body, and in the row of the second. `None` if an end is
    /// clamped.
    links: Vec<Option<[usize; 2]>>,
    block_count: usize,
}

impl Order {
    /// Elimination order for free bodies and the links between them. In each step, the body with the fewest links to remaining bodies is eliminated.
    pub fn of(body_count: usize, links: &[Option<[usize; 2]>]) -> Order {
        let mut linked = vec![BTreeSet::new(); body_count];
        let mut places: BTreeMap<[usize; 2], usize> = (0..body_count).map(|body| ([body, body], body)).collect();
        let mut place = |row: usize, column: usize| {
            let next = places.len();
            *places.entry([row, column]).or_insert(next)
        };
        let mut of_link = |[a, b]: [usize; 2]| {
            linked[a].insert(b);
            linked[b].insert(a);
            [place(a, b), place(b, a)]
        };
        let links = links.iter().map(|link| link.map(&mut of_link)).collect();
        // Bodies not yet eliminated, sorted by their number of links.
        let mut left: BTreeSet<(usize, usize)> = (0..body_count).map(|body| (linked[body].len(), body)).collect();
        let mut pivots = Vec::with_capacity(body_count);
        while let Some((_, body)) = left.pop_first() {
            let others: Vec<usize> = std::mem::take(&mut linked[body]).into_iter().collect();
            for &other in &others {
                left.remove(&(linked[other].len(), other));
                linked[other].remove(&body);
                linked[other].extend(others.iter().filter(|another| **another != other));
                left.insert((linked[other].len(), other));
            }
            let later =
                |&other: &usize| CoupledBody { body: other, right: place(body, other), below: place(other, body) };
            let later = others.iter().map(later).collect();
            let pairs = others.iter().flat_map(|&row| others.iter().map(move |&column| (row, column)));
            let changed = pairs.map(|(row, column)| place(row, column)).collect();
            pivots.push(Pivot { body, later, changed });
        }
        Order { pivots, links, block_count: places.len() }
    }

    /// Number of free bodies.
    pub fn body_count(&self) -> usize {
        self.pivots.len()
    }

    /// A list of all blocks, set to zero.
    pub fn blocks(&self) -> Vec<Matrix3<f64>> {
        vec![Matrix3::zeros(); self.block_count]
    }

    /// For each link between two bodies, the indices of its two blocks: in the row of the first body, and in the row of the second. `None` if an end is
    /// clamped.
    pub fn links(&self) -> &[Option<[usize; 2]>] {
        &self.links
    }

    /// Factorises the blocks in place, always in the same order. `None` if a pivot block is exactly singular.
    ///
    /// The elimination is stable if the stiffness of the finger with its contacts is positive definite. During a snap the stiffness may be
    /// indefinite. If the stiffness is indefinite, the correction is less accurate, and Newton's method takes further steps or fails.
    pub fn factorise(&self, blocks: &mut [Matrix3<f64>]) -> Option<()> {
        for Pivot { body, later, changed } in &self.pivots {
            let inverse = blocks[*body].try_inverse()?;
            blocks[*body] = inverse;
            for (row, changed) in later.iter().zip(changed.chunks(later.len().max(1))) {
                let factor = blocks[row.below] * inverse;
                blocks[row.below] = factor;
                for (column, place) in later.iter().zip(changed) {
                    let change = factor * blocks[column.right];
                    blocks[*place] -= change;
                }
            }
        }
        Some(())
    }

    /// Solves for `columns` right-hand sides in place, with factorised blocks. `right` has three rows per body, with `columns` values each.
    pub fn solve(&self, blocks: &[Matrix3<f64>], right: &mut [f64], columns: usize) {
        let [mut own, mut left] = [0, 1].map(|_| vec![0.0; 3 * columns]);
        for Pivot { body, later, .. } in &self.pivots {
            own.copy_from_slice(rows_of(right, *body, columns));
            later.iter().for_each(|row| subtract(rows_of(right, row.body, columns), &blocks[row.below], &own, columns));
        }
        for Pivot { body, later, .. } in self.pivots.iter().rev() {
            left.copy_from_slice(rows_of(right, *body, columns));
            for column in later {
                own.copy_from_slice(rows_of(right, column.body, columns));
                subtract(&mut left, &blocks[column.right], &own, columns);
            }
            let solved = rows_of(right, *body, columns);
            solved.fill(0.0);
            subtract(solved, &-blocks[*body], &left, columns);
        }
    }
}

/// The three rows of a body in the right-hand sides.
fn rows_of(right: &mut [f64], body: usize, columns: usize) -> &mut [f64] {
    &mut right[3 * body * columns..3 * (body + 1) * columns]
}

/// Subtracts a block times three rows from the three rows `from`.
fn subtract(from: &mut [f64], block: &Matrix3<f64>, rows: &[f64], columns: usize) {
    for (i, from) in from.chunks_exact_mut(columns).enumerate() {
        for (j, row) in rows.chunks_exact(columns).enumerate() {
            let factor = block[(i, j)];
            from.iter_mut().zip(row).for_each(|(from, x)| *from -= factor * x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Compares the solution with that of dense elimination, for a ring of bodies with additional links and unsymmetric blocks.
    #[test]
    fn blocks_are_eliminated_as_a_dense_matrix_is() {
        const BODIES: usize = 9;
        const COLUMNS: usize = 2;
        let mut links: Vec<Option<[usize; 2]>> = (0..BODIES).map(|body| Some([body, (body + 1) % BODIES])).collect();
        links.extend([Some([0, 4]), None, Some([2, 7])]);
        let order = Order::of(BODIES, &links);
        let mut blocks = order.blocks();
        let mut dense = DMatrix::zeros(3 * BODIES, 3 * BODIES);
        let places = links.iter().zip(order.links()).filter_map(|(link, place)| Some(((*link)?, (*place)?)));
        let off_diagonal = places.flat_map(|([a, b], [ab, ba])| [(a, b, ab), (b, a, ba)]);
        for (row, column, place) in (0..BODIES).map(|body| (body, body, body)).chain(off_diagonal) {
            let weight = if row == column { 12.0 } else { 1.0 };
            let element = |i: usize, j: usize| (1.0 + place as f64 + 3.7 * i as f64 + 1.3 * j as f64).sin();
            blocks[place] = Matrix3::from_fn(|i, j| element(i, j) + if i == j { weight } else { 0.0 });
            dense.view_mut((3 * row, 3 * column), (3, 3)).copy_from(&blocks[place]);
        }
        let mut right: Vec<f64> = (0..3 * BODIES * COLUMNS).map(|i| (i as f64).cos()).collect();
        let expected = dense.lu().solve(&DMatrix::from_row_slice(3 * BODIES, COLUMNS, &right)).expect("not singular");
        order.factorise(&mut blocks).expect("not singular");
        order.solve(&blocks, &mut right, COLUMNS);
        let off = (DMatrix::from_row_slice(3 * BODIES, COLUMNS, &right) - expected).amax();
        assert!(off < 1e-13, "{off}");
    }
}
