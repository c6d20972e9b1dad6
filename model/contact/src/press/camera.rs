//! Model of how a camera reads a contact: position and direction come from outline points with noise.
//!
//! The camera sees the outlines of object and finger as points. The coordinates of the outline points have independent errors with standard deviation
//! s. Errors of outline points are also independent of the errors of the markers, which are at other pixels.
//!
//! The direction of a contact comes from two outline points at a distance b ([`baseline_mm`]), so its standard deviation is sqrt(2) s / b. For a
//! contact on the plate between two rods, the position is the distance of two points along the plate. The standard deviation of this position is
//! sqrt(2) s. Sensing is assumed to know which parts touch. A contact at a single rod is placed at the rod's node. If several parts touch as one
//! contact, its force may act anywhere between them, so the standard deviation of a uniform distribution is added.

use super::SeenContact;
use super::contacts::{HalfSpan, member_mm};
use crate::outline::ContactOutline;
use crate::{Touch, TouchedPart};
use finray_model::finger::PlatePosition;
use finray_model::sensing::{Contact, ContactPosition, MeasuredContact};
use finray_model::{Finger, Vector};

/// Positions read by the camera are at least this distance from the base, relative to the first segment's length. A force nearer to the base would
/// not deform the finger.
const NEAREST_TO_BASE: f64 = 0.01;

/// Standard deviation of a uniform distribution relative to half its interval, 1 / sqrt(3).
const EVENLY: f64 = 0.577_350_269_189_625_8;

/// Contact as read by the camera with noise of `noise_mm` (standard deviation of a coordinate, mm). Uses six standard normal numbers.
pub fn read_contact(
    finger: &Finger,
    seen: &SeenContact,
    noise_mm: f64,
    mut standard_normal: impl FnMut() -> f64,
) -> MeasuredContact {
    let mut point = || Vector::new(standard_normal(), standard_normal()) * noise_mm;
    let baseline = Vector::new(seen.baseline_mm, 0.0) + point() - point();
    let turn_deg = baseline.y.atan2(baseline.x).to_degrees();
    let off = point();
    let position = match seen.contact.position {
        ContactPosition::Node(node) => ContactPosition::Node(node),
        ContactPosition::At(at) => {
            let length_mm = finger.plate_length_mm(at.plate);
            let least_mm = NEAREST_TO_BASE * member_mm(finger, (seen.wall, 0.0));
            ContactPosition::At(PlatePosition { s_mm: (at.s_mm + off.x - off.y).clamp(least_mm, length_mm), ..at })
        }
    };
    let two_points_mm = std::f64::consts::SQRT_2 * noise_mm;
    let HalfSpan { along_mm, turn_rad } = seen.half_span;
    MeasuredContact {
        contact: Contact { position, angle_deg: seen.contact.angle_deg + turn_deg },
        direction_sd_rad: (two_points_mm / seen.baseline_mm).hypot(EVENLY * turn_rad),
        position_sd_mm: match position {
            ContactPosition::Node(_) => 0.0,
            ContactPosition::At(_) => two_points_mm.hypot(EVENLY * along_mm),
        },
    }
}

/// A touch belongs to a face of the object if the cosine of the angle between the face and the touch's normal is at most this value.
const ALONG_FACE: f64 = 1e-3;
/// Largest distance of a touch from the face to which it belongs, mm; overlaps of object and finger are smaller.
const ON_FACE_MM: f64 = 1e-2;
/// Two sides of a polygon belong to a curve if the outline turns between them by at most this angle, rad (that of a polygon of 24 equal sides), and
/// neither is longer than the other by more than the factor `ALIKE`.
const TANGENT_RAD: f64 = 0.27;
const ALIKE: f64 = 3.0;
/// Sides are on one line if the outline turns between them by at most this angle, rad: more than rounding.
const STRAIGHT_RAD: f64 = 1e-6;

/// Distance between the two outline points that show the direction of the surfaces at a touch, mm. If a flat face of the object touches, the points
/// are the ends of that face. For a touch on a rod without a flat face, one point is the rod's centre. The other point is the touching corner, or the
/// centre of the curve that touches: a disc, or short sides of a polygon that hardly turn. For a touch elsewhere on the plate without a flat face,
/// the points are the ends of the plate segment.
pub fn baseline_mm(
    finger: &Finger,
    rod_radius_mm: f64,
    outline: &ContactOutline,
    object: Vector,
    touch: &Touch,
) -> f64 {
    let at = touch.point - object;
    let sides = faces(outline);
    let distance_mm = |&i: &usize| {
        let [from, to] = sides[i];
        let share = (at - from).dot(&(to - from)) / (to - from).norm_squared();
        (at - from - (to - from) * share.clamp(0.0, 1.0)).norm()
    };
    let touching = (0..sides.len()).min_by(|a, b| distance_mm(a).total_cmp(&distance_mm(b)));
    let radius_mm = touching.map_or(Some(outline.corners().1), |i| radius_mm(&sides, i));
    let is_face = |i: &usize| {
        let face = sides[*i][1] - sides[*i][0];
        touch.normal.dot(&face).abs() <= ALONG_FACE * face.norm() && distance_mm(i) <= ON_FACE_MM
    };
    let face = (0..sides.len()).filter(|_| radius_mm.is_none()).find(is_face);
    match (face, touch.part) {
        (Some(face), _) => (sides[face][1] - sides[face][0]).norm(),
        (None, TouchedPart::Rod(_)) => radius_mm.unwrap_or_default() + rod_radius_mm,
        (None, TouchedPart::On(wall, s_mm)) => member_mm(finger, (wall, s_mm)),
    }
}

/// Sides of a polygon, with sides on one line joined; none for a disc.
fn faces(outline: &ContactOutline) -> Vec<[Vector; 2]> {
    let sides: Vec<[Vector; 2]> = outline.sides().collect();
    let turns = |(i, [from, to]): (usize, &[Vector; 2])| {
        let [before, _] = sides[(i + sides.len() - 1) % sides.len()];
        ((from - before).angle(&(to - from)) > STRAIGHT_RAD).then_some(*from)
    };
    let corners: Vec<Vector> = sides.iter().enumerate().filter_map(turns).collect();
    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]).collect()
}

/// Radius of the curve to which a side of a polygon belongs, mm: the sides of a finely sampled curve are no flat faces. `None` for a flat face.
fn radius_mm(sides: &[[Vector; 2]], side: usize) -> Option<f64> {
    let along = |i: usize| sides[i][1] - sides[i][0];
    let of_neighbour = |other: usize| {
        let (turn_rad, lengths_mm) = (along(side).angle(&along(other)), [along(side).norm(), along(other).norm()]);
        let is_alike = lengths_mm[0] <= ALIKE * lengths_mm[1] && lengths_mm[1] <= ALIKE * lengths_mm[0];
        (is_alike && turn_rad <= TANGENT_RAD).then(|| 0.5 * (lengths_mm[0] + lengths_mm[1]) / turn_rad)
    };
    let neighbours = [(side + 1) % sides.len(), (side + sides.len() - 1) % sides.len()];
    neighbours.into_iter().filter_map(of_neighbour).min_by(f64::total_cmp)
}
