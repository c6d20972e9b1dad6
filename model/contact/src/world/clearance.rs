//! Clearances between the fingers, between a finger and a table, and between the object and clamped parts.

use super::World;
use crate::carrier::Carrier;
use crate::outline::PoseInFinger;
use crate::overlap::{crossing, to_segment};
use crate::part::{Part, Touches};
use crate::surface::Run;
use crate::{TouchedPart, Wall};
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

impl Round {
    /// Largest distance of a point of the part from its first end, mm.
    fn extent_mm(&self) -> f64 {
        (self.ends[1] - self.ends[0]).norm() + self.radius_mm
    }
}

impl World<'_> {
    /// Smallest distance between the fronts of the first two fingers, mm; 0 or less if they touch, infinite for a single finger.
    pub fn between_fingers_mm(&self) -> f64 {
        if self.scene.fingers.len() < 2 {
            return f64::INFINITY;
        }
        let [left, right] = [0, 1].map(|finger| self.front(finger));
        let mut least_mm = f64::INFINITY;
        for a in &left {
            // Pieces that are farther apart than the smallest distance so far need no exact distance.
            let is_near = |b: &&Round| (a.ends[0] - b.ends[0]).norm() - a.extent_mm() - b.extent_mm() < least_mm;
            let of_pair = |b: &Round| distance_mm(a.ends, b.ends) - a.radius_mm - b.radius_mm;
            least_mm = right.iter().filter(is_near).map(of_pair).fold(least_mm, f64::min);
        }
        least_mm
    }

    /// Whether the object would overlap a clamped part of the finger at the given placement of the finger.
    pub fn meets_clamp(&self, finger: usize, placement: &Placement) -> bool {
        let (standing, object) = (&self.scene.fingers[finger], self.now.state.object);
        let (motion, pose) = (&self.now.state.motions[finger], PoseInFinger::new(placement, object));
        let mut meets = false;
        standing.surface.near(motion, (&self.scene.shape, &pose), 0.0, Carrier::is_fixed, |_, _, _, gap_mm| {
            meets |= gap_mm < -ROUNDING_MM;
        });
        meets
    }

    /// Smallest height of a finger above a plane, mm; 0 or less if the finger touches the plane. A point (mm) and the upward unit normal define the plane.
    pub fn height_mm(&self, finger: usize, (point, upward): (Vector, Vector)) -> f64 {
        let above = |at: Vector| (at - point).dot(&upward);
        let front = self.front(finger);
        let of_front = front.iter().flat_map(|part| part.ends.map(|end| above(end) - part.radius_mm));
        // For the back plate and the ribs, the height of the back plate's nodes minus half the back plate's thickness counts.
        let (shape, of) = (self.finger_shape(finger), self.scene.fingers[finger].mesh.finger());
        let placement = &self.now.state.placements[finger];
        let back = of.plate_nodes(Plate::Back).into_iter().zip(of.plate_positions_mm(Plate::Back));
        let of_back = back.map(|(node, s_mm)| {
            above(placement.outwards(shape.point(FingerPoint::Node(node)))) - 0.5 * of.thickness_mm(Plate::Back, s_mm)
        });
        of_front.chain(of_back).fold(f64::INFINITY, f64::min)
    }

    /// The deformed surface of a finger's front as straight pieces between the points at which its parts begin and end.
    fn front(&self, finger: usize) -> Vec<Round> {
        let (standing, placement) = (&self.scene.fingers[finger], &self.now.state.placements[finger]);
        let round = |run: &Run| {
            let line = run.carrier.deformed(&run.carrier.coordinates(&self.now.state.motions[finger]));
            let parts = standing.surface.parts[run.parts.clone()].iter();
            let ends = |part: &Part| part.xi.map(|xi| placement.outwards(line.axis(xi).point));
            let is_front = |part: &&Part| !matches!(part.touched, TouchedPart::On(Wall::Back | Wall::Base, _));
            let rounds = parts.filter(|part| part.touches != Touches::Sides).filter(is_front);
            rounds.map(|part| Round { ends: ends(part), radius_mm: part.radius_mm }).collect::<Vec<_>>()
        };
        standing.surface.runs.iter().flat_map(round).collect()
    }
}

/// Distance between two line segments, mm; 0 if they cross.
fn distance_mm(a: [Vector; 2], b: [Vector; 2]) -> f64 {
    if crossing(a, b).is_some() {
        return 0.0;
    }
    let ends = [to_segment(a, b[0]), to_segment(a, b[1]), to_segment(b, a[0]), to_segment(b, a[1])];
    ends.into_iter().map(|(distance_mm, _)| distance_mm).fold(f64::INFINITY, f64::min)
}
