//! L D L^T factorisation of a small symmetric matrix of fixed size, without pivoting and without heap memory.
//!
//! Matrices are arrays of rows. Sizes and indices are compile-time constants, so indices need no checks at run time.

use crate::number::Number;

/// Copies the numbers in one SIMD lane to `one`.
#[inline(always)]
pub fn copy_lane<R: Number, const N: usize>(numbers: &[R; N], lane: usize, one: &mut [f64; N]) {
    for i in 0..N {
        one[i] = numbers[i].lane(lane);
    }
}

/// Unit lower triangle L and diagonal D of K = L D L^T.
#[derive(Debug, Clone, Copy)]
pub struct Ldl<R: Number, const N: usize> {
    /// Rows of L^T above the diagonal; entries on and below the diagonal are not valid.
    upper: [[R; N]; N],
    inverse_diagonal: [R; N],
    /// Lanes in which all pivots are positive, so that K is positive definite.
    pub positive: R::Mask,
}

impl<R: Number, const N: usize> Ldl<R, N> {
    /// A value without a factor; `like` only determines the number type.
    #[inline(always)]
    pub fn empty(like: R) -> Ldl<R, N> {
        Ldl { upper: [[like.zero(); N]; N], inverse_diagonal: [like.zero(); N], positive: like.always() }
    }

    /// Copies the factor in one SIMD lane to `one`.
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

    /// Factorises a matrix, of which only the upper triangle is read, and overwrites each of the M columns x with L^-1 x. Works in place, because moving
    /// a factor takes as long as computing it.
    #[inline(always)]
    pub fn factorise<const M: usize>(&mut self, matrix: &[[R; N]; N], columns: &mut [[R; M]; N]) {
        self.upper = *matrix;
        let zero = matrix[0][0].zero();
        let one = matrix[0][0].constant(1.0);
        self.positive = zero.always();
        // The divisions by the pivots wait for each other. Columns that fit into the registers beside the matrix are processed in this time.
        let together = R::LANES == 1 && N * (N + M) <= 24;
        for j in 0..N {
            let row = self.upper[j];
            // A NaN pivot compares as false.
            self.positive = zero.both(self.positive, row[j].exceeds(zero));
            let inverse = one / row[j];
            self.inverse_diagonal[j] = inverse;
            for i in j + 1..N {
                let factor = row[i] * inverse;
                self.upper[j][i] = factor;
                for k in i..N {
                    self.upper[i][k] -= factor * row[k];
                }
                if together {
                    for k in 0..M {
                        let known = columns[j][k];
                        columns[i][k] -= factor * known;
                    }
                }
            }
        }
        if !together {
            self.forward(columns);
        }
    }

    /// Overwrites each of the M columns x with L^-1 x.
    #[inline(always)]
    fn forward<const M: usize>(&self, columns: &mut [[R; M]; N]) {
        // For scalars, all columns are processed together, so that one instruction processes neighbours in a row. For SIMD lanes, the columns are
        // processed one by one, because one column fits into the registers.
        if R::LANES == 1 {
            self.forward_from::<M, M>(columns, 0);
        } else {
            for first in 0..M {
                self.forward_from::<M, 1>(columns, first);
            }
        }
    }

    /// Same as [`forward`](Ldl::forward), for `COUNT` columns starting at index `first`.
    #[inline(always)]
    fn forward_from<const M: usize, const COUNT: usize>(&self, columns: &mut [[R; M]; N], first: usize) {
        // Loops are used here, because the compiler does not generate wide SIMD instructions for closures.
        let mut x = [[columns[0][first].zero(); COUNT]; N];
        for i in 0..N {
            for k in 0..COUNT {
                x[i][k] = columns[i][first + k];
            }
        }
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

    /// Lanes in which each pivot exceeds its limit; valid only in lanes in which all pivots are positive.
    #[inline(always)]
    pub fn pivots_exceed(&self, limits: &[R; N]) -> R::Mask {
        let one = limits[0].constant(1.0);
        let mut exceed = one.always();
        for i in 0..N {
            exceed = one.both(exceed, one.exceeds(self.inverse_diagonal[i] * limits[i]));
        }
        exceed
    }

    /// Natural logarithm of the determinant; NaN if a pivot is negative.
    pub fn log_determinant(&self) -> R {
        let mut sum = self.inverse_diagonal[0].zero();
        for inverse in &self.inverse_diagonal {
            sum -= inverse.each(f64::ln);
        }
        sum
    }

    /// Returns L^-1 x for a vector x.
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

    /// Returns L^-T x for a vector x.
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

    /// Returns D^-1 x for a vector x.
    #[inline(always)]
    pub fn divided(&self, right: &[R; N]) -> [R; N] {
        let mut x = *right;
        for i in 0..N {
            x[i] *= self.inverse_diagonal[i];
        }
        x
    }
}
