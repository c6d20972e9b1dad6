//! List of the unknowns: forces, positions, directions, the base, the object, and errors that all markers share.

use super::{NonlinearEstimator, State};
use crate::finger::Plate;
use crate::mesh::LoadError;
use crate::sensing::{ContactPosition, ContactQuestion, Direction, Normal, TouchedObject};
use nalgebra::{Translation2, UnitComplex};

/// A position changes by at most this share of the plate's length in one step.
const LONGEST_MOVE: f64 = 0.2;
/// A position stays at least this share of the plate's length away from the base. Measurements cannot distinguish a contact closer to the base from a
/// contact at the clamp.
const NEAREST_TO_BASE: f64 = 0.01;
/// Scale of a rotation of the base, rad. A rotation of the base by this angle moves the tip about as far as a force of 1 N does.
const TURN_UNIT: f64 = 0.01;

/// One unknown. A number in a variant is the index of the contact or of the shared error, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unknown {
    /// Force along the contact's direction, N.
    Force(usize),
    /// Position along the front plate, mm.
    Position(usize),
    /// Component of a force across the force's current direction, N. This component changes the direction.
    Across(usize),
    /// Motion of the base from its measured pose.
    Base(BaseMotion),
    /// Motion of the object from its stated pose. The object rotates about the origin of its outline.
    Object(BaseMotion),
    /// Error that all markers share, in units of its standard deviation.
    Shared(usize),
}

/// A motion of a base or an object in the finger frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum BaseMotion {
    /// Translation along x, mm.
    X,
    /// Translation along y, mm.
    Y,
    /// Rotation about the origin, rad.
    Turn,
}

impl Unknown {
    /// All unknowns: those of the contacts in `questions`, of an uncertain base and of an object, and `shared_errors` errors that all markers share.
    pub(super) fn of(
        questions: &[ContactQuestion],
        is_base_sought: bool,
        object: Option<&TouchedObject>,
        shared_errors: usize,
    ) -> Vec<Unknown> {
        let is_sought = |question: &ContactQuestion| match question.direction {
            Direction::Auto => true,
            Direction::Leaning(lean) => lean.sd_deg > 0.0,
            Direction::Angle(_) => false,
        };
        let forces = (0..questions.len()).map(Unknown::Force);
        let positions = questions.iter().enumerate().filter(|(_, q)| q.position.is_none());
        let angles = questions.iter().enumerate().filter(|(_, q)| is_sought(q));
        let base = [BaseMotion::X, BaseMotion::Y, BaseMotion::Turn].into_iter().filter(|_| is_base_sought);
        let object = [BaseMotion::X, BaseMotion::Y, BaseMotion::Turn].into_iter().filter(|way| {
            object.is_some_and(|object| if *way == BaseMotion::Turn { object.may_turn() } else { object.sd_mm > 0.0 })
        });
        forces
            .chain(positions.map(|(i, _)| Unknown::Position(i)))
            .chain(angles.map(|(i, _)| Unknown::Across(i)))
            .chain(base.map(Unknown::Base))
            .chain(object.map(Unknown::Object))
            .chain((0..shared_errors).map(Unknown::Shared))
            .collect()
    }

    /// Index of the contact to which the unknown belongs, if any.
    pub(super) fn contact(self) -> Option<usize> {
        match self {
            Unknown::Force(i) | Unknown::Position(i) | Unknown::Across(i) => Some(i),
            Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => None,
        }
    }
}

