//! The force problem: least squares for the forces that bend a finger as measured.
//!
//! The unknowns are blocks ([`Unknown`]): forces, their positions and directions, the pose of the base, the pose of an object, and errors that all
//! markers share. The rows are the markers, the priors ([`Priors`]) and the conditions of contact with an object ([`Touching`]). A [`State`] holds
//! values of the unknowns, the equilibrium for these values, and the problem linearised at this equilibrium. Search, assessment and widening are
//! functions of other files over a problem and its states.

use super::linearised::{Linearised, Seen};
use super::marker_motion::Posed;
use super::priors::Priors;
use super::touching::{Touching, touches_object};
use super::unknowns::Unknown;
use super::values::{Nuisances, Values};
use crate::finger::Plate;
use crate::frame::{FrameLoad, FrameMotion};
use crate::measurement::{Measurement, SharedError};
use crate::mesh::{LoadError, Mesh};
use crate::optimise::Prediction;
use crate::sensing::{
    Contact, ContactQuestion, Direction, Normal, PadForce, SensingError, TouchedObject, check_questions, plate_turn,
};
use crate::statics::{Ladder, Statics};
use crate::{Finger, Kinematics};
use std::sync::Arc;

/// With fewer coordinates than this and hidden markers, minima at far positions may explain a measurement equally well. On a random finger, 16 markers had
/// two sharp minima, of 298 N and 1032 N.
const FEW_COORDINATES: usize = 40;

/// Contacts on a mesh, what is known of them, and the finger's equations.
#[derive(Debug, Clone)]
pub(super) struct ForceProblem<'m> {
    pub mesh: &'m Mesh,
    pub questions: Vec<ContactQuestion>,
    pub object: Option<Touching>,
    /// Loads beside those of the contacts.
    pub further_loads: Vec<FrameLoad>,
    pub unknowns: Arc<[Unknown]>,
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
    pub fn move_by_forces(&mut self, unit_motions: &[FrameMotion]) -> f64 {
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
    let touched = object.map_or(0.0, |object| object.misfit(mesh, shape, priors.marker_noise_mm()));
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
            further_loads: Vec::new(),
            unknowns: Unknown::list(questions, None, &Measurement::empty()).into(),
            shared_errors: Vec::new(),
            priors: Priors::default(),
            statics: Statics::ladder(mesh, Kinematics::Corotational),
        })
    }

    /// This problem with an object that its contacts touch.
    pub fn with_object(self, object: Option<&TouchedObject>) -> ForceProblem<'m> {
        let object = object.and_then(|object| Touching::new(&self.questions, object));
        let unknowns = Unknown::list(&self.questions, object.as_ref().map(|it| &it.object), &Measurement::empty());
        ForceProblem { object, unknowns: unknowns.into(), shared_errors: Vec::new(), ..self }
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
    pub fn expect(&mut self, Seen { measurement, marker_noise_mm }: Seen) -> Result<bool, SensingError> {
        if let Some(i) = self.questions.iter().position(touches_object).filter(|_| self.object.is_none()) {
            return Err(SensingError::NoObject { contact: i + 1 });
        }
        if let Some(touching) = &mut self.object {
            touching.plate_offsets = measurement.plate_offsets().to_vec();
        }
        let object = self.object.as_ref().map(|touching| &touching.object);
        let unknowns = Unknown::list(&self.questions, object, measurement);
        let is_other = unknowns[..] != self.unknowns[..] || self.shared_errors != measurement.shared_errors();
        if is_other {
            self.shared_errors = measurement.shared_errors().to_vec();
            self.unknowns = unknowns.into();
        }
        self.priors = Priors::new(&self.unknowns, &self.questions, object, measurement, marker_noise_mm);
        if !(self.priors.is_empty() && object.is_none()) && marker_noise_mm.is_none() {
            return Err(SensingError::NoiseNotStated);
        }
        Ok(is_other)
    }

    pub fn finger(&self) -> &'m Finger {
        self.mesh.finger()
    }

    /// Number of rows that are no markers but count as measured: priors and conditions of contact with an object. Without noise there are none,
    /// because exact markers outweigh them.
    pub fn known_count(&self) -> usize {
        let of_object = self.object.as_ref().filter(|_| self.priors.marker_noise_mm() > 0.0);
        self.priors.count() + of_object.map_or(0, Touching::row_count)
    }

    /// Writes the rows of the priors at a state.
    pub fn write_prior_rows(&self, state: &mut State) {
        let State { linearised, nuisances, forces_n, .. } = state;
        linearised.prior_rows.clear();
        linearised.prior_rows.extend(self.priors.rows(nuisances, forces_n));
    }

    /// Whether all unknowns are forces, or are measured: positions and directions of measured contacts.
    pub fn is_of_forces(&self) -> bool {
        let is_force = |unknown: &Unknown| matches!(unknown, Unknown::Force(_));
        self.unknowns.iter().all(|unknown| is_force(unknown) || unknown.is_measured(&self.questions))
    }

    /// Whether the normal of a contact is measured.
    pub fn is_normal_measured(&self, contact: usize) -> bool {
        self.questions[contact].is_normal_measured()
    }

    /// Whether loads turn with the deformed plate: directions that follow the plate, or pads under forces whose normal is not measured.
    pub fn loads_follow_plate(&self) -> bool {
        let has_turning_pad = |q: &ContactQuestion| q.pad.is_some() && !q.is_normal_measured();
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

    /// Whether hidden markers may leave the only unknown position weakly determined: few coordinates are measured, and no object
    /// confines it.
    pub fn is_weak(&self, measurement: &Measurement) -> bool {
        let is_alone = self.object.is_none() && self.unplaced().len() == 1;
        let hides_markers = measurement.markers().len() < self.finger().marked_nodes().len();
        is_alone && hides_markers && measurement.coordinate_count() < FEW_COORDINATES
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

    /// Sets the [scale](Unknown::scale) of each unknown.
    pub fn rescale(&self, state: &mut State) {
        for (scale, unknown) in state.linearised.scales.iter_mut().zip(self.unknowns.iter()) {
            *scale = unknown.scale(&self.questions, &state.forces_n, self.finger());
        }
    }

    /// Largest [relative change](Unknown::relative_change) of an unknown by the state's step.
    pub fn relative_change(&self, state: &State) -> f64 {
        let largest_n = state.forces_n.iter().fold(f64::MIN_POSITIVE, |m, f| m.max(f.abs()));
        let length_mm = self.finger().plate_length_mm(Plate::Front);
        let change = |(unknown, x): (&Unknown, &f64)| unknown.relative_change(*x, largest_n, length_mm);
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
        let step = (&self.unknowns[..], &linearised.step[..]);
        Values { forces_n, contacts, nuisances }.advance(step, &self.questions, &self.shared_errors, finger);
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
                    Normal::Object => {
                        let moved = self.object.as_ref().map(|object| object.plate_motion(i, nuisances));
                        let turn_rad = self.mesh.normal_turn(motion, &contact.unit_load(finger), 0.0)?;
                        turn_rad + moved.map_or(0.0, |moved| moved.turn_rad)
                    }
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
        loads.extend_from_slice(&self.further_loads);
        Ok(largest_turn_deg)
    }
}
