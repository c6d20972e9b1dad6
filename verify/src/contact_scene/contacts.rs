//! What a camera sees of the touches: where the object lies against the finger and which way the surface faces there.

use crate::lattice::Lattice;
use crate::lattice::skin::{Touch, TouchedPart};
use finray_model::finger::Plate;
use finray_model::sensing::{Contact, ContactPlace};
use finray_model::{Finger, NodeId, Vector};

/// Touches within this share of the stretch of plate that they lie on are one contact to the camera; with a rod among them, it is
/// the rod's. Two rods are never one contact.
const TOGETHER: f64 = 0.25;

/// A contact as a camera sees it, with the force that it truly carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenContact {
    /// Place, and direction from the object into the finger: of several touches the mean, weighed by what they carry.
    pub contact: Contact,
    /// Whether it is on a clamped part, where a force does not bend the finger.
    pub clamped: bool,
    /// Where, finger frame, deformed, mm.
    pub point: Vector,
    /// True force on the finger, N, finger frame.
    pub force: Vector,
    /// Sum of the normal forces of its touches, N.
    pub normal_n: f64,
    /// Sum of the friction of its touches, positive towards the tip, N.
    pub friction_n: f64,
}

/// Puts touches together to contacts, from base to tip.
pub fn seen_contacts(lattice: &Lattice, touches: &[Touch]) -> Vec<SeenContact> {
    let mut groups: Vec<&[Touch]> = Vec::new();
    let mut rest = touches;
    while let [first, ..] = rest {
        let within_mm = TOGETHER * stretch_mm(lattice.finger(), first.part.place_mm(lattice));
        let mut rods = 0;
        let together = rest.iter().take_while(|touch| {
            rods += usize::from(matches!(touch.part, TouchedPart::Rod(node) if !is_rod(first, node)));
            let other_rod = if matches!(first.part, TouchedPart::Rod(_)) { rods > 0 } else { rods > 1 };
            let apart_mm = touch.part.place_mm(lattice) - first.part.place_mm(lattice);
            touch.clamped == first.clamped && apart_mm <= within_mm && !other_rod
        });
        let (group, others) = rest.split_at(together.count());
        groups.push(group);
        rest = others;
    }
    groups.into_iter().map(|group| seen(lattice, group)).collect()
}

fn is_rod(touch: &Touch, node: NodeId) -> bool {
    touch.part == TouchedPart::Rod(node)
}

/// Length of the stretch of front plate that a place lies on, mm.
fn stretch_mm(finger: &Finger, place_mm: f64) -> f64 {
    let places = finger.plate_places_mm(Plate::Front);
    let stretch = places.windows(2).find(|stretch| place_mm <= stretch[1]).unwrap_or(&places[places.len() - 2..]);
    stretch[1] - stretch[0]
}

fn seen(lattice: &Lattice, group: &[Touch]) -> SeenContact {
    let finger = lattice.finger();
    let rod = group.iter().find_map(|touch| match touch.part {
        TouchedPart::Rod(node) => Some(node),
        TouchedPart::Plate(_) => None,
    });
    let normal_n = |touch: &Touch| touch.force.dot(&touch.normal);
    let carried_n: f64 = group.iter().map(normal_n).sum();
    let carried =
        |what: &dyn Fn(&Touch) -> f64| group.iter().map(|touch| normal_n(touch) * what(touch)).sum::<f64>() / carried_n;
    let place = match rod {
        Some(node) => ContactPlace::Node(node),
        None => ContactPlace::Place(carried(&|touch| touch.part.place_mm(lattice))),
    };
    let normal = group.iter().map(|touch| touch.normal * normal_n(touch)).sum::<Vector>().normalize();
    // Towards the tip, across each touch's own normal.
    let friction_n = |touch: &Touch| touch.force.dot(&Vector::new(-touch.normal.y, touch.normal.x));
    SeenContact {
        contact: Contact { place, angle_deg: angle_deg(finger, normal) },
        clamped: group[0].clamped,
        point: Vector::new(carried(&|touch| touch.point.x), carried(&|touch| touch.point.y)),
        force: group.iter().map(|touch| touch.force).sum(),
        normal_n: carried_n,
        friction_n: group.iter().map(friction_n).sum(),
    }
}

/// Angle of a direction from the undeformed inward normal, positive towards the tip, degrees.
pub fn angle_deg(finger: &Finger, direction: Vector) -> f64 {
    direction.dot(&finger.front_tangent()).atan2(direction.dot(&finger.direction(0.0))).to_degrees()
}
