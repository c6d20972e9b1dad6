//! The force problem: least squares for the forces that bend a finger as measured.
//!
//! The unknowns are blocks ([`Unknown`]): forces, their positions and directions, the pose of the base, the pose of an object, and errors that all
//! markers share. The rows are the markers, the priors ([`Priors`]) and the conditions of contact with an object ([`Touching`]). A [`State`] holds
//! values of the unknowns, the equilibrium for these values, and the problem linearised at this equilibrium. Search, assessment and widening are
//! functions of other files over a problem and its states.

use super::linearised::{Linearised, Posed, Seen};
use super::nuisances::{Nuisances, Priors, leaning_n};
use super::touching::{Touching, touches_object};
use super::unknowns::{BaseMotion, Unknown};
use crate::finger::{Plate, PlatePosition};
use crate::frame::{FrameLoad, FrameMotion};
use crate::measurement::{Measurement, SharedError};
use crate::mesh::{LoadError, Mesh};
use crate::optimise::Prediction;
use crate::sensing::{
    Contact, ContactPosition, ContactQuestion, Direction, Normal, PadForce, SensingError, TouchedObject,
    check_questions, plate_turn,
};
use crate::statics::{Ladder, Statics};
use crate::{Finger, Kinematics};
use nalgebra::{Translation2, UnitComplex};
use std::sync::Arc;

/// A position changes by at most this share of the plate's length in one step.
const LONGEST_MOVE: f64 = 0.2;
/// A position stays at least this share of the plate's length away from the base. Measurements cannot distinguish a contact closer to the base from a
/// contact at the clamp.
const NEAREST_TO_BASE: f64 = 0.01;
/// Scale of a rotation of the base, rad. A rotation of the base by this angle moves the tip about as far as a force of 1 N does.
const TURN_UNIT: f64 = 0.01;

/// Contacts on a mesh, what is known of them, and the finger's equations.
#[derive(Debug, Clone)]
pub(super) struct ForceProblem<'m> {
    pub mesh: &'m Mesh,
    pub questions: Vec<ContactQuestion>,
    pub object: Option<Touching>,
    pub unknowns: Vec<Unknown>,
    /// Errors that all markers of the measurement share.
    pub shared_errors: Vec<SharedError>,
    pub priors: Priors,
    pub statics: Statics<Ladder<'m>>,
}

/// Values of the unknowns, the equilibrium for these values, and the problem linearised at this equilibrium.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub forces_n: Vec<f64>,
    pub contacts: Vec<Contact>,
    pub nuisances: Nuisances,
    /// Rotation of the plate under the pad at each contact towards the tip, rad.
    pub plate_turns_rad: Vec<f64>,
    /// Loads of all contacts in the order of the contacts.
    pub loads: Vec<FrameLoad>,
    pub motion: FrameMotion,
    pub linearised: Linearised,
    /// First-order motion of the mesh per N of each force, from which the first step of a correction follows without factoring the tangent. `None`
    /// unless many corrections start from this state.
    pub unit_motions: Option<Arc<[FrameMotion]>>,
}

