//! What a camera sees of the touches: where the object lies against the finger and which way the surface faces there.

use crate::lattice::Lattice;
use crate::lattice::pressing::{Touch, TouchedPart};
use finray_model::sensing::{Contact, ContactPlace};
use finray_model::{Finger, Vector};

/// Touches nearer to each other than this share of a mean stretch of plate between rods are one contact to the camera; with a
/// rod among them, it is the rod's.
const TOGETHER: f64 = 0.25;

/// A contact as a camera sees it, with the force that it truly carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenContact {
    /// Place, and direction from the object into the finger.
    pub contact: Contact,
    /// Whether it is on a clamped part, where a force does not bend the finger.
    pub clamped: bool,
    /// Where, finger frame, deformed, mm.
    pub point: Vector,
    /// True force on the finger, N, finger frame.
    pub force: Vector,
    /// Its part along the contact's direction, N.
    pub normal_n: f64,
    /// Its part along the finger, positive towards the tip, N: friction.
    pub friction_n: f64,
}

/// Puts touches together to contacts, from base to tip.
pub fn seen_contacts(lattice: &Lattice, touches: &[Touch]) -> Vec<SeenContact> {
    let finger = lattice.finger();
    let together_mm =
        TOGETHER * finger.plate_length_mm(finray_model::finger::Plate::Front) / (finger.rib_count() + 1) as f64;
    let place = |touch: &Touch| touch.part.place_mm(lattice);
    let near = |a: &Touch, b: &Touch| a.clamped == b.clamped && place(b) - place(a) <= together_mm;
    touches.chunk_by(near).map(|group| seen(lattice, group)).collect()
}

fn seen(lattice: &Lattice, group: &[Touch]) -> SeenContact {
    let finger = lattice.finger();
    let rod = group.iter().find_map(|touch| match touch.part {
        TouchedPart::Rod(node) => Some(node),
        TouchedPart::Plate(_) => None,
    });
    let (first, last) = (&group[0], &group[group.len() - 1]);
    let place = match rod {
        Some(node) => ContactPlace::Node(node),
        None => ContactPlace::Place(0.5 * (first.part.place_mm(lattice) + last.part.place_mm(lattice))),
    };
    let normal = group.iter().map(|touch| touch.normal).sum::<Vector>().normalize();
    let force: Vector = group.iter().map(|touch| touch.force).sum();
    let contact = Contact { place, angle_deg: angle_deg(finger, normal) };
    SeenContact {
        contact,
        clamped: first.clamped,
        point: 0.5 * (first.point + last.point),
        force,
        normal_n: force.dot(&normal),
        friction_n: force.dot(&finger.direction(contact.angle_deg + 90.0)),
    }
}

/// Angle of a direction from the undeformed inward normal, positive towards the tip, degrees.
pub fn angle_deg(finger: &Finger, direction: Vector) -> f64 {
    direction.dot(&finger.front_tangent()).atan2(direction.dot(&finger.direction(0.0))).to_degrees()
}
