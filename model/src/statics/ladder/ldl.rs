//! L D L^T of a small symmetric matrix, of a size known when compiling: no pivoting, no heap.

use nalgebra::SMatrix;

/// Unit lower triangle and diagonal of K = L D L^T.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ldl<const N: usize> {
    lower: SMatrix<f64, N, N>,
    inverse_diagonal: [f64; N],
    /// Whether all pivots are positive: K is positive definite.
    pub positive: bool,
}

impl<const N: usize> Ldl<N> {
    pub(super) fn of(matrix: &SMatrix<f64, N, N>) -> Ldl<N> {
        let mut lower = *matrix;
        let mut inverse_diagonal = [0.0; N];
        let mut positive = true;
        for j in 0..N {
            let pivot = lower[(j, j)];
            // A pivot that is not a number compares as false.
            positive &= pivot > 0.0;
            let inverse = 1.0 / pivot;
            inverse_diagonal[j] = inverse;
            for i in j + 1..N {
                let factor = lower[(i, j)] * inverse;
                for k in j + 1..=i {
                    lower[(i, k)] -= factor * lower[(k, j)];
                }
            }
            for i in j + 1..N {
                lower[(i, j)] *= inverse;
            }
        }
        Ldl { lower, inverse_diagonal, positive }
    }

    /// K^-1 times each column.
    pub(super) fn solve<const M: usize>(&self, right: &SMatrix<f64, N, M>) -> SMatrix<f64, N, M> {
        let mut x = *right;
        for column in 0..M {
            for i in 1..N {
                for j in 0..i {
                    x[(i, column)] -= self.lower[(i, j)] * x[(j, column)];
                }
            }
            for i in 0..N {
                x[(i, column)] *= self.inverse_diagonal[i];
            }
            for i in (0..N).rev() {
                for j in i + 1..N {
                    x[(i, column)] -= self.lower[(j, i)] * x[(j, column)];
                }
            }
        }
        x
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
