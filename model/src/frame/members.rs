//! Energies of members and their derivatives in the coordinates of the frame, by the chain rule through rigid arms and rigid links.

use super::equations::{MEMBER_COORDINATES, NODE_COORDINATES};
use super::{BeamEnd, FrameMotion, Member, NodeIndex, PlaneFrame};
use crate::Vector;
use crate::element::{Elastic, EndMotion, Kinematics, Previous, Response, Station, quarter_turn};
use crate::number::{Number, sine_and_versine};
use nalgebra::{SMatrix, SVector, Vector2};

/// Displacement, mm, of the end of a lever that rotates by `rotation`: (R - 1) lever. The formula avoids cancellation for small rotations. If
/// `linear`, the displacement is of first order in the rotation.
#[inline(always)]
pub(crate) fn swing<R: Number>(lever: Vector2<R>, rotation: R, linear: bool) -> Vector2<R> {
    let quarter = quarter_turn(lever);
    if linear {
        return Vector2::new(rotation * quarter.x, rotation * quarter.y);
    }
    let (sine, versine) = sine_and_versine(rotation);
    Vector2::new(sine * quarter.x - versine * lever.x, sine * quarter.y - versine * lever.y)
}

/// Whether a beam end has an arm in any SIMD lane.
#[inline(always)]
fn has_arm<R: Number>(end: &BeamEnd<R>) -> bool {
    let zero = end.arm.x.zero();
    zero.anywhere(zero.either(end.arm.x.abs().exceeds(zero), end.arm.y.abs().exceeds(zero)))
}

#[inline(always)]
fn end_motion<R: Number>(motion: &FrameMotion<R>, end: &BeamEnd<R>, linear: bool) -> EndMotion<R> {
    let rotation = motion.rotations[end.rotation];
    let mut displacement = motion.displacements[end.node];
    if has_arm(end) {
        let swung = swing(end.arm, rotation, linear);
        displacement.x += swung.x;
        displacement.y += swung.y;
    }
    EndMotion { displacement, rotation }
}

/// The vector in the number type of `like`.
#[inline(always)]
pub(super) fn vector_of<R: Number>(vector: Vector, like: R) -> Vector2<R> {
    Vector2::new(like.constant(vector.x), like.constant(vector.y))
}

/// The vector of a lever after its rotation, mm; unchanged if `linear`.
#[inline(always)]
pub(super) fn turned<R: Number>(lever: Vector2<R>, rotation: R, linear: bool) -> Vector2<R> {
    if linear {
        return lever;
    }
    let swung = swing(lever, rotation, false);
    Vector2::new(swung.x + lever.x, swung.y + lever.y)
}

/// Motions of both ends of a member's elastic part (the beam without its rigid arms).
#[inline(always)]
pub(crate) fn end_motions<R: Number>(
    motion: &FrameMotion<R>,
    ends: &[BeamEnd<R>; 2],
    linear: bool,
) -> [EndMotion<R>; 2] {
    // `map` would pass the array through memory instead of registers.
    [end_motion(motion, &ends[0], linear), end_motion(motion, &ends[1], linear)]
}

impl BeamEnd {
    /// The beam end in the number type of `like`.
    #[inline(always)]
    fn in_numbers<R: Number>(&self, like: R) -> BeamEnd<R> {
        BeamEnd { node: self.node, rotation: self.rotation, arm: vector_of(self.arm, like) }
    }
}

impl Member {
    /// The member in the number type of `like`.
    #[inline(always)]
    pub(crate) fn in_numbers<R: Number>(&self, like: R) -> Member<R> {
        let Member { beam, ends: [first, second] } = self;
        Member { beam: beam.in_numbers(like), ends: [first.in_numbers(like), second.in_numbers(like)] }
    }
}

impl<R: Number> Member<R> {
    /// Motions of both ends of the elastic part.
    #[inline(always)]
    pub(crate) fn end_motions(&self, motion: &FrameMotion<R>, linear: bool) -> [EndMotion<R>; 2] {
        end_motions(motion, &self.ends, linear)
    }

    /// Elastic energy (N mm) of a member. The nodal forces and the tangent stiffness are the derivatives of this energy with respect to the motions
    /// of the two nodes, including the rigid arms.
    #[inline(always)]
    pub(crate) fn response(&self, motion: &FrameMotion<R>, kinematics: Kinematics) -> Response<R> {
        self.elastic(motion, kinematics, &mut Previous::at_rest(&self.beam), (false, false)).response
    }

    /// Same as [`response`](Member::response), with the arguments of [`Beam::elastic`].
    #[inline(always)]
    pub(crate) fn elastic(
        &self,
        motion: &FrameMotion<R>,
        kinematics: Kinematics,
        previous: &mut Previous<R>,
        extrapolates: (bool, bool),
    ) -> Elastic<R> {
        let linear = kinematics == Kinematics::Linear;
        let motions = self.end_motions(motion, linear);
        let mut elastic = self.beam.elastic(kinematics, &motions, previous, extrapolates);
        let force = elastic.turning_force;
        let rotations = [motions[0].rotation, motions[1].rotation];
        carry_over_arms(
            &self.ends,
            rotations,
            &mut elastic.response,
            [Vector2::new(-force.x, -force.y), force],
            linear,
        );
        elastic
    }

