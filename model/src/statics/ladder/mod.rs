//! The finger as a ladder. Plates and ribs are condensed onto the key nodes. The two key nodes of each rib (a rung) are then eliminated, from tip to
//! base.
//!
//! Members are condensed onto their ends ([`chain`]). The back and front node of each rib then remain as a block of six unknowns. Each block is
//! coupled only to its two neighbours, so the system is block tridiagonal. Elimination from the tip needs a fixed number of operations per rib and no
//! heap memory. Tests compare the solution with the sparse solver ([`SparseEquations`](super::SparseEquations)).
//!
//! Stiffness and forces are stored separately. [`Factor`] stores the factored tangent. The tangent at rest is computed only once per mesh. Linear
//! solutions need only the tangent at rest. Co-rotational solutions start with the tangent at rest if the ribs are deformable and all loads act on
//! nodes. [`Balance`] stores the forces. [`Factor`] and [`Balance`] are generic over [`Number`](crate::number::Number), for one load or for several
//! loads in SIMD lanes.

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
mod ports;
mod response;
mod retraction;
mod rung;
mod side_by_side;

use super::EquilibriumEquations;
use crate::Kinematics;
use crate::element::Previous;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;
pub(super) use balance::Balance;
use ends::Ends;
pub(super) use factor::Factor;

/// A pivot below this share of the members' diagonal terms may have lost significant digits to cancellation. The same limit applies when an element
/// is appended to a chain: each diagonal term is compared with its value before. For the paper's finger, every pivot is at least 2e-2 of the members'
/// diagonal terms, on any mesh. Pivots below the limit occur for thin plates, and for all random fingers with errors above 1e-8.
const SMALL_PIVOT: f64 = 1e-3;

/// Location of a frame node or of a load in the ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Location {
    Clamped,
    Tip,
    Rung {
        rung: usize,
        row: usize,
    },
    /// A node inside a line, `element` elements from the line's first end, or a load on the element with the index `element`, counted from 0.
    Inside {
        line: usize,
        element: usize,
    },
}

/// Equilibrium equations of a finger, solved by block elimination.
#[derive(Debug, Clone)]
pub struct Ladder<'m> {
    mesh: &'m Mesh,
    kinematics: Kinematics,
    /// The factored stiffness at motions other than rest.
    own: Factor,
    /// Whether the last linearisation used the stiffness at rest, which the mesh stores.
    rests: bool,
    balance: Balance<'m>,
    /// While sensitivities are computed: first the gradients on each rung, then the forward substitutions of these gradients.
    waiting: Vec<Ends>,
}

impl<'m> Ladder<'m> {
    /// Prepares the elimination for a mesh.
    pub fn new(mesh: &'m Mesh, kinematics: Kinematics) -> Ladder<'m> {
        Ladder {
            mesh,
            kinematics,
            own: Factor::none(0.0),
            rests: false,
            balance: Balance::new(mesh, kinematics, 0.0),
            waiting: vec![[0.0; 6]; mesh.finger().rib_count()],
        }
    }

    /// Shape of each member at the last linearised motion.
    pub(super) fn previous(&self) -> &[Previous] {
        &self.balance.previous
    }

    fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// The factored stiffness of the last linearisation.
    fn factor(&self) -> &Factor {
        Factor::chosen(self.mesh, &self.own, self.rests)
    }

    /// Factorises the tangent at a motion.
    fn factorise(&mut self, motion: &FrameMotion) {
        self.own.make_room(self.mesh, 0.0);
        dispatched::factorise(&mut self.balance, &mut self.own, motion);
    }

    /// Whether the tangent equals the stiffness at rest. With nonlinear kinematics, the tangent equals the stiffness at rest if nothing has moved,
    /// the ribs are deformable, and all loads act on nodes. Loads on arms or between nodes contribute to the tangent.
    fn has_rest_stiffness(&self, unmoved: bool, loads: &[FrameLoad]) -> bool {
        if self.linear() {
            return true;
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

    fn relinearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        self.balance.extrapolates = !self.linear();
        let positive = self.linearise(motion, loads, factor);
        self.balance.extrapolates = false;
        positive
    }

    fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        let unmoved = motion.is_at_rest();
        self.rests = self.has_rest_stiffness(unmoved, loads);
        self.balance.take_off_loads();
        self.balance.apply_loads(0, motion, loads, factor);
        if self.rests {
            self.balance.load_lines(Factor::chosen(self.mesh, &self.own, self.rests), motion, unmoved);
        } else {
            self.factorise(motion);
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

    fn elastic_energy(&self) -> f64 {
        self.balance.energy
    }

    fn correct(&mut self, motion: &mut FrameMotion) -> f64 {
        dispatched::correct(&mut self.balance, Factor::chosen(self.mesh, &self.own, self.rests), motion)
    }

    fn largest_correction(&self) -> f64 {
        self.balance.largest_correction()
    }
}
