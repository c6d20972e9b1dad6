//! One step of block elimination: N unknowns leave, M neighbours stay.
//!
//! Everything in the ladder is such a step: a node between two elements, the rotations of a pinned member, the tip, a
//! rung. With K the block's stiffness, C its coupling to the neighbours and g its gradient, the block moves by
//! x = -K^-1 (g + C neighbours), and leaves -C^T K^-1 C and -C^T K^-1 g on its neighbours. With K = L D L^T both need
//! only W = L^-1 C and y = L^-1 g.

use super::ldl::Ldl;

/// The factored stiffness of a block and its coupling to its neighbours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<const N: usize, const M: usize> {
    factor: Ldl<N>,
    /// W = L^-1 C.
    with: [[f64; M]; N],
}

impl<const N: usize, const M: usize> Block<N, M> {
    /// A block that is not factored yet.
    pub(super) fn empty() -> Block<N, M> {
        Block { factor: Ldl::empty(), with: [[0.0; M]; N] }
    }

    /// Factorises; rows of `coupling` are the block's unknowns, columns the neighbours'.
    #[inline(always)]
    pub(super) fn factorise(&mut self, stiffness: &[[f64; N]; N], coupling: &[[f64; M]; N]) {
        self.factor.factorise(stiffness);
        self.with = *coupling;
        self.factor.forward(&mut self.with);
    }

    /// Whether the block is positive definite.
    pub(super) fn positive(&self) -> bool {
        self.factor.positive
    }

    /// Whether each pivot is larger than a limit of its own.
    pub(super) fn pivots_exceed(&self, limits: &[f64; N]) -> bool {
        self.factor.pivots_exceed(limits)
    }

    /// Logarithm of the block's determinant.
    pub(super) fn log_determinant(&self) -> f64 {
        self.factor.log_determinant()
    }

    /// Takes C^T K^-1 C off the neighbours' stiffness, in its upper triangle.
    #[inline(always)]
    pub(super) fn reduce_stiffness(&self, neighbours: &mut [[f64; M]; M]) {
        for (row, target) in neighbours.iter_mut().enumerate() {
            let weights: [f64; N] = self.factor.divided(&std::array::from_fn(|i| self.with[i][row]));
            for (weight, with) in weights.iter().zip(&self.with) {
                // From an even column: pairs of numbers go through one instruction.
                for column in (row & !1)..M {
                    target[column] -= weight * with[column];
                }
            }
        }
    }

    /// y = L^-1 g.
    pub(super) fn forward(&self, gradient: &[f64; N]) -> [f64; N] {
        self.factor.forward_vector(gradient)
    }

    /// Takes C^T K^-1 g, from y = L^-1 g, off the neighbours' gradient.
    pub(super) fn reduce_gradient(&self, y: &[f64; N], neighbours: &mut [f64; M]) {
        for (y, with) in self.factor.divided(y).iter().zip(&self.with) {
            for (target, with) in neighbours.iter_mut().zip(with) {
                *target -= y * with;
            }
        }
    }

    /// g K^-1 g, from y = L^-1 g.
    pub(super) fn work(&self, y: &[f64; N]) -> f64 {
        y.iter().zip(&self.factor.divided(y)).map(|(a, b)| a * b).sum()
    }

    /// The block's motion -K^-1 (g + C neighbours), from y = L^-1 g.
    pub(super) fn motion(&self, y: &[f64; N], neighbours: &[f64; M]) -> [f64; N] {
        let mut sum = *y;
        for (sum, with) in sum.iter_mut().zip(&self.with) {
            for (with, neighbour) in with.iter().zip(neighbours) {
                *sum += with * neighbour;
            }
        }
        self.factor.backward(&self.factor.divided(&sum)).map(|x| -x)
    }
}
