//! Contacts with an object of known shape: the plate, or the pad on it, touches the object's outline tangentially.
//!
//! Each contact adds two rows to the least-squares problem, below the rows of the markers and the priors. The point of the outline that faces the
//! plate must coincide with the contact, both perpendicular to the plate and along the plate. The rows of a contact with an object determine the
//! contact's position and direction as accurately as the object's pose is known.

use super::marker_motion::Posed;
use super::values::Nuisances;
use crate::Vector;
use crate::finger::PlatePosition;
use crate::measurement::PlateMotion;
use crate::mesh::{Load, LoadError, Mesh};
use crate::sensing::{ContactQuestion, Direction, Lean, Normal, Pad, TouchedObject};
use nalgebra::Point2;

/// Assumed standard deviations of a closed contact, mm: perpendicular to the plate, and along the plate. The assumed standard deviations are far
/// smaller than the error of an object's outline, but not smaller than the error of a mesh.
pub(super) const CLOSED_SD_MM: [f64; 2] = [0.01, 0.03];
/// An object and the contacts that touch it.
#[derive(Debug, Clone)]
pub(super) struct Touching {
    pub object: TouchedObject,
    /// The contacts that touch the object: index, from 0, and the touched surface.
    pub contacts: Vec<(usize, Pad)>,
    /// Motion of the plate at each contact, relative to the scene's finger, while all shared errors are zero. Empty for no motion.
    pub plate_offsets: Vec<PlateMotion>,
}

impl Touching {
    /// The object and its contacts. `None` if no contact touches the object.
    pub fn new(questions: &[ContactQuestion], object: &TouchedObject) -> Option<Touching> {
        let touching = questions.iter().enumerate().filter(|(_, question)| touches_object(question));
        let contacts: Vec<(usize, Pad)> = touching.map(|(i, question)| (i, question.pad.unwrap_or_default())).collect();
        (!contacts.is_empty()).then(|| Touching { object: object.clone(), contacts, plate_offsets: Vec::new() })
    }

    /// Number of rows that the contacts add.
    pub fn row_count(&self) -> usize {
        2 * self.contacts.len()
    }

    /// Violations of the contact conditions by a shape. Each violation is divided by its standard deviation and multiplied by the noise, mm.
    pub fn misses_mm<'t>(
        &'t self,
        mesh: &'t Mesh,
        shape: Posed<'t>,
        marker_noise_mm: f64,
    ) -> impl Iterator<Item = f64> + 't {
        self.contacts.iter().flat_map(move |&(i, pad)| {
            // The contacts have been checked and are on their plates.
            let contact = &shape.contacts[i];
            let s_mm = contact.position_mm(mesh.finger()).unwrap_or(f64::NAN);
            let at = PlatePosition { plate: contact.position.plate(), s_mm };
            let missed = self.missed_mm(mesh, (i, pad), at, shape).unwrap_or([f64::NAN; 2]);
            [0, 1].map(|way| missed[way] / CLOSED_SD_MM[way] * marker_noise_mm)
        })
    }

    /// Sum of the squared violations, mm^2.
    pub fn misfit(&self, mesh: &Mesh, shape: Posed, marker_noise_mm: f64) -> f64 {
        self.misses_mm(mesh, shape, marker_noise_mm).map(|missed_mm| missed_mm * missed_mm).sum()
    }

    /// Motion of the plate at a contact, relative to the scene's finger: errors of the assembly displace the plate, and not only the markers.
    pub fn plate_motion(&self, contact: usize, nuisances: &Nuisances) -> PlateMotion {
        nuisances.shared_plate(contact).and(1.0, self.plate_offsets.get(contact).copied().unwrap_or_default())
    }

    /// Distance between the surface of the plate or `pad` at the position `at` and the point of the outline that faces this position. Returns the gap
    /// and the distance along the plate, mm. The plate moves as at the contact with the index `contact`.
    pub fn missed_mm(
        &self,
        mesh: &Mesh,
        (contact, pad): (usize, Pad),
        at: PlatePosition,
        shape: Posed,
    ) -> Result<[f64; 2], LoadError> {
        let Posed { motion, nuisances, .. } = shape;
        let moved = self.plate_motion(contact, nuisances);
        let turn_rad = mesh.normal_turn(motion, &Load::at_position(at, Vector::zeros()), 0.0)? + moved.turn_rad;
        let turn_deg = turn_rad.to_degrees();
        let [inward, tipward] =
            [0.0, 90.0].map(|deg| nuisances.base.rotation * mesh.finger().direction_on(at.plate, deg + turn_deg));
        let point = nuisances.base * Point2::from(mesh.plate_point(motion, at)? + moved.displacement);
        let apart = point.coords - self.object.point_facing(inward, nuisances.object);
        Ok([apart.dot(&inward) - pad.lever_mm(mesh.finger(), at), apart.dot(&tipward)])
    }
}

/// Whether a contact touches an object of known shape.
pub(super) fn touches_object(question: &ContactQuestion) -> bool {
    matches!(question.direction, Direction::Leaning(Lean { from: Normal::Object, .. }))
}
