//! What an equilibrium holds: elastic energy, and the forces of the supports.

use crate::Vector;
use crate::element::Kinematics;
use crate::frame::{FrameMotion, NodeIndex, PlaneFrame};

/// Elastic energy of a frame in a motion, N mm.
pub fn elastic_energy(frame: &PlaneFrame, motion: &FrameMotion, kinematics: Kinematics) -> f64 {
    frame.members().iter().map(|member| frame.member_response(motion, member, kinematics).energy).sum()
}

/// Force and moment that a support puts on the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction {
    /// The supported node.
    pub node: NodeIndex,
    /// Force, N.
    pub force: Vector,
    /// Moment, N mm.
    pub moment_nmm: f64,
}

/// What must act on a node from outside for the beams that end there to be in equilibrium: at a support its reaction,
/// at a free node the load on it.
///
/// Beams are summed, so the node must not belong to a rigid link.
pub fn reaction(frame: &PlaneFrame, motion: &FrameMotion, kinematics: Kinematics, node: NodeIndex) -> Reaction {
    let mut reaction = Reaction { node, force: Vector::zeros(), moment_nmm: 0.0 };
    for member in frame.members().iter().filter(|m| m.ends.iter().any(|end| end.node == node)) {
        let g = frame.member_response(motion, member, kinematics).gradient;
        for (end, g) in member.ends.iter().zip([[g[0], g[1], g[2]], [g[3], g[4], g[5]]]) {
            if end.node == node {
                reaction.force += Vector::new(g[0], g[1]);
                if end.rotation == frame.rotation_of(node) {
                    reaction.moment_nmm += g[2];
                }
            }
        }
    }
    reaction
}