    /// Vector from the first to the second node, mm: undeformed if `linear`, otherwise deformed by the motion.
    #[inline(always)]
    pub(crate) fn lever(&self, motion: &FrameMotion<R>, linear: bool) -> Vector2<R> {
        let ([first, second], rest) = (&self.ends, self.beam.rest());
        let undeformed = Vector2::new(first.arm.x + rest.x - second.arm.x, first.arm.y + rest.y - second.arm.y);
        if linear {
            return undeformed;
        }
        let (from, to) = (&motion.displacements[first.node], &motion.displacements[second.node]);
        Vector2::new(to.x - from.x + undeformed.x, to.y - from.y + undeformed.y)
    }

    /// Energy (N mm) of a member, and forces on its two nodes (N, N mm), for small displacements. The forces include the effect of the rigid arms.
    #[inline(always)]
    pub(crate) fn linear_forces(&self, motion: &FrameMotion<R>) -> (R, SVector<R, 6>) {
        let (energy, mut gradient) = self.beam.linear_forces(&self.end_motions(motion, true));
        for (i, end) in self.ends.iter().enumerate() {
            let moment = gradient[3 * i + 1] * end.arm.x - gradient[3 * i] * end.arm.y;
            gradient[3 * i + 2] += moment;
        }
        (energy, gradient)
    }
}

impl PlaneFrame {
    /// Axial strain and curvature along a member under loads between its ends. Each load consists of a position (fraction of the length) and a force
    /// (N); see [`Beam::stations`](crate::element::Beam).
    pub(crate) fn stations(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        loads: &[(f64, Vector)],
    ) -> Vec<Station> {
        let member = &self.members[member];
        let motions = member.end_motions(motion, kinematics == Kinematics::Linear);
        member.beam.stations(kinematics, &motions, loads)
    }

    /// Transforms energy derivatives from two nodes to the frame's coordinates, by the chain rule through rigid links. [`carry_over_arms`] explains
    /// the second derivatives.
    pub(crate) fn carry_over_links(
        &self,
        motion: &FrameMotion,
        nodes: [NodeIndex; 2],
        response: &Response,
        linear: bool,
    ) -> (SVector<f64, MEMBER_COORDINATES>, SMatrix<f64, MEMBER_COORDINATES, MEMBER_COORDINATES>) {
        let mut first = SMatrix::<f64, 6, MEMBER_COORDINATES>::zeros();
        let mut second = SVector::<f64, MEMBER_COORDINATES>::zeros();
        for (i, node) in nodes.into_iter().enumerate() {
            first.fixed_view_mut::<3, 3>(3 * i, NODE_COORDINATES * i).fill_with_identity();
            for (k, (_, lever)) in self.turned_levers(node, motion, linear).enumerate() {
                let column = NODE_COORDINATES * i + 3 + k;
                first[(3 * i, column)] = -lever.y;
                first[(3 * i + 1, column)] = lever.x;
                if !linear {
                    second[column] = -(response.gradient[3 * i] * lever.x + response.gradient[3 * i + 1] * lever.y);
                }
            }
        }
        let mut tangent = first.transpose() * response.tangent * first;
        for (i, second) in second.iter().enumerate() {
            tangent[(i, i)] += second;
        }
        (first.transpose() * response.gradient, tangent)
    }
}

/// Forces of a response on its two ends, N.
#[inline(always)]
pub(super) fn end_forces<R: Number>(response: &Response<R>) -> [Vector2<R>; 2] {
    let gradient = &response.gradient;
    [Vector2::new(gradient[0], gradient[1]), Vector2::new(gradient[3], gradient[4])]
}

/// Transforms energy derivatives from the ends of the elastic part to the nodes, by the chain rule through rigid arms. `rotations` are the rotations
/// of the ends, rad.
///
/// The end of an arm v moves on a circle. The second derivative with respect to the arm's rotation therefore gains the term -f . v. Here f is one of
/// the `turning_forces`: the gradient with respect to the displacement of the arm's end, or its extrapolation.
#[inline(always)]
pub(crate) fn carry_over_arms<R: Number>(
    ends: &[BeamEnd<R>; 2],
    rotations: [R; 2],
    response: &mut Response<R>,
    turning_forces: [Vector2<R>; 2],
    linear: bool,
) {
    for (i, end) in ends.iter().enumerate() {
        if !has_arm(end) {
            continue;
        }
        let arm = turned(end.arm, rotations[i], linear);
        let (x, y, theta) = (3 * i, 3 * i + 1, 3 * i + 2);
        let (force_x, force_y) = (response.gradient[x], response.gradient[y]);
        response.gradient[theta] += arm.x * force_y - arm.y * force_x;
        // Adds -arm.y times row x and arm.x times row y to the row of the node's rotation, and treats the columns likewise.
        let tangent = &mut response.tangent;
        for k in 0..6 {
            let turning = arm.x * tangent[(y, k)] - arm.y * tangent[(x, k)];
            tangent[(theta, k)] += turning;
        }
        for k in 0..6 {
            let turning = arm.x * tangent[(k, y)] - arm.y * tangent[(k, x)];
            tangent[(k, theta)] += turning;
        }
        if !linear {
            tangent[(theta, theta)] -= turning_forces[i].x * arm.x + turning_forces[i].y * arm.y;
        }
    }
}
