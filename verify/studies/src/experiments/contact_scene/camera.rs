//! Camera model of a contact: its position and direction from outline points, with noise.
//!
//! The camera sees the outlines of object and finger as points, each with an error of its own of the camera's standard deviation s a
//! coordinate, and apart from the markers, which are other pixels. The direction of a contact is read from two such points at a distance b
//! ([`baseline_mm`]), so that its standard deviation is sqrt(2) s / b; the position of a contact between rods from the distance of
//! two points along the plate, sqrt(2) s. Which parts touch is taken as known, and a contact at a rod alone lies at its node. Where several
//! parts touch as one contact, its force may be anywhere between them: the standard deviation of an even distribution is added.

use super::contacts::{HalfSpan, member_mm};
use super::{SeenContact, TurnedOutline};
use crate::prelude::*;
use finray_lattice::skin::{Touch, TouchedPart};
use finray_model::sensing::MeasuredContact;

/// Share of the segment at the base within which no position is sought: there a force bends nothing.
const NEAREST_TO_BASE: f64 = 0.01;

/// Standard deviation of an even distribution as a share of half its interval, 1 / sqrt(3).
const EVENLY: f64 = 0.577_350_269_189_625_8;

/// Reads a contact with the camera's noise; six standard normal numbers a contact.
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
        ContactPosition::At(s_mm) => {
            let length_mm = finger.plate_length_mm(Plate::Front);
            let least_mm = NEAREST_TO_BASE * member_mm(finger, 0.0);
            ContactPosition::At((s_mm + off.x - off.y).clamp(least_mm, length_mm))
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

/// Cosine of the angle between a face and a direction of contact up to which the contact is the face's.
const ALONG_FACE: f64 = 1e-3;
/// Distance of a touch from the face that it belongs to, mm: overlaps are smaller.
const ON_FACE_MM: f64 = 1e-2;

/// Distance of the two outline points that show which way the surfaces face at a touch, mm: the ends of a flat face of the object; of
/// a rod its centre and the centre of the disc or the corner that it lies against; for the plate otherwise the ends of its segment.
pub fn baseline_mm(finger: &Finger, rod_radius_mm: f64, outline: &TurnedOutline, object: Vector, touch: &Touch) -> f64 {
    let on_plate_mm = |s_mm| member_mm(finger, s_mm);
    match (outline, touch.part) {
        (TurnedOutline::Disc(radius_mm), TouchedPart::Rod(_)) => radius_mm + rod_radius_mm,
        (TurnedOutline::Disc(_), TouchedPart::Plate(s_mm)) => on_plate_mm(s_mm),
        (TurnedOutline::Polygon(corners), part) => {
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            let face = ends.map(|(a, b)| (a + object, b - a)).find(|(from, face)| {
                let length_mm = face.norm();
                let along = (touch.point - from).dot(face) / length_mm;
                let off_mm = (touch.point - from).perp(face).abs() / length_mm;
                touch.normal.dot(face).abs() <= ALONG_FACE * length_mm
                    && off_mm <= ON_FACE_MM
                    && (-ON_FACE_MM..=length_mm + ON_FACE_MM).contains(&along)
            });
            match (face, part) {
                (Some((_, face)), _) => face.norm(),
                (None, TouchedPart::Rod(_)) => rod_radius_mm,
                (None, TouchedPart::Plate(s_mm)) => on_plate_mm(s_mm),
            }
        }
    }
}