impl State {
    /// Shape of the state.
    pub fn posed(&self) -> Posed<'_> {
        let State { forces_n, contacts, nuisances, motion, .. } = self;
        Posed { motion, contacts, forces_n, nuisances }
    }

    /// Shape of the state, and the problem linearised at the state.
    fn split(&mut self) -> (Posed<'_>, &mut Linearised) {
        let State { forces_n, contacts, nuisances, motion, linearised, .. } = self;
        (Posed { motion, contacts, forces_n, nuisances }, linearised)
    }

    /// Force of each contact with its pad.
    pub fn pad_forces<'s>(&'s self, questions: &'s [ContactQuestion]) -> impl Iterator<Item = PadForce> + 's {
        self.pad_forces_under(questions, &self.forces_n)
    }

    /// Force of each contact with its pad, for other forces, N.
    fn pad_forces_under<'s>(
        &'s self,
        questions: &'s [ContactQuestion],
        forces_n: &'s [f64],
    ) -> impl Iterator<Item = PadForce> + 's {
        questions.iter().zip(forces_n).enumerate().map(|(i, (question, force_n))| {
            let lean_deg = self.nuisances.further_leans_deg[i];
            pad_force(question, self.contacts[i], *force_n, lean_deg, self.plate_turns_rad[i])
        })
    }

    /// Loads of all contacts for other forces, N, on a mesh of the same finger.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off its plate.
    pub fn loads_under(
        &self,
        mesh: &Mesh,
        questions: &[ContactQuestion],
        forces_n: &[f64],
    ) -> Result<Vec<FrameLoad>, LoadError> {
        self.pad_forces_under(questions, forces_n).flat_map(|force| force.loads(mesh)).collect()
    }

    /// Moves the shape by the state's step of the forces, to first order. Returns the largest rotation of a node, rad.
    pub fn follow(&mut self, unit_motions: &[FrameMotion]) -> f64 {
        let before = self.motion.rotations.clone();
        for (unit_motion, step_n) in unit_motions.iter().zip(&self.linearised.step) {
            self.motion.add(unit_motion, *step_n);
        }
        let turns = self.motion.rotations.iter().zip(before).map(|(after, before)| (after - before).abs());
        turns.fold(0.0, f64::max)
    }

    /// Weights the markers by their distances from the shape.
    pub fn weigh(&mut self, seen: Seen) {
        let (shape, linearised) = self.split();
        linearised.weigh(shape, seen);
    }

    /// Computes the step for a damping.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    pub fn solve(&mut self, measurement: &Measurement, damping: f64) -> Result<Prediction, SensingError> {
        let (shape, linearised) = self.split();
        linearised.solve(shape, measurement, damping)
    }
}

/// Force of a contact with its pad. `force_n` is the force along the direction or, for a measured direction, along the measured normal, N. The contact's
/// angle includes `lean_deg`, the angle between force and measured normal.
pub(super) fn pad_force(
    question: &ContactQuestion,
    contact: Contact,
    force_n: f64,
    lean_deg: f64,
    plate_turn_rad: f64,
) -> PadForce {
    let share_along = match question.direction {
        Direction::Measured(_) => lean_deg.to_radians().cos(),
        _ => 1.0,
    };
    PadForce { contact, force_n: force_n / share_along, pad: question.pad, plate_turn_rad }
}

/// Misfit of a shape to the priors and to the conditions of contact with an object, mm^2.
pub(super) fn known_misfit(mesh: &Mesh, priors: &Priors, object: Option<&Touching>, shape: Posed) -> f64 {
    let touched = object.map_or(0.0, |object| object.misfit(mesh, shape, priors.noise_mm()));
    priors.misfit(shape.nuisances, shape.forces_n) + touched
}

impl<'m> ForceProblem<'m> {
    /// The problem for contacts on a mesh.
    ///
    /// # Errors
    /// [`SensingError`] if no contact is given, a contact is not on a free part of its plate, or two contacts are equal.
    pub fn new(mesh: &'m Mesh, questions: &[ContactQuestion]) -> Result<ForceProblem<'m>, SensingError> {
        check_questions(mesh.finger(), questions)?;
        Ok(ForceProblem {
            mesh,
            questions: questions.to_vec(),
            object: None,
            unknowns: Unknown::of(questions, false, None, 0),
            shared_errors: Vec::new(),
            priors: Priors::default(),
            statics: Statics::ladder(mesh, Kinematics::Corotational),
        })
    }

    /// This problem with an object that its contacts touch.
    pub fn with_object(self, object: Option<&TouchedObject>) -> ForceProblem<'m> {
        let object = object.and_then(|object| Touching::new(&self.questions, object));
        let unknowns = Unknown::of(&self.questions, false, object.as_ref().map(|it| &it.object), 0);
        ForceProblem { object, unknowns, shared_errors: Vec::new(), ..self }
    }

