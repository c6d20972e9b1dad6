//! L D L^T of a small symmetric matrix, of a size known when compiling: no pivoting, no heap.

use nalgebra::SMatrix;

/// Unit lower triangle and diagonal of K = L D L^T.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ldl<const N: usize> {
    /// Columns of L; what stands above the diagonal is not read.
    lower: [[f64; N]; N],
    inverse_diagonal: [f64; N],
    /// Whether all pivots are positive: K is positive definite.
    pub positive: bool,
}

impl<const N: usize> Ldl<N> {
    /// Factorises; only the lower triangle is read.
    pub(super) fn of(matrix: &SMatrix<f64, N, N>) -> Ldl<N> {
        // Columns as plain arrays: indices that are known when compiling need no checks.
        let mut lower = matrix.data.0;
        let mut inverse_diagonal = [0.0; N];
        let mut positive = true;
        for j in 0..N {
            let pivot = lower[j][j];
            // A pivot that is not a number compares as false.
            positive &= pivot > 0.0;
            let inverse = 1.0 / pivot;
            inverse_diagonal[j] = inverse;
            let column = lower[j];
            for k in j + 1..N {
                let factor = column[k] * inverse;
                for i in k..N {
                    lower[k][i] -= factor * column[i];
                }
                lower[j][k] = factor;
            }
        }
        Ldl { lower, inverse_diagonal, positive }
    }

    /// K^-1 times each column.
    pub(super) fn solve<const M: usize>(&self, right: &SMatrix<f64, N, M>) -> SMatrix<f64, N, M> {
        let mut solution = *right;
        for x in &mut solution.data.0 {
            for j in 0..N {
                let known = x[j];
                for (x, l) in x[j + 1..].iter_mut().zip(&self.lower[j][j + 1..]) {
                    *x -= l * known;
                }
            }
            for (x, inverse) in x.iter_mut().zip(&self.inverse_diagonal) {
                *x *= inverse;
            }
            for i in (0..N).rev() {
                let below: f64 = x[i + 1..].iter().zip(&self.lower[i][i + 1..]).map(|(x, l)| x * l).sum();
                x[i] -= below;
            }
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn solves_and_sees_the_sign() {
        let k = Matrix3::new(4.0, 1.0, -2.0, 1.0, 5.0, 0.5, -2.0, 0.5, 6.0);
        let x = Vector3::new(1.0, -2.0, 3.0);
        let ldl = Ldl::of(&k);
        assert!(ldl.positive);
        assert!((ldl.solve(&(k * x)) - x).norm() < 1e-14);
        let indefinite = k - Matrix3::identity() * 4.5;
        let ldl = Ldl::of(&indefinite);
        assert!(!ldl.positive);
        assert!((ldl.solve(&(indefinite * x)) - x).norm() < 1e-13);
        assert!(!Ldl::of(&(k * f64::NAN)).positive);
    }
}
