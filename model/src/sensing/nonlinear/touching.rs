//! Contacts with an object of known shape: the plate, or the pad on it, touches the object's outline tangentially.
//!
//! Each contact adds two rows to the least-squares problem, below the rows of the markers and the priors. The point of the outline that faces the
//! plate must coincide with the contact, both perpendicular to the plate and along the plate. The rows of a contact with an object determine the
//! contact's position and direction as accurately as the object's pose is known.

use super::search_history::SearchHistory;
use super::{NonlinearEstimator, Posed, SETTLED_ANGLE_DEG, State};
use crate::Vector;
use crate::finger::Plate;
use crate::measurement::Measurement;
use crate::mesh::{Load, LoadError, Mesh};
use crate::sensing::{Contact, ContactQuestion, Direction, Lean, Normal, SensingError, TouchedObject};
use crate::statics::StaticsError;
use nalgebra::Point2;

/// Assumed standard deviations of a closed contact, mm: perpendicular to the plate, and along the plate. The assumed standard deviations are far
/// smaller than the error of an object's outline, but not smaller than the error of a mesh.
const CLOSED_SD_MM: [f64; 2] = [0.01, 0.03];
/// Step of the difference quotients, as a share of each unknown's scale. The differenced quantities are almost linear within such a small step.
const STEP: f64 = 1e-5;
/// Number of times that the loads are updated to the bent shape, which determines their directions and levers.
const FOLLOWED: usize = 3;
/// The iteration that adapts the loads to the shape ends after this number of updates. Each update of the loads removes most of the change that
/// remains.
const SETTLINGS: usize = 12;
/// A gap of more than this number of standard deviations is no contact.
const LARGEST_GAP_SIGMAS: f64 = 6.0;
/// Uncertainty of the plate's shape between markers, as a multiple of the markers' noise.
const OPEN_BETWEEN_MARKERS: f64 = 2.0;
/// Number of points of the plate whose distance from the outline is evaluated.
const PLACES: usize = 400;

/// An object and the contacts that touch it.
#[derive(Debug, Clone)]
pub(super) struct Touching {
    pub object: TouchedObject,
    /// Thickness of the pad, mm.
    pad_mm: f64,
    /// Indices of the contacts that touch the object, from 0.
    contacts: Vec<usize>,
}

impl Touching {
    fn new(questions: &[ContactQuestion], object: &TouchedObject, pad_mm: f64) -> Touching {
        let touches = |(_, question): &(usize, &ContactQuestion)| is_of_object(question);
        Touching {
            object: object.clone(),
            pad_mm,
            contacts: questions.iter().enumerate().filter(touches).map(|(i, _)| i).collect(),
        }
    }

    /// Number of rows that the contacts add.
    pub fn row_count(&self) -> usize {
        2 * self.contacts.len()
    }

    /// Violations of the contact conditions by a shape. Each violation is divided by its standard deviation and multiplied by the noise, mm.
    fn misses_mm<'t>(
        &'t self,
        mesh: &'t Mesh,
        contacts: &'t [Contact],
        shape: Posed<'t>,
        noise_mm: f64,
    ) -> impl Iterator<Item = f64> + 't {
        self.contacts.iter().flat_map(move |&i| {
            // The contacts have been checked and are on the plate.
            let s_mm = contacts[i].position_mm(mesh.finger()).unwrap_or(f64::NAN);
            let missed = self.missed_mm(mesh, s_mm, shape).unwrap_or([f64::NAN; 2]);
            [0, 1].map(|way| missed[way] / CLOSED_SD_MM[way] * noise_mm)
        })
    }

    /// Sum of the squared violations, mm^2.
    pub fn misfit(&self, mesh: &Mesh, contacts: &[Contact], shape: Posed, noise_mm: f64) -> f64 {
        self.misses_mm(mesh, contacts, shape, noise_mm).map(|missed_mm| missed_mm * missed_mm).sum()
    }

    /// Distance between the plate at position `s_mm` and the point of the outline that faces this position. Returns the gap and the distance along
    /// the plate, mm.
    fn missed_mm(&self, mesh: &Mesh, s_mm: f64, shape: Posed) -> Result<[f64; 2], LoadError> {
        let Posed { motion, nuisances, .. } = shape;
        let turn_deg = mesh.normal_turn(motion, &Load::at_position(s_mm, Vector::zeros()), 0.0)?.to_degrees();
        let [inward, tipward] =
            [0.0, 90.0].map(|deg| nuisances.base.rotation * mesh.finger().direction(deg + turn_deg));
        let point = nuisances.base * Point2::from(mesh.front_point(motion, s_mm)?);
        let apart = point.coords - self.object.point_facing(inward, nuisances.object);
        // Distance from the plate's middle line to the surface of plate and pad.
        let reach_mm = 0.5 * mesh.finger().thickness_mm(Plate::Front, s_mm) + self.pad_mm;
        Ok([apart.dot(&inward) - reach_mm, apart.dot(&tipward)])
    }
}

