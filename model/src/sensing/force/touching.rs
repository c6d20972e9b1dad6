//! Contacts with an object of known shape: the plate, or the pad on it, touches the object's outline tangentially.
//!
//! Each contact adds two rows to the least-squares problem, below the rows of the markers and the priors. The point of the outline that faces the
//! plate must coincide with the contact, both perpendicular to the plate and along the plate. The rows of a contact with an object determine the
//! contact's position and direction as accurately as the object's pose is known.

use super::marker_motion::Posed;
use crate::Vector;
use crate::finger::PlatePosition;
use crate::mesh::{Load, LoadError, Mesh};
use crate::sensing::{ContactQuestion, Direction, Lean, Normal, TouchedObject};
use nalgebra::Point2;

/// Assumed standard deviations of a closed contact, mm: perpendicular to the plate, and along the plate. The assumed standard deviations are far
/// smaller than the error of an object's outline, but not smaller than the error of a mesh.
pub(super) const CLOSED_SD_MM: [f64; 2] = [0.01, 0.03];
/// An object and the contacts that touch it.
#[derive(Debug, Clone)]
pub(super) struct Touching {
    pub object: TouchedObject,
    /// The contacts that touch the object: index, from 0, and thickness of the pad, mm.
    pub contacts: Vec<(usize, f64)>,
}

impl Touching {
    /// The object and its contacts. `None` if no contact touches the object.
    pub fn new(questions: &[ContactQuestion], object: &TouchedObject) -> Option<Touching> {
        let touching = questions.iter().enumerate().filter(|(_, question)| touches_object(question));
        let contacts: Vec<(usize, f64)> = touching.map(|(i, question)| (i, question.pad.thickness_mm)).collect();
        (!contacts.is_empty()).then(|| Touching { object: object.clone(), contacts })
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
        self.contacts.iter().flat_map(move |&(i, pad_mm)| {
            // The contacts have been checked and are on their plates.
            let contact = &shape.contacts[i];
            let s_mm = contact.position_mm(mesh.finger()).unwrap_or(f64::NAN);
            let at = PlatePosition { plate: contact.position.plate(), s_mm };
            let missed = self.missed_mm(mesh, (at, pad_mm), shape).unwrap_or([f64::NAN; 2]);
            [0, 1].map(|way| missed[way] / CLOSED_SD_MM[way] * marker_noise_mm)
        })
    }

    /// Sum of the squared violations, mm^2.
    pub fn misfit(&self, mesh: &Mesh, shape: Posed, marker_noise_mm: f64) -> f64 {
        self.misses_mm(mesh, shape, marker_noise_mm).map(|missed_mm| missed_mm * missed_mm).sum()
    }

    /// Distance between the plate at the position `at`, with a pad of thickness `pad_mm`, and the point of the outline that faces this position. Returns
    /// the gap and the distance along the plate, mm.
    pub fn missed_mm(
        &self,
        mesh: &Mesh,
        (at, pad_mm): (PlatePosition, f64),
        shape: Posed,
    ) -> Result<[f64; 2], LoadError> {
        let Posed { motion, nuisances, .. } = shape;
        let turn_deg = mesh.normal_turn(motion, &Load::at_position(at, Vector::zeros()), 0.0)?.to_degrees();
        let [inward, tipward] =
            [0.0, 90.0].map(|deg| nuisances.base.rotation * mesh.finger().direction_on(at.plate, deg + turn_deg));
        let point = nuisances.base * Point2::from(mesh.plate_point(motion, at)?);
        let apart = point.coords - self.object.point_facing(inward, nuisances.object);
        // Distance from the plate's middle line to the surface of plate and pad.
        let reach_mm = 0.5 * mesh.finger().thickness_mm(at.plate, at.s_mm) + pad_mm;
        Ok([apart.dot(&inward) - reach_mm, apart.dot(&tipward)])
    }
}

/// Whether a contact touches an object of known shape.
pub(super) fn touches_object(question: &ContactQuestion) -> bool {
    matches!(question.direction, Direction::Leaning(Lean { from: Normal::Object, .. }))
}
