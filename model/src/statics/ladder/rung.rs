//! The back and front node of one rib: a block of six unknowns.

use super::block::Block;
use super::chain::{Ends, EndsMatrix};
use crate::Vector;

/// How an undeformable rib joins the front node to the back node.
///
/// The rung's unknowns are then its generalised coordinates q: back x, y, rotation; rotation of the rib; rotation of
/// the front node (the last two are not there if all turn together). Coordinates that are not needed stay in place with
/// unit stiffness. The nodes move by u = T q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RigidRib {
    /// From the back to the front node, in its current direction, mm.
    pub lever: Vector,
    /// Whether rib and both nodes turn together.
    pub together: bool,
    /// Pull of the elements on the front node, N, where it counts: as the lever turns, its end moves on a circle.
    pub front_pull: Vector,
}

impl RigidRib {
    fn turn(&self) -> usize {
        if self.together { 2 } else { 3 }
    }

    /// u = T q.
    fn nodal(&self, q: &Ends) -> Ends {
        let turn = q[self.turn()];
        let front = if self.together { q[2] } else { q[4] };
        [q[0], q[1], q[2], q[0] - self.lever.y * turn, q[1] + self.lever.x * turn, front]
    }

    /// T^T f.
    fn generalised(&self, f: &Ends) -> Ends {
        let moment = self.lever.x * f[4] - self.lever.y * f[3];
        match self.together {
            true => [f[0] + f[3], f[1] + f[4], f[2] + moment + f[5], 0.0, 0.0, 0.0],
            false => [f[0] + f[3], f[1] + f[4], f[2], moment, f[5], 0.0],
        }
    }

    /// T^T K T with what the turning lever adds.
    fn generalised_stiffness(&self, stiffness: &EndsMatrix) -> EndsMatrix {
        let full: EndsMatrix = std::array::from_fn(|i| std::array::from_fn(|j| stiffness[i.min(j)][i.max(j)]));
        // T^T times the symmetric K is the transpose of K T; so T^T each row, and again each row of the transpose.
        let half = transposed(&full.map(|row| self.generalised(&row)));
        let mut whole = half.map(|row| self.generalised(&row));
        let turn = self.turn();
        whole[turn][turn] -= self.front_pull.dot(&self.lever);
        for unused in if self.together { 3..6 } else { 5..6 } {
            whole[unused][unused] = 1.0;
        }
        whole
    }
}

fn transposed(matrix: &EndsMatrix) -> EndsMatrix {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]))
}

/// x, y, rotation of the back node, then of the front node, eliminated towards the rung below.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rung {
    block: Block<6, 6>,
    rib: Option<RigidRib>,
}

impl Rung {
    /// A rung to be overwritten.
    pub(super) fn empty() -> Rung {
        Rung { block: Block::empty(), rib: None }
    }

    /// Eliminates the rung with this stiffness; `back` and `front` are the plate members from the rung below (their
    /// first ends) to this one.
    pub(super) fn eliminate(
        &mut self,
        rib: Option<RigidRib>,
        stiffness: &EndsMatrix,
        back: &EndsMatrix,
        front: &EndsMatrix,
    ) {
        let mut coupling = [[0.0; 6]; 6];
        for i in 0..3 {
            for j in 0..3 {
                coupling[i][j] = back[j][3 + i];
                coupling[3 + i][3 + j] = front[j][3 + i];
            }
        }
        self.rib = rib;
        if let Some(rib) = rib {
            coupling = transposed(&transposed(&coupling).map(|column| rib.generalised(&column)));
            self.block.factorise(&rib.generalised_stiffness(stiffness), &coupling);
        } else {
            self.block.factorise(stiffness, &coupling);
        }
    }

    /// Whether the block is positive definite.
    pub(super) fn positive(&self) -> bool {
        self.block.positive()
    }

    /// Whether each pivot is larger than a limit of its own; `false` with an undeformable rib, whose unknowns are others.
    pub(super) fn pivots_exceed(&self, limits: &Ends) -> bool {
        self.rib.is_none() && self.block.pivots_exceed(limits)
    }

    /// Logarithm of the block's determinant.
    pub(super) fn log_determinant(&self) -> f64 {
        self.block.log_determinant()
    }

    /// Takes what the eliminated rung does off the stiffness of the rung below.
    pub(super) fn reduce_stiffness(&self, below: &mut EndsMatrix) {
        self.block.reduce_stiffness(below);
    }

    /// y = L^-1 g of a gradient on the rung's nodes, g in generalised coordinates.
    pub(super) fn forward(&self, gradient: &Ends) -> Ends {
        match self.rib {
            None => self.block.forward(gradient),
            Some(rib) => self.block.forward(&rib.generalised(gradient)),
        }
    }

    /// Work of a residual on the correction of the rung, by its y, N mm.
    pub(super) fn work(&self, y: &Ends) -> f64 {
        self.block.work(y)
    }

    /// Takes a gradient, by its y, off that of the rung below.
    pub(super) fn reduce_gradient(&self, y: &Ends, below: &mut Ends) {
        self.block.reduce_gradient(y, below);
    }

    /// Motion of the two nodes for a gradient, by its y, and a motion of the rung below; and the rotation of an
    /// undeformable rib that is hinged.
    pub(super) fn motion(&self, y: &Ends, below: &Ends) -> (Ends, Option<f64>) {
        let q = self.block.motion(y, below);
        match self.rib {
            None => (q, None),
            Some(rib) => (rib.nodal(&q), (!rib.together).then_some(q[3])),
        }
    }
}
