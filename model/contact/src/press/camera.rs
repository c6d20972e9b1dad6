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

/// Distance between the two outline points that show the direction of the surfaces at a touch, mm. If a flat face of the object touches, the points
/// are the ends of that face. For a touch on a rod without a flat face, one point is the rod's centre. The other point is the touching corner, or the
/// centre of the touching disc. For a touch elsewhere on the plate without a flat face, the points are the ends of the plate segment.
pub fn baseline_mm(
    finger: &Finger,
    rod_radius_mm: f64,
    outline: &ContactOutline,
    object: Vector,
    touch: &Touch,
) -> f64 {
    let (_, disc_mm) = outline.corners();
    let face = outline.sides().map(|[a, b]| (a + object, b - a)).find(|(from, face)| {
        let length_mm = face.norm();
        let along = (touch.point - from).dot(face) / length_mm;
        let off_mm = (touch.point - from).perp(face).abs() / length_mm;
        touch.normal.dot(face).abs() <= ALONG_FACE * length_mm
            && off_mm <= ON_FACE_MM
            && (-ON_FACE_MM..=length_mm + ON_FACE_MM).contains(&along)
    });
    match (face, touch.part) {
        (Some((_, face)), _) => face.norm(),
        (None, TouchedPart::Rod(_)) => disc_mm + rod_radius_mm,
        (None, TouchedPart::On(wall, s_mm)) => member_mm(finger, (wall, s_mm)),
    }
}
