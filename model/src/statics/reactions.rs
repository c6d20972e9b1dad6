//! What the supports push back with.

use crate::Vector;
use crate::element::Kinematics;
use crate::frame::{Attachment, FrameMotion, NodeIndex, PlaneFrame};

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
    let linear = kinematics == Kinematics::Linear;
    let mut reaction = Reaction { node, force: Vector::zeros(), moment_nmm: 0.0 };
    for member in frame.members().iter().filter(|m| m.ends.iter().any(|end| end.node == node)) {
        let ends = member.ends.map(Attachment::from);
        let motions = ends.map(|end| frame.motion_at(motion, &end, linear));
        let response = member.beam.response(kinematics, &motions);
        let (gradient, _) = frame.pull_back(motion, &ends, &response, linear);
        for (end, g) in ends.iter().zip([gradient.fixed_rows::<3>(0), gradient.fixed_rows::<3>(4)]) {
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
