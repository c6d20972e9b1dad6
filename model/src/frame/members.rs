//! Members seen from the coordinates of the frame: the chain rule over rigid arms and rigid links.

use super::equations::{MEMBER_COORDINATES, NODE_COORDINATES};
use super::{BeamEnd, FrameMotion, Member, NodeIndex, PlaneFrame, RotationSlot};
use crate::Vector;
use crate::element::{ElementVector, EndMotion, Kinematics, Response, Station};
use nalgebra::{SMatrix, SVector};

/// Displacement of the end of a lever that turns by `rotation`: (R - 1) lever, without cancellation for small turns.
pub(super) fn swing(lever: Vector, rotation: f64, linear: bool) -> Vector {
    let quarter = Vector::new(-lever.y, lever.x);
    if linear {
        return quarter * rotation;
    }
    let half = (0.5 * rotation).sin();
    quarter * rotation.sin() - lever * (2.0 * half * half)
}

#[inline(always)]
fn end_motion(motion: &FrameMotion, end: &BeamEnd, linear: bool) -> EndMotion {
    let rotation = motion.rotations[end.rotation];
    let mut displacement = motion.displacements[end.node];
    if end.arm != Vector::zeros() {
        displacement += swing(end.arm, rotation, linear);
    }
    EndMotion { displacement, rotation }
}

/// The lever turned by `rotation` (or left as it is), mm.
pub(super) fn turned(lever: Vector, rotation: f64, linear: bool) -> Vector {
    if linear { lever } else { lever + swing(lever, rotation, false) }
}

impl PlaneFrame {
    /// Motion of the elastic part's two ends.
    #[inline(always)]
    pub(crate) fn end_motions(&self, motion: &FrameMotion, ends: &[BeamEnd; 2], linear: bool) -> [EndMotion; 2] {
        // Not by `map`, which goes through memory.
        [end_motion(motion, &ends[0], linear), end_motion(motion, &ends[1], linear)]
    }

    /// Energy, nodal forces and tangent of a member by the motions of its two nodes, arms included.
    #[inline(always)]
    pub(crate) fn member_response(&self, motion: &FrameMotion, member: &Member, kinematics: Kinematics) -> Response {
        let linear = kinematics == Kinematics::Linear;
        let motions = self.end_motions(motion, &member.ends, linear);
        let mut response = member.beam.response(kinematics, &motions);
        self.carry_over_arms(motion, &member.ends, &mut response, linear);
        response
    }

    /// From a member's first to its second node, mm: as it is in the motion, or undeformed.
    #[inline(always)]
    pub(crate) fn lever(&self, motion: &FrameMotion, member: &Member, linear: bool) -> Vector {
        let [first, second] = &member.ends;
        let undeformed = first.arm + member.beam.direction * member.beam.length_mm - second.arm;
        if linear {
            return undeformed;
        }
        undeformed + (motion.displacements[second.node] - motion.displacements[first.node])
    }

    /// Energy and nodal forces of a member with small displacements, arms included.
    pub(crate) fn member_linear_forces(&self, motion: &FrameMotion, member: &Member) -> (f64, ElementVector) {
        let motions = self.end_motions(motion, &member.ends, true);
        let (energy, mut gradient) = member.beam.linear_forces(&motions);
        for (i, end) in member.ends.iter().enumerate() {
            gradient[3 * i + 2] += end.arm.x * gradient[3 * i + 1] - end.arm.y * gradient[3 * i];
        }
        (energy, gradient)
    }

    /// Axial strain and curvature along a member's beam under forces (N) at fractions of its length; see
    /// [`Beam::stations`](crate::element::Beam).
    pub(crate) fn stations(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        loads: &[(f64, Vector)],
    ) -> Vec<Station> {
        let Member { beam, ends } = &self.members[member];
        let motions = self.end_motions(motion, ends, kinematics == Kinematics::Linear);
        beam.stations(kinematics, &motions, loads)
    }

    /// Chain rule from the ends of the elastic part over the arms to the nodes.
    ///
    /// The end of an arm v moves on a circle about its node, so it adds -f . v to the second derivative by the
    /// rotation, f the gradient at the end.
    pub(crate) fn carry_over_arms(
        &self,
        motion: &FrameMotion,
        ends: &[BeamEnd; 2],
        response: &mut Response,
        linear: bool,
    ) {
        for (i, end) in ends.iter().enumerate().filter(|(_, end)| end.arm != Vector::zeros()) {
            let arm = turned(end.arm, motion.rotations[end.rotation], linear);
            let (x, y, theta) = (3 * i, 3 * i + 1, 3 * i + 2);
            let force = Vector::new(response.gradient[x], response.gradient[y]);
            response.gradient[theta] += arm.perp(&force);
            // Rotating by the node adds -arm.y times the row of x and arm.x times that of y; likewise the columns.
            let tangent = &mut response.tangent;
            for k in 0..6 {
                tangent[(theta, k)] += arm.x * tangent[(y, k)] - arm.y * tangent[(x, k)];
            }
            for k in 0..6 {
                tangent[(k, theta)] += arm.x * tangent[(k, y)] - arm.y * tangent[(k, x)];
            }
            if !linear {
                tangent[(theta, theta)] -= force.dot(&arm);
            }
        }
    }

    /// The lever that carries a linked node, in its current direction, and the slot it turns with.
    pub(crate) fn link_of(
        &self,
        node: NodeIndex,
        motion: &FrameMotion,
        linear: bool,
    ) -> Option<(RotationSlot, Vector)> {
        let link = self.nodes[node].link?;
        Some((link.rotation, turned(link.lever, motion.rotations[link.rotation], linear)))
    }

    /// Chain rule from two nodes to the coordinates of the frame, over the rigid links that may carry them; the second
    /// derivatives are those of [`carry_over_arms`](PlaneFrame::carry_over_arms).
    pub(crate) fn carry_over_links(
        &self,
        motion: &FrameMotion,
        nodes: [NodeIndex; 2],
        response: &Response,
        linear: bool,
    ) -> (SVector<f64, MEMBER_COORDINATES>, SMatrix<f64, MEMBER_COORDINATES, MEMBER_COORDINATES>) {
        let mut first = SMatrix::<f64, 6, MEMBER_COORDINATES>::zeros();
        let mut second = [0.0; 2];
        for (i, node) in nodes.into_iter().enumerate() {
            first.fixed_view_mut::<3, 3>(3 * i, NODE_COORDINATES * i).fill_with_identity();
            if let Some((_, lever)) = self.link_of(node, motion, linear) {
                let column = NODE_COORDINATES * i + 3;
                first[(3 * i, column)] = -lever.y;
                first[(3 * i + 1, column)] = lever.x;
                if !linear {
                    second[i] = -(response.gradient[3 * i] * lever.x + response.gradient[3 * i + 1] * lever.y);
                }
            }
        }
        let mut tangent = first.transpose() * response.tangent * first;
        for (i, second) in second.into_iter().enumerate() {
            tangent[(NODE_COORDINATES * i + 3, NODE_COORDINATES * i + 3)] += second;
        }
        (first.transpose() * response.gradient, tangent)
    }
}