    /// The problem for other contacts, with the same mesh and object.
    pub fn with_questions(&self, questions: &[ContactQuestion]) -> Result<ForceProblem<'m>, SensingError> {
        let object = self.object.as_ref().map(|touching| &touching.object);
        Ok(ForceProblem::new(self.mesh, questions)?.with_object(object))
    }

    /// Prepares the problem for the uncertain base, the shared errors and the noise of a measurement. Returns whether the unknowns are others than
    /// before, so that earlier states do not fit them.
    ///
    /// # Errors
    /// [`SensingError::NoiseNotStated`] if a prior or an object requires a stated noise, [`SensingError::NoObject`] if a direction requires an
    /// object.
    pub fn expect(&mut self, Seen { measurement, noise_mm }: Seen) -> Result<bool, SensingError> {
        if let Some(i) = self.questions.iter().position(touches_object).filter(|_| self.object.is_none()) {
            return Err(SensingError::NoObject { contact: i + 1 });
        }
        let object = self.object.as_ref().map(|touching| &touching.object);
        let is_base_sought = measurement.base().is_some();
        let has_base = self.unknowns.iter().any(|unknown| matches!(unknown, Unknown::Base(_)));
        let is_other = is_base_sought != has_base || self.shared_errors != measurement.shared_errors();
        if is_other {
            self.shared_errors = measurement.shared_errors().to_vec();
            self.unknowns = Unknown::of(&self.questions, is_base_sought, object, self.shared_errors.len());
        }
        self.priors = Priors::new(&self.unknowns, &self.questions, object, measurement, noise_mm);
        if (self.priors.count() > 0 || object.is_some()) && noise_mm.is_none() {
            return Err(SensingError::NoiseNotStated);
        }
        Ok(is_other)
    }

    pub fn finger(&self) -> &'m Finger {
        self.mesh.finger()
    }

    /// Number of rows that are no markers: priors and conditions of contact with an object.
    pub fn known_count(&self) -> usize {
        self.priors.count() + self.object.as_ref().map_or(0, Touching::row_count)
    }

    /// Whether all unknowns are forces, or are measured: positions and directions of measured contacts.
    pub fn is_of_forces(&self) -> bool {
        self.unknowns.iter().all(|unknown| match *unknown {
            Unknown::Force(_) => true,
            Unknown::Position(i) => self.questions[i].is_position_measured(),
            Unknown::Across(i) => self.is_normal_measured(i),
            Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => false,
        })
    }

    /// Whether the normal of a contact is measured.
    pub fn is_normal_measured(&self, contact: usize) -> bool {
        matches!(self.questions[contact].direction, Direction::Measured(_))
    }

    /// Whether loads turn with the deformed plate: directions that follow the plate, or pads under forces whose normal is not measured.
    pub fn loads_follow_plate(&self) -> bool {
        let has_turning_pad = |q: &ContactQuestion| q.pad.is_some() && !matches!(q.direction, Direction::Measured(_));
        self.follows_plate() || self.questions.iter().any(has_turning_pad)
    }

    /// Whether a direction is a [`Direction::Leaning`], which may follow the deformed plate.
    pub fn follows_plate(&self) -> bool {
        self.questions.iter().any(|question| matches!(question.direction, Direction::Leaning(_)))
    }

    /// Indices of the contacts whose position is unknown.
    pub fn unplaced(&self) -> Vec<usize> {
        (0..self.questions.len()).filter(|&i| self.questions[i].position.is_none()).collect()
    }

    /// Order of the contacts in which contacts with equal questions and unknown positions are sorted by position. Without this order, the same result with two
    /// contacts exchanged would count as another result.
    pub fn order(&self, contacts: &[Contact]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..contacts.len()).collect();
        let at_mm = |i: usize| contacts[i].position_mm(self.finger()).unwrap_or(f64::NAN);
        let unplaced = self.unplaced();
        for (k, &i) in unplaced.iter().enumerate() {
            for &j in &unplaced[k + 1..] {
                if self.questions[i] == self.questions[j] && at_mm(order[j]) < at_mm(order[i]) {
                    order.swap(i, j);
                }
            }
        }
        order
    }

    /// Misfit of a state, mm^2: sum of the squared rows of markers, priors and contact conditions.
    pub fn misfit(&self, state: &State, measurement: &Measurement) -> f64 {
        self.misfit_of(state.posed(), &state.linearised, measurement)
    }

    /// Misfit of a shape, mm^2, with the robust weights of `weighted`, which may belong to another shape.
    pub fn misfit_of(&self, shape: Posed, weighted: &Linearised, measurement: &Measurement) -> f64 {
        weighted.misfit(shape, measurement) + known_misfit(self.mesh, &self.priors, self.object.as_ref(), shape)
    }

    /// Sets the scale of each unknown: 1 N for forces, [`TURN_UNIT`] for rotations, 1 mm for translations, and one standard deviation for errors that
    /// all markers share. The scale of a position is a shift of the contact that moves the finger about as far as a force of 1 N does, or the standard
    /// deviation of a measured position. The scale of a force across a measured normal is its standard deviation before the measurement, so that small
    /// forces and accurate normals remain identifiable.
    pub fn rescale(&self, state: &mut State) {
        let largest = state.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        for (scale, unknown) in state.linearised.scales.iter_mut().zip(&self.unknowns) {
            *scale = match *unknown {
                Unknown::Base(BaseMotion::Turn) | Unknown::Object(BaseMotion::Turn) => TURN_UNIT,
                Unknown::Across(i) => match self.questions[i].direction {
                    Direction::Measured(normal) => {
                        leaning_n(state.forces_n[i]).abs() * normal.tangent_sd(self.questions.len())
                    }
                    _ => 1.0,
                },
                Unknown::Force(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => 1.0,
                Unknown::Position(i) if self.questions[i].is_position_measured() => self.questions[i].position_sd_mm,
                Unknown::Position(i) => {
                    let force = state.forces_n[i].abs().max(1e-3 * largest).max(f64::MIN_POSITIVE);
                    0.1 * self.finger().plate_length_mm(Plate::Front) / force
                }
            };
        }
    }

    /// Largest relative change of an unknown by the state's step. Changes of forces are relative to the largest force, and changes of positions and
    /// translations to the plate's length. Changes of rotations are in rad.
    pub fn relative_change(&self, state: &State) -> f64 {
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
    pub fn advance(&self, state: &mut State) -> Result<f64, LoadError> {
        let finger = self.finger();
        let State { forces_n, contacts, nuisances, plate_turns_rad, loads, motion, linearised, .. } = state;
        for (unknown, &x) in self.unknowns.iter().zip(&linearised.step) {
            match *unknown {
                Unknown::Force(i) => forces_n[i] += x,
                // Forces are the first unknowns, so the force along the direction has already been updated.
                Unknown::Across(i) => {
                    let turned_deg = x.atan2(forces_n[i]).to_degrees();
                    match self.questions[i].direction {
                        // The force across a measured normal is the product of the force along it and of the tangent. Its derivative with respect to
                        // the tangent is the force before the step.
                        Direction::Measured(_) => {
                            let tangent = nuisances.tangent(i) + x / leaning_n(forces_n[i] - linearised.step[i]);
                            nuisances.further_leans_deg[i] = tangent.atan().to_degrees();
                        }
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
                    if let ContactPosition::At(PlatePosition { plate, s_mm }) = &mut contacts[i].position {
                        let length = finger.plate_length_mm(*plate);
                        let x = x.clamp(-LONGEST_MOVE * length, LONGEST_MOVE * length);
                        let before_mm = *s_mm;
                        *s_mm = (before_mm + x).clamp(before_mm.min(NEAREST_TO_BASE * length), length);
                        nuisances.shifts_mm[i] += *s_mm - before_mm;
                    }
                }
            }
        }
        let mut largest_turn_deg = 0.0_f64;
        loads.clear();
        for (i, (contact, question)) in contacts.iter_mut().zip(&self.questions).enumerate() {
            // A known or measured direction refers to the measured pose of the base.
            if let Some(stated_deg) = question.direction.stated_deg() {
                let lean_deg = nuisances.further_leans_deg[i];
                contact.angle_deg = stated_deg + lean_deg - nuisances.base_turn_deg(contact.position.plate());
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
            let turn_rad = match question.direction {
                Direction::Measured(_) => (contact.angle_deg - nuisances.further_leans_deg[i]).to_radians(),
                _ => plate_turn(question.pad, self.mesh, contact, motion)?,
            };
            largest_turn_deg = largest_turn_deg.max((turn_rad - plate_turns_rad[i]).abs().to_degrees());
            plate_turns_rad[i] = turn_rad;
            let force = pad_force(question, *contact, forces_n[i], nuisances.further_leans_deg[i], turn_rad);
            for load in force.loads(self.mesh) {
                loads.push(load?);
            }
        }
        Ok(largest_turn_deg)
    }
}