fn is_of_object(question: &ContactQuestion) -> bool {
    matches!(question.direction, Direction::Leaning(Lean { from: Normal::Object, .. }))
}

impl<'m> NonlinearEstimator<'m> {
    /// This estimator with an object of known shape, for contacts whose lean (angle between force and normal) is measured from [`Normal::Object`].
    pub fn with_object(mut self, object: Option<&TouchedObject>) -> NonlinearEstimator<'m> {
        let touches = self.questions.iter().any(is_of_object);
        let touching = |object: &TouchedObject| Touching::new(&self.questions, object, self.pad.thickness_mm);
        self.object = object.filter(|_| touches).map(touching);
        self.list_unknowns(false);
        self
    }

    /// An estimator for the contacts in `questions`, with the same mesh, pad and object.
    pub(super) fn asking(&self, questions: &[ContactQuestion]) -> Result<NonlinearEstimator<'m>, SensingError> {
        let object = self.object.as_ref().map(|touching| &touching.object);
        Ok(NonlinearEstimator::new(self.mesh, questions)?.with_pad(self.pad).with_object(object))
    }

    /// Refuses contacts whose direction refers to an object if no object is given.
    ///
    /// # Errors
    /// [`SensingError::NoObject`] for the first such contact.
    pub(super) fn require_object(&self) -> Result<(), SensingError> {
        match self.questions.iter().position(is_of_object).filter(|_| self.object.is_none()) {
            Some(i) => Err(SensingError::NoObject { contact: i + 1 }),
            None => Ok(()),
        }
    }

    /// Misfit of the measurement, the priors and the contact conditions, mm^2.
    pub(super) fn misfit(&self, state: &State, measurement: &Measurement) -> f64 {
        let touched = match &self.object {
            None => 0.0,
            Some(touching) => {
                let shape = state.posed();
                touching.misfit(self.mesh, &state.contacts, shape, self.priors.noise_mm())
            }
        };
        state.misfit(measurement) + touched
    }

    /// Computes the same derivatives as [`differentiate`](NonlinearEstimator::differentiate), but by first-order differences of states. Here,
    /// directions follow the object, and the differences include the effect of changed directions on the shape.
    ///
    /// # Errors
    /// [`SensingError::Statics`] if the tangent does not belong to an equilibrium.
    pub(super) fn differentiate_by_differences(&mut self, state: &mut State) -> Result<(), SensingError> {
        let Some(touching) = self.object.clone() else { return Ok(()) };
        let noise_mm = self.priors.noise_mm();
        let misses = |state: &State| -> Vec<f64> {
            let shape = state.posed();
            touching.misses_mm(self.mesh, &state.contacts, shape, noise_mm).collect()
        };
        let before = self.followed(state, None)?;
        let before_misses = misses(&before);
        let at_state = misses(state);
        state.linearised.take_misses(at_state, &state.nuisances, &state.forces_n);
        for unknown in 0..self.unknowns.len() {
            let step = STEP * state.linearised.scales[unknown];
            let after = self.followed(state, Some((unknown, step)))?;
            let after_misses = misses(&after);
            let states = [(&before, &before_misses), (&after, &after_misses)]
                .map(|(state, misses)| (state.posed(), misses.as_slice()));
            state.linearised.take_differences(unknown, states, step);
        }
        Ok(())
    }

    /// State after a step of one unknown (index and change). The tangent determines the new shape, and the new shape determines the loads. If `step`
    /// is `None`, no unknown changes.
    fn followed(&mut self, state: &State, step: Option<(usize, f64)>) -> Result<State, SensingError> {
        let none = SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 });
        let mut state = state.clone();
        state.linearised.step.clear();
        state.linearised.step.resize(self.unknowns.len(), 0.0);
        if let Some((unknown, by)) = step {
            state.linearised.step[unknown] = by;
        }
        for _ in 0..FOLLOWED {
            self.advance(&mut state)?;
            self.statics.corrected(&mut state.motion, &state.loads).ok_or(none.clone())?;
            state.linearised.step.fill(0.0);
        }
        Ok(state)
    }

    /// Iterates a state to the equilibrium under loads that follow its shape.
    ///
    /// # Errors
    /// [`SensingError::Statics`] if the finger has no equilibrium under loads that follow its shape.
    pub(super) fn settle(&mut self, state: &mut State) -> Result<(), SensingError> {
        for _ in 0..SETTLINGS {
            let loads = state.loads.clone();
            state.linearised.step.clear();
            state.linearised.step.resize(self.unknowns.len(), 0.0);
            let turn_deg = self.advance(state)?;
            state.motion = self.statics.shifted(&state.motion, &loads, &state.loads)?.motion;
            if turn_deg <= SETTLED_ANGLE_DEG {
                break;
            }
        }
        Ok(())
    }

    /// An estimator for the same contacts without the object. Directions refer to the normal of the plate.
    fn without_object(&self) -> Result<NonlinearEstimator<'m>, SensingError> {
        let plain = |question: &ContactQuestion| match question.direction {
            Direction::Leaning(lean) if lean.from == Normal::Object => {
                let from = Normal::Deformed { over_mm: 0.0 };
                ContactQuestion { direction: Direction::Leaning(Lean { from, ..lean }), ..*question }
            }
            _ => *question,
        };
        let questions: Vec<ContactQuestion> = self.questions.iter().map(plain).collect();
        Ok(NonlinearEstimator::new(self.mesh, &questions)?.with_pad(self.pad))
    }

    /// The estimate from markers alone, as a starting point. `None` if the markers do not identify the unknowns.
    ///
    /// # Errors
    /// [`SensingError::NotTouching`] if the object cannot touch the plate.
    pub(super) fn of_markers_alone(
        &mut self,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Result<Option<State>, SensingError> {
        let mut estimator = self.without_object()?;
        if estimator.estimate(measurement, noise_mm).is_err() {
            return Ok(None);
        }
        let Some(state) = estimator.last.take() else { return Ok(None) };
        self.require_touch(&state, measurement, noise_mm.unwrap_or_default())?;
        self.resumed(state, measurement, noise_mm).map(Some)
    }

    /// The nearest minimum of the problem without the object, as a starting point.
    pub(super) fn searched_without_object(
        &mut self,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        start: super::start::Start,
    ) -> Result<State, SensingError> {
        let mut estimator = self.without_object()?;
        estimator.expect(measurement, noise_mm)?;
        let (mut starts, mut history) = (Vec::new(), SearchHistory::default());
        let found = estimator.searched(measurement, noise_mm, start, &mut starts, &mut history)?;
        let found = found.ok_or(SensingError::NoContact)?;
        self.resumed(found.state, measurement, noise_mm)
    }

    /// Refuses an object that is farther from the plate, or deeper in the plate, than the uncertainty of the object's pose allows.
    fn require_touch(&self, state: &State, measurement: &Measurement, noise_mm: f64) -> Result<(), SensingError> {
        let Some(touching) = &self.object else { return Ok(()) };
        let length_mm = self.finger().plate_length_mm(Plate::Front);
        let shape = state.posed();
        let mut nearest_mm = [f64::INFINITY; 2];
        for i in 1..=PLACES {
            let missed_mm = touching.missed_mm(self.mesh, length_mm * i as f64 / PLACES as f64, shape)?;
            if missed_mm[1].abs() < nearest_mm[1].abs() {
                nearest_mm = missed_mm;
            }
        }
        let [gap_mm, along_mm] = nearest_mm;
        // A distance along the plate counts as zero if it is smaller than the spacing of neighbouring points.
        let beyond_mm = (along_mm.abs() - length_mm / PLACES as f64).max(0.0);
        let gap_mm = gap_mm.hypot(beyond_mm).copysign(gap_mm);
        let object = &touching.object;
        let parts_mm = [
            object.sd_mm,
            object.sd_rad * object.shape.largest_radius_mm(),
            measurement.base().map_or(0.0, |base| base.sd_mm),
            OPEN_BETWEEN_MARKERS * noise_mm,
            CLOSED_SD_MM[0],
        ];
        let sd_mm = parts_mm.into_iter().fold(0.0, f64::hypot);
        match gap_mm.abs() > LARGEST_GAP_SIGMAS * sd_mm {
            true => Err(SensingError::NotTouching { contact: touching.contacts[0] + 1, gap_mm, sd_mm }),
            false => Ok(()),
        }
    }
}
