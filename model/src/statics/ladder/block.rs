//! One step of block elimination. An elimination step eliminates N unknowns; M neighbouring unknowns remain.
//!
//! Every elimination step of the ladder uses a [`Block`], whether it eliminates a node, the rotations of a pinned member, the tip or a rung. Let K be
//! the block's stiffness, C the block's coupling to the neighbours, and g the block's gradient. The block moves by x = -K^-1 (g + C n), where n is
//! the motion of the neighbours. The elimination of the block adds -C^T K^-1 C to the stiffness of the neighbours and -C^T K^-1 g to their gradient.
//! With K = L D L^T, the added stiffness and gradient need only W = L^-1 C and y = L^-1 g.

use crate::number::Number;
use finray_numerics::linear::{Ldl, copy_lane};

/// The factored stiffness of a block, and the block's coupling to the neighbours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<R: Number, const N: usize, const M: usize> {
    pub(super) factor: Ldl<R, N>,
    /// W = L^-1 C.
    with: [[R; M]; N],
}

impl<R: Number, const N: usize, const M: usize> Block<R, N, M> {
    /// A block before its factorisation, in the number type of `like`.
    #[inline(always)]
    pub(super) fn empty(like: R) -> Block<R, N, M> {
        Block { factor: Ldl::empty(like), with: [[like.zero(); M]; N] }
    }

    /// Copies one SIMD lane to `one`.
    #[inline(always)]
    pub(super) fn copy_lane(&self, lane: usize, one: &mut Block<f64, N, M>) {
        self.factor.copy_lane(lane, &mut one.factor);
        for i in 0..N {
            copy_lane(&self.with[i], lane, &mut one.with[i]);
        }
    }

    /// Factorises the stiffness. Rows of `coupling` are the block's unknowns; columns are the neighbours' unknowns.
    #[inline(always)]
    pub(super) fn factorise(&mut self, stiffness: &[[R; N]; N], coupling: &[[R; M]; N]) {
        self.with = *coupling;
        self.factor.factorise(stiffness, &mut self.with);
    }

    /// Subtracts C^T K^-1 C from the neighbours' stiffness, of which only the upper triangle is valid.
    #[inline(always)]
    pub(super) fn reduce_stiffness(&self, neighbours: &mut [[R; M]; M]) {
        for row in 0..M {
            let mut weights = [neighbours[0][0]; N];
            for i in 0..N {
                weights[i] = self.with[i][row];
            }
            let weights = self.factor.divided(&weights);
            // For scalars, each row starts at an even column, so that the compiler can process two numbers in one instruction.
            let first = if R::LANES == 1 { row & !1 } else { row };
            for column in first..M {
                let mut sum = neighbours[row][column];
                for i in 0..N {
                    sum -= weights[i] * self.with[i][column];
                }
                neighbours[row][column] = sum;
            }
        }
    }

    /// Forward substitution y = L^-1 g for a gradient g.
    #[inline(always)]
    pub(super) fn forward(&self, gradient: &[R; N]) -> [R; N] {
        self.factor.forward_vector(gradient)
    }

    /// Subtracts C^T K^-1 g from the neighbours' gradient, given y = L^-1 g.
    #[inline(always)]
    pub(super) fn reduce_gradient(&self, y: &[R; N], neighbours: &mut [R; M]) {
        let y = self.factor.divided(y);
        for i in 0..N {
            for k in 0..M {
                neighbours[k] -= y[i] * self.with[i][k];
            }
        }
    }

    /// Quadratic form g^T K^-1 g, given y = L^-1 g.
    #[inline(always)]
    pub(super) fn work(&self, y: &[R; N]) -> R {
        let divided = self.factor.divided(y);
        let mut work = y[0] * divided[0];
        for i in 1..N {
            work += y[i] * divided[i];
        }
        work
    }

    /// The block's motion -K^-1 (g + C neighbours), given y = L^-1 g.
    #[inline(always)]
    pub(super) fn motion(&self, y: &[R; N], neighbours: &[R; M]) -> [R; N] {
        let mut sum = *y;
        for i in 0..N {
            for k in 0..M {
                sum[i] += self.with[i][k] * neighbours[k];
            }
        }
        let mut motion = self.factor.backward(&self.factor.divided(&sum));
        for x in &mut motion {
            *x = -*x;
        }
        motion
    }
}
