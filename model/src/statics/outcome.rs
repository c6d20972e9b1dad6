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
    /// Moment, N mm, positive if it turns the x axis towards the y axis.
    pub moment_nmm: f64,
}

/// Force and moment that must act on a node, in addition to the loads, for equilibrium: at a supported node the support reaction, at a free node
/// zero.
///
/// Sums the contributions of beams and loads at the node and at nodes tied to it. The node must not belong to a rigid link.
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
            // The potential of a load at one beam end depends on this end only, so the second half of its gradient is zero.
            add(&[end, end], &potential.gradient);
        }
    }
    reaction
}
