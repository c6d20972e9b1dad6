//! The back and front node of one rib: a block of six unknowns.

use super::block::Block;
use super::ends::{Ends, EndsMatrix};
use crate::number::Number;
use nalgebra::Vector2;

/// How an undeformable rib joins the front node to the back node.
///
/// The rung's unknowns are then its generalised coordinates q: back x, y, rotation; rotation of the rib; rotation of the front node (the last two are
/// not there if all turn together). Coordinates that are not needed stay in place with unit stiffness. The nodes move by u = T q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RigidRib<R> {
    /// From the back to the front node in pieces that turn with each of the three rotations, in their current directions, mm:
    /// the back bracket, the rib, the front bracket. If all turn together, the first is the sum.
    pub levers: [Vector2<R>; 3],
    /// Whether rib and both nodes turn together.
    pub together: bool,
    /// Pull of the elements on the front node, N, where it counts: as a lever turns, its end moves on a circle.
    pub front_pull: Vector2<R>,
}

impl<R: Number> RigidRib<R> {
    /// u = T q.
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

    /// T^T f.
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

    /// T^T K T with what the turning levers add.
    #[inline(always)]
    fn generalised_stiffness(&self, stiffness: &EndsMatrix<R>) -> EndsMatrix<R> {
        let full: EndsMatrix<R> = std::array::from_fn(|i| std::array::from_fn(|j| stiffness[i.min(j)][i.max(j)]));
        // T^T times the symmetric K is the transpose of K T; so T^T each row, and again each row of the transpose.
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
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]))
}

/// A node of a rung that is the same point as the rung's below, as their ribs share a junction.
///
/// Its three unknowns stay in place with unit stiffness and without coupling, so that y holds their gradient. What is coupled to them is coupled to the
/// node below, which takes on their stiffness and their gradient.
#[derive(Debug, Clone, Copy)]
struct TiedNode<R> {
    /// Its first unknown: 0 of the back node, 3 of the front node.
    row: usize,
    /// Its own stiffness, in the upper triangle.
    stiffness: [[R; 3]; 3],
}

impl<R: Number> TiedNode<R> {
    /// Moves the node's stiffness to the node below; rows of `coupling` are the rung's unknowns, columns those of the rung below.
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

/// x, y, rotation of the back node, then of the front node, eliminated towards the rung below.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rung<R: Number> {
    block: Block<R, 6, 6>,
    rib: Option<RigidRib<R>>,
    tied: Option<TiedNode<R>>,
}

impl<R: Number> Rung<R> {
    /// A rung to be overwritten, in numbers like the one given; `tied`: the first unknown of the node that is tied to the rung below.
    pub(super) fn empty(like: R, tied: Option<usize>) -> Rung<R> {
        let tied = tied.map(|row| TiedNode { row, stiffness: [[like.zero(); 3]; 3] });
        Rung { block: Block::empty(like), rib: None, tied }
    }

    /// The first unknown (0 back, 3 front) of the node that is tied to the rung below, if one is.
    #[inline(always)]
    pub(super) fn tied_row(&self) -> Option<usize> {
        self.tied.as_ref().map(|tied| tied.row)
    }

    /// Eliminates the rung with this stiffness; `back` and `front` are the members from the rung below.
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

    /// Where the block is positive definite.
    #[inline(always)]
    pub(super) fn positive(&self) -> R::Mask {
        self.block.positive()
    }

    /// Where each pivot is larger than a limit of its own; `None` with an undeformable rib, whose unknowns are others.
    #[inline(always)]
    pub(super) fn pivots_exceed(&self, limits: &Ends<R>) -> Option<R::Mask> {
        self.rib.is_none().then(|| self.block.pivots_exceed(limits))
    }

    /// Logarithm of the block's determinant.
    pub(super) fn log_determinant(&self) -> R {
        self.block.log_determinant()
    }

    /// Takes what the eliminated rung does off the stiffness of the rung below.
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

    /// y = L^-1 g of a gradient on the rung's nodes, g in generalised coordinates.
    #[inline(always)]
    pub(super) fn forward(&self, gradient: &Ends<R>) -> Ends<R> {
        match self.rib {
            None => self.block.forward(gradient),
            Some(rib) => self.block.forward(&rib.generalised(gradient)),
        }
    }

    /// Work of a residual on the correction of the rung, by its y, N mm.
    #[inline(always)]
    pub(super) fn work(&self, y: &Ends<R>) -> R {
        let mut y = *y;
        if let Some(row) = self.tied_row() {
            let zero = y[0].zero();
            y[row..row + 3].fill(zero);
        }
        self.block.work(&y)
    }

    /// Takes a gradient, by its y, off that of the rung below.
    #[inline(always)]
    pub(super) fn reduce_gradient(&self, y: &Ends<R>, below: &mut Ends<R>) {
        self.block.reduce_gradient(y, below);
        if let Some(row) = self.tied_row() {
            for i in row..row + 3 {
                below[i] += y[i];
            }
        }
    }

    /// Motion of two nodes for a gradient, by its y, and a motion of the rung below; rotation of a hinged rigid rib.
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
