//! Results derived from an equilibrium: elastic energy and support reactions.

use super::FrameLoad;
use crate::Vector;
use crate::element::{ElementVector, Kinematics};
use crate::frame::{BeamEnd, FrameMotion, NodeIndex, PlaneFrame};

/// Elastic energy of a frame with a given motion, N mm.
pub fn elastic_energy(frame: &PlaneFrame, motion: &FrameMotion, kinematics: Kinematics) -> f64 {
    frame.members().iter().map(|member| member.response(motion, kinematics).energy).sum()
}

/// Force and moment that a support exerts on the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction {
    /// The supported node.
    pub node: NodeIndex,
    /// Force, N, in the frame's coordinates.
    pub force: Vector,
    /// Moment, N mm, positive from x to y.
    pub moment_nmm: f64,
}

/// Force and moment that a node needs for equilibrium in addition to the loads: the reaction of a support, and zero at a free node.
///
/// Sums the forces of the beams at the node and at nodes tied to it. The node must not belong to a rigid link.
pub fn reaction(
    frame: &PlaneFrame,
    motion: &FrameMotion,
    kinematics: Kinematics,
    loads: &[FrameLoad],
    node: NodeIndex,
) -> Reaction {
    let mut reaction = Reaction { node, force: Vector::zeros(), moment_nmm: 0.0 };
    let mut add = |ends: &[BeamEnd; 2], gradient: &ElementVector| {
        for (end, g) in ends.iter().zip([gradient.fixed_rows::<3>(0), gradient.fixed_rows::<3>(3)]) {
            if frame.tied_to(end.node) == node {
                reaction.force += Vector::new(g[0], g[1]);
                if end.rotation == frame.rotation_of(node) {
                    reaction.moment_nmm += g[2];
                }
            }
        }
    };
    for member in frame.members() {
        if member.ends.iter().any(|end| frame.tied_to(end.node) == node) {
            add(&member.ends, &member.response(motion, kinematics).gradient);
        }
    }
    for load in loads {
        if let FrameLoad::Interior { member, xi, force } = *load {
            let potential = frame.interior_load(motion, member, kinematics, xi, force);
            add(&frame.members()[member].ends, &potential.gradient);
        } else {
            let (end, force, moment_nmm) = load.at_end(frame);
            let potential = frame.end_load(motion, end, force, moment_nmm, kinematics == Kinematics::Linear);
            // The gradient of the potential with respect to the second end is zero.
            add(&[end, end], &potential.gradient);
        }
    }
    reaction
}
