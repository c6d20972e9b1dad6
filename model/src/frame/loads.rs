//! Dead loads on a frame, and the derivatives of their potentials with respect to the coordinates of the loaded nodes.

use super::members::{carry_over_arms, end_forces, swing, turned};
use super::{BeamEnd, FrameMotion, NodeIndex, PlaneFrame};
use crate::Vector;
use crate::element::{Beam, ElementVector, EndMotion, Kinematics, Response};
use nalgebra::{SMatrix, SVector};

/// A dead load on a frame. A dead load keeps its direction while the frame moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameLoad {
    /// A force (N) and a moment (N mm) on a node.
    Node {
        /// The loaded node.
        node: NodeIndex,
        /// Force, N.
        force: Vector,
        /// Moment, N mm, positive from x to y.
        moment_nmm: f64,
    },
    /// A force (N) at the end of a rigid arm.
    Arm {
        /// The beam end with the arm on which the force acts.
        end: BeamEnd,
        /// Force, N.
        force: Vector,
    },
    /// A force (N) at a position between the ends of a member.
    Interior {
        /// Index of the loaded member.
        member: usize,
        /// Position of the force as a fraction of the member's length, 0..1.
        xi: f64,
        /// Force, N.
        force: Vector,
    },
}

impl FrameLoad {
    /// Returns the load multiplied by a dimensionless factor.
    pub fn scaled(self, factor: f64) -> FrameLoad {
        match self {
            FrameLoad::Node { node, force, moment_nmm } => {
                FrameLoad::Node { node, force: force * factor, moment_nmm: moment_nmm * factor }
            }
            FrameLoad::Arm { end, force } => FrameLoad::Arm { end, force: force * factor },
            FrameLoad::Interior { member, xi, force } => FrameLoad::Interior { member, xi, force: force * factor },
        }
    }

    /// The loaded beam end, and the load's force (N) and moment (N mm). For an interior load, the beam end is the first end of the loaded member.
    pub(crate) fn at_end(&self, frame: &PlaneFrame) -> (BeamEnd, Vector, f64) {
        match *self {
            FrameLoad::Node { node, force, moment_nmm } => (frame.clamped_end(node), force, moment_nmm),
            FrameLoad::Arm { end, force } => (end, force, 0.0),
            FrameLoad::Interior { member, force, .. } => (frame.members()[member].ends[0], force, 0.0),
        }
    }

    /// Whether force, moment and position are finite.
    pub fn is_finite(&self) -> bool {
        let force_is_finite = |force: &Vector| force.iter().all(|f| f.is_finite());
        match self {
            FrameLoad::Node { force, moment_nmm, .. } => force_is_finite(force) && moment_nmm.is_finite(),
            FrameLoad::Arm { force, .. } => force_is_finite(force),
            FrameLoad::Interior { xi, force, .. } => xi.is_finite() && force_is_finite(force),
        }
    }
}

/// Potentials of dead loads (minus their work), and their derivatives with respect to the motions of the loaded nodes.
impl PlaneFrame {
    /// Potential (N mm) of a force between the ends of a member, with its derivatives with respect to the motions of the member's two nodes.
    pub(crate) fn interior_load(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        xi: f64,
        force: Vector,
    ) -> Response {
        self.inside(motion, member, kinematics, |beam, motions| beam.interior_work(kinematics, xi, -force, motions))
    }

    /// First and second derivatives of the potential of a force (N) and moment (N mm) at the end of an arm. The derivatives are taken with respect to
    /// the motion of the arm's node (the first three coordinates). The potential is not computed: the returned energy is zero.
    pub(crate) fn end_load(
        &self,
        motion: &FrameMotion,
        end: BeamEnd,
        force: Vector,
        moment_nmm: f64,
        linear: bool,
    ) -> Response {
        let mut potential = Response { energy: 0.0, gradient: SVector::zeros(), tangent: SMatrix::zeros() };
        potential.gradient.fixed_rows_mut::<3>(0).copy_from_slice(&[-force.x, -force.y, -moment_nmm]);
        let forces = end_forces(&potential);
        carry_over_arms(&[end, end], [motion.rotations[end.rotation]; 2], &mut potential, forces, linear);
        potential
    }

    /// Derivative of an interior load's forces on the nodes of its member, per mm that the load moves towards the second end.
    pub(crate) fn interior_load_slope(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        xi: f64,
        force: Vector,
    ) -> ElementVector {
        let slope = |beam: &Beam, motions: &[EndMotion; 2]| {
            let gradient = beam.interior_load_slope(kinematics, xi, force, motions);
            Response { energy: 0.0, gradient, tangent: SMatrix::zeros() }
        };
        self.inside(motion, member, kinematics, slope).gradient
    }

    /// Evaluates the function `of` for a member's beam, and transforms the derivatives to the motions of the member's two nodes.
    fn inside(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        of: impl Fn(&Beam, &[EndMotion; 2]) -> Response,
    ) -> Response {
        let linear = kinematics == Kinematics::Linear;
        let member = &self.members[member];
        let motions = member.end_motions(motion, linear);
        let mut response = of(&member.beam, &motions);
        let forces = end_forces(&response);
        carry_over_arms(&member.ends, motions.map(|end| end.rotation), &mut response, forces, linear);
        response
    }

    /// Derivative of an arm load's forces on its node, per mm of the arm's length. `along` is the undeformed direction in which the arm grows.
    pub(crate) fn arm_load_slope(
        &self,
        motion: &FrameMotion,
        end: BeamEnd,
        along: Vector,
        force: Vector,
        linear: bool,
    ) -> ElementVector {
        let along = turned(along, motion.rotations[end.rotation], linear);
        ElementVector::new(0.0, 0.0, along.perp(&force), 0.0, 0.0, 0.0)
    }

    /// Displacement of the loaded point, mm, in a motion of the frame with co-rotational kinematics.
    pub(crate) fn displacement_at(&self, motion: &FrameMotion, load: &FrameLoad) -> Vector {
        match *load {
            FrameLoad::Interior { member, xi, .. } => {
                // The work of a unit force equals the displacement in the direction of the force.
                let moved = |way: Vector| {
                    self.inside(motion, member, Kinematics::Corotational, |beam, motions| {
                        beam.interior_work(Kinematics::Corotational, xi, way, motions)
                    })
                };
                Vector::new(moved(Vector::x()).energy, moved(Vector::y()).energy)
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => {
                let (end, ..) = load.at_end(self);
                motion.displacements[end.node] + swing(end.arm, motion.rotations[end.rotation], false)
            }
        }
    }

    /// Rotation of the loaded cross-section or node, rad, in a motion of the frame with co-rotational kinematics.
    pub(crate) fn rotation_at(&self, motion: &FrameMotion, load: &FrameLoad) -> f64 {
        match *load {
            FrameLoad::Interior { member, xi, .. } => {
                let member = &self.members[member];
                member.beam.interior_rotation(xi, &member.end_motions(motion, false))
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => motion.rotations[load.at_end(self).0.rotation],
        }
    }
}
