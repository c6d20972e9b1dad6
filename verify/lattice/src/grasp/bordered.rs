//! Linear equations in bordered form: one block of unknowns per finger, and a border with the unknowns that all fingers share (the object's pose).

use super::elimination::Order;
use nalgebra::{DMatrix, DVectorViewMut, Matrix3};

/// Equations of one finger's bodies.
struct Inner<'o> {
    order: &'o Order,
    /// Index of the finger's first unknown.
    first: usize,
    blocks: Vec<Matrix3<f64>>,
    /// Derivatives of the finger's equations with respect to the border's unknowns: row of the finger, column of the border, value.
    by_border: Vec<(usize, usize, f64)>,
    /// Derivatives of the border's equations with respect to the finger's unknowns: row of the border, column of the finger, value.
    of_border: Vec<(usize, usize, f64)>,
}

impl Inner<'_> {
    fn unknown_count(&self) -> usize {
        3 * self.order.body_count()
    }

    /// Returns A⁻¹ r in the first column and A⁻¹ B in the other columns, with one row per unknown of the finger. A is the finger's matrix, r a
    /// right-hand side, and B the derivatives with respect to the border's unknowns.
    fn solved(&mut self, right: &[f64], border_count: usize) -> Option<Vec<f64>> {
        let columns = 1 + border_count;
        let mut solved = vec![0.0; self.unknown_count() * columns];
        right[self.first..].iter().zip(solved.chunks_exact_mut(columns)).for_each(|(right, row)| row[0] = *right);
        for &(unknown, column, derivative) in &self.by_border {
            solved[unknown * columns + 1 + column] += derivative;
        }
        self.order.factorise(&mut self.blocks)?;
        self.order.solve(&self.blocks, &mut solved, columns);
        Some(solved)
    }
}

/// Matrix of the equations. The unknowns of the fingers' bodies come first, finger by finger; the unknowns of the border follow.
pub(super) struct Bordered<'o> {
    fingers: Vec<Inner<'o>>,
    border: DMatrix<f64>,
    /// Index of the border's first unknown.
    first: usize,
}

impl<'o> Bordered<'o> {
    /// A matrix of zeros.
    pub fn new(orders: impl Iterator<Item = &'o Order>, border_count: usize) -> Bordered<'o> {
        let mut first = 0;
        let of_finger = |order: &'o Order| {
            let finger = Inner { order, first, blocks: order.blocks(), by_border: Vec::new(), of_border: Vec::new() };
            first += finger.unknown_count();
            finger
        };
        let fingers = orders.map(of_finger).collect();
        Bordered { fingers, border: DMatrix::zeros(border_count, border_count), first }
    }

    /// Elimination order and blocks of a finger.
    pub fn blocks(&mut self, finger: usize) -> (&'o Order, &mut [Matrix3<f64>]) {
        let Inner { order, blocks, .. } = &mut self.fingers[finger];
        (order, blocks)
    }

    /// Adds a derivative to one element. Panics if row and column belong to two different bodies; a derivative between two bodies belongs in the
    /// [`blocks`](Self::blocks).
    pub fn add(&mut self, row: usize, column: usize, derivative: f64) {
        let first = self.first;
        if row.min(column) >= first {
            self.border[(row - first, column - first)] += derivative;
            return;
        }
        let inner = row.min(column);
        let Some(finger) = self.fingers.iter_mut().rev().find(|finger| finger.first <= inner) else { return };
        if column >= first {
            finger.by_border.push((row - finger.first, column - first, derivative));
        } else if row >= first {
            finger.of_border.push((row - first, column - finger.first, derivative));
        } else {
            let [row, column] = [row - finger.first, column - finger.first];
            assert_eq!(row / 3, column / 3, "two unknowns of a body");
            finger.blocks[row / 3][(row % 3, column % 3)] += derivative;
        }
    }

    /// Solves for `right` in place. `None` if a pivot block of a finger, or the reduced matrix of the border, is singular.
    pub fn solve(mut self, right: &mut [f64]) -> Option<()> {
        let count = self.border.nrows();
        let columns = 1 + count;
        let (inner, on_border) = right.split_at_mut(self.first);
        let mut all_solved = Vec::with_capacity(self.fingers.len());
        for finger in &mut self.fingers {
            let solved = finger.solved(inner, count)?;
            for &(row, unknown, derivative) in &finger.of_border {
                let solved = &solved[unknown * columns..][..columns];
                on_border[row] -= derivative * solved[0];
                (0..count).for_each(|column| self.border[(row, column)] -= derivative * solved[1 + column]);
            }
            all_solved.push(solved);
        }
        let is_solved = self.border.lu().solve_mut(&mut DVectorViewMut::from_slice(on_border, count));
        for (unknown, solved) in inner.iter_mut().zip(all_solved.iter().flat_map(|solved| solved.chunks_exact(columns)))
        {
            *unknown = solved[0] - solved[1..].iter().zip(&*on_border).map(|(by, border)| by * border).sum::<f64>();
        }
        (is_solved && right.iter().all(|x| x.is_finite())).then_some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    /// Compares the solution with that of dense elimination, for two chains of bodies of different length. The chains share a border, and the matrix
    /// is not symmetric.
    #[test]
    fn a_bordered_matrix_is_solved_as_a_dense_one_is() {
        const BODIES: [usize; 2] = [4, 3];
        const BORDER: usize = 5;
        let chain = |bodies: usize| -> Vec<_> { (1..bodies).map(|body| Some([body - 1, body])).collect() };
        let orders = BODIES.map(|bodies| Order::of(bodies, &chain(bodies)));
        let first = 3 * BODIES.iter().sum::<usize>();
        let count = first + BORDER;
        let value = |row: usize, column: usize| {
            (1.0 + 1.7 * row as f64 + 0.3 * column as f64).sin() + if row == column { 9.0 } else { 0.0 }
        };
        let (mut matrix, mut dense) = (Bordered::new(orders.iter(), BORDER), DMatrix::zeros(count, count));
        let mut first_body = 0;
        for (finger, bodies) in BODIES.into_iter().enumerate() {
            let own = 3 * first_body..3 * (first_body + bodies);
            for (row, column) in own.clone().flat_map(|row| (0..count).map(move |column| (row, column))) {
                let is_link = own.contains(&column) && (row / 3).abs_diff(column / 3) == 1;
                let value = value(row, column);
                if is_link {
                    let link = row.min(column) / 3 - first_body;
                    let (order, blocks) = matrix.blocks(finger);
                    let places = order.links()[link].expect("a link between free bodies");
                    blocks[places[usize::from(row > column)]][(row % 3, column % 3)] += value;
                } else if row / 3 == column / 3 || column >= first {
                    matrix.add(row, column, value);
                } else {
                    continue;
                }
                dense[(row, column)] += value;
            }
            first_body += bodies;
        }
        for (row, column) in (first..count).flat_map(|row| (0..count).map(move |column| (row, column))) {
            matrix.add(row, column, value(row, column));
            dense[(row, column)] += value(row, column);
        }
        let mut right: Vec<f64> = (0..count).map(|i| (i as f64).cos()).collect();
        let expected = dense.lu().solve(&DVector::from_vec(right.clone())).expect("not singular");
        matrix.solve(&mut right).expect("not singular");
        let off = (DVector::from_vec(right) - expected).amax();
        assert!(off < 1e-12, "{off}");
    }
}
