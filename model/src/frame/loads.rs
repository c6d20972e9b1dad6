//! Dead loads seen from the coordinates of the nodes that carry them.

use super::members::turned;
use super::{BeamEnd, FrameMotion, PlaneFrame};
use crate::Vector;
use crate::element::{Beam, ElementVector, EndMotion, Kinematics, Response};
use crate::statics::FrameLoad;
use nalgebra::{SMatrix, SVector};

/// Potentials of dead loads (minus their work), by the motions of the nodes that carry them.
impl PlaneFrame {
    /// Of a force between the ends of a member, by the motions of its two nodes.
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

    /// Of a force and moment at the end of an arm, by the motion of its node (the first three coordinates).
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
        self.carry_over_arms(motion, &[end, end], &mut potential, linear);
        potential
    }

    /// How the forces of a load on its member's nodes change per mm that the load moves towards the second end.
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

    /// Something between the ends of a member's beam, by the motions of its two nodes.
    fn inside(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        of: impl Fn(&Beam, &[EndMotion; 2]) -> Response,
    ) -> Response {
        let linear = kinematics == Kinematics::Linear;
        let member = &self.members[member];
        let mut response = of(&member.beam, &self.end_motions(motion, &member.ends, linear));
        self.carry_over_arms(motion, &member.ends, &mut response, linear);
        response
    }

    /// The same for a load on an arm that lengthens in the direction `along` (undeformed).
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

    /// Rotation of what carries a load, rad.
    pub(crate) fn rotation_at(&self, motion: &FrameMotion, load: &FrameLoad) -> f64 {
        match *load {
            FrameLoad::Interior { member, xi, .. } => {
                let member = &self.members[member];
                member.beam.interior_rotation(xi, &self.end_motions(motion, &member.ends, false))
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => motion.rotations[load.at_end(self).0.rotation],
        }
    }
}