impl NonlinearEstimator<'_> {
    /// Sets the scale of each unknown: 1 N for forces, [`TURN_UNIT`] for rotations, 1 mm for translations, and one standard deviation for errors that
    /// all markers share. The scale of a position is a shift of the contact that moves the finger about as far as a force of 1 N does.
    pub(super) fn rescale(&self, state: &mut State) {
        let largest = state.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        for (scale, unknown) in state.linearised.scales.iter_mut().zip(&self.unknowns) {
            *scale = match *unknown {
                Unknown::Base(BaseMotion::Turn) | Unknown::Object(BaseMotion::Turn) => TURN_UNIT,
                Unknown::Force(_) | Unknown::Across(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => {
                    1.0
                }
                Unknown::Position(i) => {
                    let force = state.forces_n[i].abs().max(1e-3 * largest).max(f64::MIN_POSITIVE);
                    0.1 * self.finger().plate_length_mm(Plate::Front) / force
                }
            };
        }
    }

    /// Largest relative change of an unknown by the state's step. Changes of forces are relative to the largest force, and changes of positions and
    /// translations to the plate's length. Changes of rotations are in rad.
    pub(super) fn relative_change(&self, state: &State) -> f64 {
        let largest = state.forces_n.iter().fold(f64::MIN_POSITIVE, |m, f| m.max(f.abs()));
        let length = self.finger().plate_length_mm(Plate::Front);
        let change = |(unknown, x): (&Unknown, &f64)| match unknown {
            Unknown::Force(_) | Unknown::Across(_) => x.abs() / largest,
            Unknown::Base(BaseMotion::Turn) | Unknown::Object(BaseMotion::Turn) => x.abs(),
            // One standard deviation of a shared error moves markers by some tenths of a millimetre.
            Unknown::Position(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => x.abs() / length,
        };
        self.unknowns.iter().zip(&state.linearised.step).map(change).fold(0.0, f64::max)
    }

    /// Applies the state's step to forces, contacts and loads, but leaves the state's displacements and rotations unchanged. Returns the largest turn
    /// of a direction that follows the deformed plate, degrees.
    ///
    /// # Errors
    /// [`LoadError`] if a position is not on the plate, which the limits of positions prevent.
    pub(super) fn advance(&self, state: &mut State) -> Result<f64, LoadError> {
        let finger = self.finger();
        let State { forces_n, contacts, nuisances, plate_turns_rad, loads, motion, linearised } = state;
        for (unknown, &x) in self.unknowns.iter().zip(&linearised.step) {
            match *unknown {
                Unknown::Force(i) => forces_n[i] += x,
                // Forces are the first unknowns, so the force along the direction has already been updated.
                Unknown::Across(i) => {
                    let turned_deg = x.atan2(forces_n[i]).to_degrees();
                    match self.questions[i].direction {
                        // A lean (angle between force and normal) is small, so a force keeps its sign.
                        Direction::Leaning(_) => {
                            nuisances.further_leans_deg[i] += (x / forces_n[i]).atan().to_degrees();
                            forces_n[i] = forces_n[i].signum() * forces_n[i].hypot(x);
                        }
                        _ => {
                            contacts[i].angle_deg += turned_deg;
                            forces_n[i] = forces_n[i].hypot(x);
                        }
                    }
                }
                Unknown::Base(BaseMotion::X) => nuisances.base.append_translation_mut(&Translation2::new(x, 0.0)),
                Unknown::Base(BaseMotion::Y) => nuisances.base.append_translation_mut(&Translation2::new(0.0, x)),
                Unknown::Base(BaseMotion::Turn) => nuisances.base.append_rotation_mut(&UnitComplex::new(x)),
                Unknown::Object(way) => nuisances.object[way as usize] += x,
                Unknown::Shared(k) => nuisances.share(k, &self.shared_errors[k], x),
                Unknown::Position(i) => {
                    if let ContactPosition::At(s_mm) = &mut contacts[i].position {
                        let length = finger.plate_length_mm(Plate::Front);
                        let x = x.clamp(-LONGEST_MOVE * length, LONGEST_MOVE * length);
                        *s_mm = (*s_mm + x).clamp(NEAREST_TO_BASE * length, length);
                    }
                }
            }
        }
        let mut largest_turn_deg = 0.0_f64;
        for (i, (contact, question)) in contacts.iter_mut().zip(&self.questions).enumerate() {
            // A known direction refers to the measured pose of the base.
            if let Direction::Angle(angle_deg) = question.direction {
                contact.angle_deg = angle_deg - nuisances.base.rotation.angle().to_degrees();
            }
            if let Direction::Leaning(lean) = question.direction {
                let turned = match lean.from {
                    Normal::Deformed { over_mm } => {
                        self.mesh.normal_turn(motion, &contact.unit_load(finger), over_mm)?
                    }
                    // A plate is tangential to an outline that it touches.
                    Normal::Object => self.mesh.normal_turn(motion, &contact.unit_load(finger), 0.0)?,
                    Normal::Undeformed => 0.0,
                };
                let angle_deg = turned.to_degrees() + lean.mean_deg(forces_n[i]) + nuisances.further_leans_deg[i];
                largest_turn_deg = largest_turn_deg.max((angle_deg - contact.angle_deg).abs());
                contact.angle_deg = angle_deg;
            }
            let turn_rad = self.pad.plate_turn(self.mesh, contact, motion)?;
            largest_turn_deg = largest_turn_deg.max((turn_rad - plate_turns_rad[i]).abs().to_degrees());
            plate_turns_rad[i] = turn_rad;
            let count = self.pad.load_count();
            let of_contact = self.pad.loads(self.mesh, contact, forces_n[i], turn_rad);
            for (load, found) in loads[i * count..].iter_mut().zip(of_contact) {
                *load = found?;
            }
        }
        Ok(largest_turn_deg)
    }
}
