//! The finger as a ladder: plates condensed onto the key nodes, then pairs of key nodes eliminated from tip to base.
//!
//! A finger's equations have one long direction only. Members condense onto their ends ([`chain`]), which leaves the back and front node of each rib
//! as a block of six unknowns that is coupled to its two neighbours alone: a block tridiagonal system. Its elimination from the tip costs a fixed
//! number of operations a rib and touches no heap. The general sparse path ([`SparseEquations`](super::SparseEquations)) checks it.
//!
//! Stiffness and forces are apart: [`Factor`] is what a tangent needs, and that at rest is made once for a mesh. Linear
//! solutions need no other, and a co-rotational one begins with it. [`Balance`] is what forces need. Both are written in
//! [`Number`](crate::number::Number)s: under one load, or under several, one a lane.

mod balance;
mod block;
mod brackets;
mod cantilever;
mod chain;
mod dispatched;
mod elements;
mod ends;
mod factor;
mod lines;
mod loads;
mod response;
mod retraction;
mod rung;
mod side_by_side;

use super::EquilibriumEquations;
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;
pub(super) use balance::Balance;
use ends::Ends;
pub(super) use factor::Factor;

/// A pivot below this share of what members put on its diagonal has lost digits to cancellation that may count, and so has an element's share of a
/// member's stiffness: the paper's finger keeps 2e-2 on any mesh; thin plates, and random fingers that miss 1e-8, keep less.
const SMALL_PIVOT: f64 = 1e-3;

/// Where a frame node is in the ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Location {
    Clamped,
    Tip,
    Rung {
        rung: usize,
        row: usize,
    },
    /// Inside a line, `element` elements from its first end.
    Inside {
        line: usize,
        element: usize,
    },
}

/// Block elimination of a finger's equations.
#[derive(Debug, Clone)]
pub struct Ladder<'m> {
    mesh: &'m Mesh,
    kinematics: Kinematics,
    /// The stiffness away from rest.
    own: Factor,
    /// Whether the last linearised motion has the stiffness at rest, which the mesh keeps.
    rests: bool,
    /// Whether a linear factor of our own is wanted, and whether it is there.
    forgotten: bool,
    factored: bool,
    balance: Balance<'m>,
    /// One for each rung: what waits for the way back when loads are added.
    waiting: Vec<Ends>,
}

impl<'m> Ladder<'m> {
    /// Room for the elimination.
    pub fn new(mesh: &'m Mesh, kinematics: Kinematics) -> Ladder<'m> {
        Ladder {
            mesh,
            kinematics,
            own: Factor::none(0.0),
            rests: false,
            forgotten: false,
            factored: false,
            balance: Balance::new(mesh, kinematics, 0.0),
            waiting: vec![[0.0; 6]; mesh.finger().rib_count()],
        }
    }

    fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// The stiffness that was last used.
    fn factor(&self) -> &Factor {
        Factor::chosen(self.mesh, &self.own, self.rests)
    }

    /// Factorises the tangent at a motion.
    fn factorise(&mut self, motion: &FrameMotion) {
        self.own.make_room(self.mesh, 0.0);
        dispatched::factorise(&mut self.balance, &mut self.own, motion);
    }

    /// Whether the tangent is that of small displacements. Co-rotationally it is at rest, if loads neither stand on arms
    /// or between nodes, where they turn, nor pull at an undeformable rib.
    fn has_rest_stiffness(&self, unmoved: bool, loads: &[FrameLoad]) -> bool {
        if self.linear() {
            return !self.forgotten;
        }
        let deforms = || self.mesh.finger().description().ribs.strip.is_some();
        unmoved && deforms() && loads.iter().all(|load| matches!(load, FrameLoad::Node { .. }))
    }
}

impl EquilibriumEquations for Ladder<'_> {
    fn at_rest(&self) -> FrameMotion {
        FrameMotion::at_rest(self.mesh.frame())
    }

    fn kinematics(&self) -> Kinematics {
        self.kinematics
    }

    fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        let unmoved = motion.is_at_rest();
        self.rests = self.has_rest_stiffness(unmoved, loads);
        self.balance.take_off_loads();
        self.balance.apply_loads(0, motion, loads, factor);
        if self.rests || self.factored {
            self.balance.load_lines(Factor::chosen(self.mesh, &self.own, self.rests), motion, unmoved);
        } else {
            self.factorise(motion);
            self.factored = self.linear();
        }
        dispatched::eliminate_gradient(&mut self.balance, Factor::chosen(self.mesh, &self.own, self.rests));
        self.factor().positive
    }

    fn keeps_digits(&self) -> bool {
        self.factor().accurate
    }

    fn log_determinant(&mut self) -> Option<f64> {
        Some(self.factor().log_determinant(self.mesh)).filter(|sum| sum.is_finite())
    }

    fn forget_factor(&mut self) {
        (self.forgotten, self.factored) = (true, false);
    }

    fn elastic_energy(&self) -> f64 {
        self.balance.energy()
    }

    fn correct(&mut self, motion: &mut FrameMotion) -> f64 {
        dispatched::correct(&mut self.balance, Factor::chosen(self.mesh, &self.own, self.rests), motion)
    }

    fn largest_correction(&self) -> f64 {
        self.balance.largest_correction()
    }
}
