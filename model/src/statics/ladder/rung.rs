//! A rung: the back and front node of one rib, as a block of six unknowns.

use super::block::Block;
use super::ends::{Ends, EndsMatrix};
use crate::number::Number;
use nalgebra::Vector2;

/// Kinematics of an undeformable rib between the back node and the front node.
///
/// The rung's unknowns become generalised coordinates q: x, y and rotation of the back node, rotation of the rib, rotation of the front node. If rib
/// and nodes rotate together, the last two coordinates are absent. Unused coordinates keep unit stiffness. The motion of the nodes is u = T q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RigidRib<R> {
    /// Vectors in their current directions, mm, that lead from the back to the front node: back bracket, rib, front bracket. Each vector has one
    /// rotation. If rib and nodes rotate together, the first vector is the sum of all three vectors.
    pub levers: [Vector2<R>; 3],
    /// Whether the rib and both of its nodes rotate by the same angle.
    pub together: bool,
    /// Gradient of the energy of elements and loads with respect to the position of the front node, N; zero with linear kinematics. This gradient
    /// adds geometric stiffness when the levers rotate.
    pub front_pull: Vector2<R>,
}

impl<R: Number> RigidRib<R> {
    /// Motion of the nodes u = T q for generalised coordinates q.
    #[inline(always)]
    fn nodal(&self, q: &Ends<R>) -> Ends<R> {
        let [back, rib, front] = &self.levers;
        let (mut x, mut y) = (q[0] - back.y * q[2], q[1] + back.x * q[2]);
        if self.together {
            return [q[0], q[1], q[2], x, y, q[2]];
        }
        x -= rib.y * q[3] + front.y * q[4];
        y += rib.x * q[3] + front.x * q[4];
        [q[0], q[1], q[2], x, y, q[4]]
    }

    /// Generalised forces T^T f for nodal forces f.
    #[inline(always)]
    fn generalised(&self, f: &Ends<R>) -> Ends<R> {
        let none = f[0].zero();
        let moment = |lever: &Vector2<R>| lever.x * f[4] - lever.y * f[3];
        let [back, rib, front] = &self.levers;
        let back = f[2] + moment(back);
        match self.together {
            true => [f[0] + f[3], f[1] + f[4], back + f[5], none, none, none],
            false => [f[0] + f[3], f[1] + f[4], back, moment(rib), f[5] + moment(front), none],
        }
    }

    /// Generalised stiffness T^T K T plus the geometric stiffness of the rotating levers.
    #[inline(always)]
    fn generalised_stiffness(&self, stiffness: &EndsMatrix<R>) -> EndsMatrix<R> {
        let mut full = *stiffness;
        for i in 0..6 {
            for j in 0..i {
                full[i][j] = stiffness[j][i];
            }
        }
        // K is symmetric. T^T K T is computed by applying T^T to each row of the symmetric K, transposing, and applying T^T to each row again.
        let half = transposed(&full.map(|row| self.generalised(&row)));
        let mut whole = half.map(|row| self.generalised(&row));
        let turns = if self.together { 2..3 } else { 2..5 };
        for (turn, lever) in turns.clone().zip(&self.levers) {
            whole[turn][turn] -= self.front_pull.x * lever.x + self.front_pull.y * lever.y;
        }
        for unused in turns.end..6 {
            whole[unused][unused] = self.front_pull.x.constant(1.0);
        }
        whole
    }
}

#[inline(always)]
fn transposed<R: Number>(matrix: &EndsMatrix<R>) -> EndsMatrix<R> {
    let mut transposed = *matrix;
    for i in 0..6 {
        for j in 0..6 {
            transposed[i][j] = matrix[j][i];
        }
    }
    transposed
}

/// A node of a rung that coincides with a node of the rung below, because the ribs of both rungs share a junction.
///
/// The three unknowns of the tied node keep unit stiffness without coupling, so their forward substitution y equals their gradient. Stiffness,
/// gradient and couplings of the tied node are added to those of the node below.
#[derive(Debug, Clone, Copy)]
struct TiedNode<R> {
    /// Index of the node's first unknown: 0 for the back node, 3 for the front node.
    row: usize,
    /// The node's original stiffness; only the upper triangle is valid.
    stiffness: [[R; 3]; 3],
}

impl<R: Number> TiedNode<R> {
    /// Moves the stiffness between the tied node and the other node of the rung to `coupling`. Stores the tied node's own stiffness, and replaces
    /// this stiffness by unit stiffness. The rows of `coupling` are the unknowns of this rung, and its columns are the unknowns of the rung below.
    #[inline(always)]
    fn release(&mut self, stiffness: &mut EndsMatrix<R>, coupling: &mut EndsMatrix<R>) {
        let (row, other, zero) = (self.row, 3 - self.row, stiffness[0][0].zero());
        for i in 0..3 {
            for j in 0..3 {
                let (of_other, of_tied) = (other + i, row + j);
                coupling[of_other][of_tied] += stiffness[of_other.min(of_tied)][of_other.max(of_tied)];
                (stiffness[of_other][of_tied], stiffness[of_tied][of_other]) = (zero, zero);
                self.stiffness[i][j] = stiffness[row + i][row + j];
                stiffness[row + i][row + j] = if i == j { zero.constant(1.0) } else { zero };
            }
        }
    }
}

