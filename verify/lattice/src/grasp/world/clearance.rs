//! Clearances between the fingers, between a finger and a table, and between the object and clamped parts.

use super::World;
use crate::energy::BodyMotion;
use crate::grasp::contact::PairPose;
use crate::grasp::surface::Part;
use finray_model::Vector;
use finray_model::finger::{FingerPoint, Plate};
use finray_model::gripper::Placement;

/// Two bodies count as overlapping only above this depth, mm; rounding errors are smaller.
const ROUNDING_MM: f64 = 1e-9;

/// A deformed part of a finger's front surface: all points within a radius (mm) of a line segment, world frame.
struct Round {
    ends: [Vector; 2],
    radius_mm: f64,
}

impl World<'_> {
    /// Smallest distance between the fronts of the first two fingers, mm; 0 or less if they touch, infinite for a single finger.
    pub fn between_fingers_mm(&self) -> f64 {
        if self.scene.fingers.len() < 2 {
            return f64::INFINITY;
        }
        let [left, right] = [0, 1].map(|finger| self.front(finger));
        let of_pair = |a: &Round, b: &Round| distance_mm(a.ends, b.ends) - a.radius_mm - b.radius_mm;
        left.iter().flat_map(|a| right.iter().map(move |b| of_pair(a, b))).fold(f64::INFINITY, f64::min)
    }

    /// Whether the object would overlap a clamped part of the finger at the given placement of the finger.
    pub fn meets_clamp(&self, finger: usize, placement: &Placement) -> bool {
        let standing = &self.scene.fingers[finger];
        let bodies = &standing.lattice.assembly().bodies;
        let at = PairPose { finger: *placement, body: BodyMotion::default(), object: self.state.object };
        standing.front.parts.iter().filter(|part| bodies[part.body].fixed).any(|part| {
            let body = &bodies[part.body];
            let pairs = self.scene.shape.near(part, body, &at, 0.0);
            pairs.iter().any(|(_, pair)| pair.touching(body.position, &at, &at).gap_mm < -ROUNDING_MM)
        })
    }

    /// Smallest height of a finger above a plane, mm; 0 or less if the finger touches the plane. A point (mm) and the upward unit normal define the plane.
    pub fn height_mm(&self, finger: usize, (point, upward): (Vector, Vector)) -> f64 {
        let above = |at: Vector| (at - point).dot(&upward);
        let front = self.front(finger);
        let of_front = front.iter().flat_map(|part| part.ends.map(|end| above(end) - part.radius_mm));
        // For the back plate and the ribs, the height of the back plate's nodes minus half the back plate's thickness counts.
        let (shape, of) = (self.finger_shape(finger), self.scene.fingers[finger].lattice.finger());
        let placement = &self.state.placements[finger];
        let back = of.plate_nodes(Plate::Back).into_iter().zip(of.plate_positions_mm(Plate::Back));
        let of_back = back.map(|(node, s_mm)| {
            above(placement.outwards(shape.point(FingerPoint::Node(node)))) - 0.5 * of.thickness_mm(Plate::Back, s_mm)
        });
        of_front.chain(of_back).fold(f64::INFINITY, f64::min)
    }

    fn front(&self, finger: usize) -> Vec<Round> {
        let (standing, placement) = (&self.scene.fingers[finger], &self.state.placements[finger]);
        let round = |part: &Part| {
            let (body, motion) = (standing.lattice.assembly().bodies[part.body], self.state.motions[finger][part.body]);
            let at = |arm: Vector| placement.outwards(body.position + motion.displacement + motion.carried(arm));
            Round { ends: [at(part.from), at(part.to.unwrap_or(part.from))], radius_mm: part.radius_mm }
        };
        standing.front.parts.iter().map(round).collect()
    }
}

/// Distance between two line segments, mm; 0 if they cross.
fn distance_mm(a: [Vector; 2], b: [Vector; 2]) -> f64 {
    let sides = |[from, to]: [Vector; 2], others: [Vector; 2]| others.map(|other| (to - from).perp(&(other - from)));
    let parts = |[first, second]: [f64; 2]| first * second < 0.0;
    if parts(sides(a, b)) && parts(sides(b, a)) {
        return 0.0;
    }
    let to_line = |[from, to]: [Vector; 2], point: Vector| {
        let along = to - from;
        let share = (point - from).dot(&along) / along.norm_squared();
        // A segment of zero length is treated as a point.
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
        (point - from - along * share).norm()
    };
    [to_line(a, b[0]), to_line(a, b[1]), to_line(b, a[0]), to_line(b, a[1])].into_iter().fold(f64::INFINITY, f64::min)
}
