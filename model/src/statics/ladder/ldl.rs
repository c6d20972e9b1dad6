//! L D L^T of a small symmetric matrix, of a size known when compiling: no pivoting, no heap.
//!
//! Matrices are plain arrays of rows: with sizes and indices known when compiling, nothing is checked or looped over
//! when running.

/// Unit lower triangle and diagonal of K = L D L^T.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ldl<const N: usize> {
    /// Rows of L^T; what stands on and below the diagonal is not read.
    upper: [[f64; N]; N],
    inverse_diagonal: [f64; N],
    /// Whether all pivots are positive: K is positive definite.
    pub positive: bool,
}

impl<const N: usize> Ldl<N> {
    /// No factor yet.
    pub(super) fn empty() -> Ldl<N> {
        Ldl { upper: [[0.0; N]; N], inverse_diagonal: [0.0; N], positive: false }
    }

    /// Factorises; only the upper triangle is read. In place, since moving a factor costs as much as making it.
    #[inline(always)]
    pub(super) fn factorise(&mut self, matrix: &[[f64; N]; N]) {
        self.upper = *matrix;
        self.positive = true;
        for j in 0..N {
            let row = self.upper[j];
            // A pivot that is not a number compares as false.
            self.positive &= row[j] > 0.0;
            let inverse = 1.0 / row[j];
            self.inverse_diagonal[j] = inverse;
            for i in j + 1..N {
                let factor = row[i] * inverse;
                self.upper[j][i] = factor;
                for k in i..N {
                    self.upper[i][k] -= factor * row[k];
                }
            }
        }
    }

    /// Overwrites each of M columns with L^-1 times it.
    #[inline(always)]
    pub(super) fn forward<const M: usize>(&self, columns: &mut [[f64; M]; N]) {
        for j in 0..N {
            let known = columns[j];
            for i in j + 1..N {
                for (x, known) in columns[i].iter_mut().zip(&known) {
                    *x -= self.upper[j][i] * known;
                }
            }
        }
    }

    /// Whether each pivot is larger than a limit of its own.
    pub(super) fn pivots_exceed(&self, limits: &[f64; N]) -> bool {
        self.inverse_diagonal.iter().zip(limits).all(|(inverse, limit)| inverse * limit < 1.0)
    }

    /// Logarithm of the determinant; not a number if a pivot is negative.
    pub(super) fn log_determinant(&self) -> f64 {
        -self.inverse_diagonal.iter().map(|inverse| inverse.ln()).sum::<f64>()
    }

    /// L^-1 times a vector.
    pub(super) fn forward_vector(&self, right: &[f64; N]) -> [f64; N] {
        let mut x = *right;
        for j in 0..N {
            for i in j + 1..N {
                x[i] -= self.upper[j][i] * x[j];
            }
        }
        x
    }

    /// L^-T times a vector.
    pub(super) fn backward(&self, right: &[f64; N]) -> [f64; N] {
        let mut x = *right;
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] -= self.upper[i][k] * x[k];
            }
        }
        x
    }

    /// D^-1 times a vector.
    pub(super) fn divided(&self, right: &[f64; N]) -> [f64; N] {
        let mut x = *right;
        for (x, inverse) in x.iter_mut().zip(&self.inverse_diagonal) {
            *x *= inverse;
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    fn rows(k: &Matrix3<f64>) -> [[f64; 3]; 3] {
        k.transpose().data.0
    }

    fn solved(ldl: &Ldl<3>, right: Vector3<f64>) -> Vector3<f64> {
        ldl.backward(&ldl.divided(&ldl.forward_vector(&right.into()))).into()
    }

    #[test]
    fn solves_and_sees_the_sign() {
        let k = Matrix3::new(4.0, 1.0, -2.0, 1.0, 5.0, 0.5, -2.0, 0.5, 6.0);
        let x = Vector3::new(1.0, -2.0, 3.0);
        let mut ldl = Ldl::empty();
        ldl.factorise(&rows(&k));
        assert!(ldl.positive);
        assert!((solved(&ldl, k * x) - x).norm() < 1e-14);
        let mut columns = [[1.0, 7.0], [-2.0, 8.0], [3.0, 9.0]];
        ldl.forward(&mut columns);
        assert_eq!(columns.map(|row| row[0]), ldl.forward_vector(&x.into()));
        let indefinite = k - Matrix3::identity() * 4.5;
        ldl.factorise(&rows(&indefinite));
        assert!(!ldl.positive);
        assert!((solved(&ldl, indefinite * x) - x).norm() < 1e-13);
        // The second row is the first but for 1e-3 of it.
        ldl.factorise(&rows(&Matrix3::new(1.0, 1.0, 0.0, 1.0, 1.001, 0.0, 0.0, 0.0, 1.0)));
        assert!(ldl.pivots_exceed(&[0.99, 0.99e-3, 0.99]) && !ldl.pivots_exceed(&[0.99, 1.01e-3, 0.99]));
        ldl.factorise(&rows(&(k * f64::NAN)));
        assert!(!ldl.positive);
    }
}