/// A rung: the back and front node of one rib, with the unknowns x, y and rotation of the back node, then of the front node. Elimination of a rung
/// adds terms to the stiffness and gradient of the rung below.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rung<R: Number> {
    pub(super) block: Block<R, 6, 6>,
    rib: Option<RigidRib<R>>,
    tied: Option<TiedNode<R>>,
}

impl<R: Number> Rung<R> {
    /// A rung before its elimination, in the number type of `like`. `tied` is the index of the first unknown of a node that is tied to the rung below.
    pub(super) fn empty(like: R, tied: Option<usize>) -> Rung<R> {
        let tied = tied.map(|row| TiedNode { row, stiffness: [[like.zero(); 3]; 3] });
        Rung { block: Block::empty(like), rib: None, tied }
    }

    /// Index of the first unknown (0 back, 3 front) of a node that is tied to the rung below; `None` if no node is tied.
    #[inline(always)]
    pub(super) fn tied_row(&self) -> Option<usize> {
        self.tied.as_ref().map(|tied| tied.row)
    }

    /// Eliminates the rung. `back` and `front` are the stiffnesses of the plate members between this rung and the rung below.
    #[inline(always)]
    pub(super) fn eliminate(
        &mut self,
        rib: Option<RigidRib<R>>,
        stiffness: &EndsMatrix<R>,
        back: &EndsMatrix<R>,
        front: &EndsMatrix<R>,
    ) {
        let mut coupling = [[stiffness[0][0].zero(); 6]; 6];
        for i in 0..3 {
            for j in 0..3 {
                coupling[i][j] = back[j][3 + i];
                coupling[3 + i][3 + j] = front[j][3 + i];
            }
        }
        self.rib = rib;
        if let Some(tied) = &mut self.tied {
            let mut released = *stiffness;
            tied.release(&mut released, &mut coupling);
            self.block.factorise(&released, &coupling);
        } else if let Some(rib) = rib {
            coupling = transposed(&transposed(&coupling).map(|column| rib.generalised(&column)));
            self.block.factorise(&rib.generalised_stiffness(stiffness), &coupling);
        } else {
            self.block.factorise(stiffness, &coupling);
        }
    }

    /// Lanes in which each pivot exceeds its limit. `None` for an undeformable rib, because the unknowns are then generalised coordinates, to which
    /// the limits do not apply.
    #[inline(always)]
    pub(super) fn pivots_exceed(&self, limits: &Ends<R>) -> Option<R::Mask> {
        self.rib.is_none().then(|| self.block.factor.pivots_exceed(limits))
    }

    /// Subtracts the contribution of the eliminated rung from the stiffness of the rung below.
    #[inline(always)]
    pub(super) fn reduce_stiffness(&self, below: &mut EndsMatrix<R>) {
        self.block.reduce_stiffness(below);
        if let Some(tied) = &self.tied {
            for i in 0..3 {
                for j in i..3 {
                    below[tied.row + i][tied.row + j] += tied.stiffness[i][j];
                }
            }
        }
    }

    /// Forward substitution y = L^-1 g for a `gradient` with respect to the motions of the rung's nodes. With an undeformable rib, g is this gradient
    /// in generalised coordinates.
    #[inline(always)]
    pub(super) fn forward(&self, gradient: &Ends<R>) -> Ends<R> {
        match self.rib {
            None => self.block.forward(gradient),
            Some(rib) => self.block.forward(&rib.generalised(gradient)),
        }
    }

    /// Work of the residual g on the correction of the rung, N mm, given y = L^-1 g.
    #[inline(always)]
    pub(super) fn work(&self, y: &Ends<R>) -> R {
        let mut y = *y;
        if let Some(row) = self.tied_row() {
            let zero = y[0].zero();
            y[row..row + 3].fill(zero);
        }
        self.block.work(&y)
    }

    /// Subtracts the contribution of the eliminated rung from the gradient of the rung below, given y = L^-1 g of the rung's gradient g.
    #[inline(always)]
    pub(super) fn reduce_gradient(&self, y: &Ends<R>, below: &mut Ends<R>) {
        self.block.reduce_gradient(y, below);
        if let Some(row) = self.tied_row() {
            for i in row..row + 3 {
                below[i] += y[i];
            }
        }
    }

    /// Motion of both nodes, given y = L^-1 g and the motion of the rung below. Also returns the rotation of an undeformable rib with hinges, rad.
    #[inline(always)]
    pub(super) fn motion(&self, y: &Ends<R>, below: &Ends<R>) -> (Ends<R>, Option<R>) {
        let mut q = self.block.motion(y, below);
        if let Some(row) = self.tied_row() {
            q[row..row + 3].copy_from_slice(&below[row..row + 3]);
        }
        match self.rib {
            None => (q, None),
            Some(rib) => (rib.nodal(&q), (!rib.together).then_some(q[3])),
        }
    }
}
