//! L D L^T of a small symmetric matrix, of a size known when compiling: no pivoting, no heap.
//!
//! Matrices are plain arrays of rows: with sizes and indices known when compiling, nothing is checked at run time.

use crate::number::Number;

/// Copies one lane.
#[inline(always)]
pub fn copy_lane<R: Number, const N: usize>(numbers: &[R; N], lane: usize, one: &mut [f64; N]) {
    for i in 0..N {
        one[i] = numbers[i].lane(lane);
    }
}

/// Unit lower triangle and diagonal of K = L D L^T.
#[derive(Debug, Clone, Copy)]
pub struct Ldl<R: Number, const N: usize> {
    /// Rows of L^T; what stands on and below the diagonal is not read.
    upper: [[R; N]; N],
    inverse_diagonal: [R; N],
    /// Where all pivots are positive: K is positive definite.
    pub positive: R::Mask,
}

impl<R: Number, const N: usize> Ldl<R, N> {
    /// No factor yet, in numbers like the one given.
    #[inline(always)]
    pub fn empty(like: R) -> Ldl<R, N> {
        Ldl { upper: [[like.zero(); N]; N], inverse_diagonal: [like.zero(); N], positive: like.always() }
    }

    /// Copies one lane.
    #[inline(always)]
    pub fn copy_lane(&self, lane: usize, one: &mut Ldl<f64, N>) {
        one.positive = true;
        for i in 0..N {
            for k in i + 1..N {
                one.upper[i][k] = self.upper[i][k].lane(lane);
            }
            one.inverse_diagonal[i] = self.inverse_diagonal[i].lane(lane);
            one.positive &= one.inverse_diagonal[i] > 0.0;
        }
    }

    /// Factorises; only the upper triangle is read. In place, since moving a factor costs as much as making it.
    #[inline(always)]
    pub fn factorise(&mut self, matrix: &[[R; N]; N]) {
        self.upper = *matrix;
        let zero = matrix[0][0].zero();
        let one = matrix[0][0].constant(1.0);
        self.positive = zero.always();
        for j in 0..N {
            let row = self.upper[j];
            // A pivot that is not a number compares as false.
            self.positive = zero.both(self.positive, row[j].exceeds(zero));
            let inverse = one / row[j];
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
    pub fn forward<const M: usize>(&self, columns: &mut [[R; M]; N]) {
        // Single numbers go through one instruction as neighbours in a row; of lanes, a column fits into the registers.
        if R::LANES == 1 {
            self.forward_from::<M, M>(columns, 0);
        } else {
            for first in 0..M {
                self.forward_from::<M, 1>(columns, first);
            }
        }
    }

    /// The same for some of the columns.
    #[inline(always)]
    fn forward_from<const M: usize, const COUNT: usize>(&self, columns: &mut [[R; M]; N], first: usize) {
        let mut x: [[R; COUNT]; N] = std::array::from_fn(|i| std::array::from_fn(|k| columns[i][first + k]));
        for j in 0..N {
            let known = x[j];
            for i in 0..N {
                if i > j {
                    for k in 0..COUNT {
                        x[i][k] -= self.upper[j][i] * known[k];
                    }
                }
            }
        }
        for i in 0..N {
            for k in 0..COUNT {
                columns[i][first + k] = x[i][k];
            }
        }
    }

    /// Where each pivot is larger than a limit of its own.
    #[inline(always)]
    pub fn pivots_exceed(&self, limits: &[R; N]) -> R::Mask {
        let one = limits[0].constant(1.0);
        let mut exceed = one.always();
        for i in 0..N {
            exceed = one.both(exceed, one.exceeds(self.inverse_diagonal[i] * limits[i]));
        }
        exceed
    }

    /// Logarithm of the determinant; not a number if a pivot is negative.
    pub fn log_determinant(&self) -> R {
        let mut sum = self.inverse_diagonal[0].zero();
        for inverse in &self.inverse_diagonal {
            sum -= inverse.each(f64::ln);
        }
        sum
    }

    /// L^-1 times a vector.
    #[inline(always)]
    pub fn forward_vector(&self, right: &[R; N]) -> [R; N] {
        let mut x = *right;
        for j in 0..N {
            let known = x[j];
            for i in j + 1..N {
                x[i] -= self.upper[j][i] * known;
            }
        }
        x
    }

    /// L^-T times a vector.
    #[inline(always)]
    pub fn backward(&self, right: &[R; N]) -> [R; N] {
        let mut x = *right;
        for i in (0..N).rev() {
            for k in i + 1..N {
                let known = x[k];
                x[i] -= self.upper[i][k] * known;
            }
        }
        x
    }

    /// D^-1 times a vector.
    #[inline(always)]
    pub fn divided(&self, right: &[R; N]) -> [R; N] {
        let mut x = *right;
        for i in 0..N {
            x[i] *= self.inverse_diagonal[i];
        }
        x
    }
}
