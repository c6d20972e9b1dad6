//! Sensing with the co-rotational finger: Gauss-Newton on forces, positions and directions.
//!
//! An estimate starts from least squares on the linear finger ([`start`]) or from the last estimate. Near the minimum of the difference between
//! measured and computed shape ([`linearised`]), forces and shape are corrected together ([`simultaneous`]). Far from the minimum, every step ends at
//! an equilibrium ([`search`]). Each result is tested before it is returned ([`judgement`]).

mod discretisation;
mod follow;
mod judgement;
mod leaning;
mod linear_range;
mod linearised;
mod minima;
mod nuisances;
mod profile;
mod refine;
mod scan;
mod search;
mod search_history;
mod simultaneous;
mod start;
mod touching;
mod unknowns;

pub use discretisation::Discretisation;
pub(crate) use judgement::LARGEST_POSITION_SIGMA;
pub(crate) use leaning::{COUNTS, REACH};
pub(crate) use linear_range::{LARGEST_DEPARTURE, WELL_KNOWN};
pub use refine::{Refinement, sense_refining};

use super::{
    Contact, ContactQuestion, Estimate, ModelError, Pad, SensingError, UNEXPLAINED_SHARE, UNEXPLAINED_SIGMAS, Warning,
    check_questions,
};
use crate::frame::{FrameLoad, FrameMotion};
use crate::measurement::{Measurement, SharedError};
use crate::mesh::Mesh;
use crate::optimise::Prediction;
use crate::statics::{Equilibrium, Ladder, Statics, StaticsError};
use crate::{Finger, Kinematics};
use leaning::FoundLean;
use linearised::{Linearised, Posed};
use minima::{MANY_COORDINATES, Minima};
use nalgebra::DMatrix;
use nuisances::{Nuisances, Priors};
use scan::Scan;
use touching::Touching;
use unknowns::Unknown;

/// A direction that follows the deformed plate has settled if a step turns the direction by at most this angle, degrees. The corresponding change of
/// a force is 1e-6 of the force.
const SETTLED_ANGLE_DEG: f64 = 1e-4;

/// Largest residual that noise and model error explain, mm, root mean square over the coordinates. `noise_mm` is the standard deviation of a coordinate,
/// `moved_rms_mm` the root mean square displacement, both mm.
fn largest_explained_rms_mm(noise_mm: f64, moved_rms_mm: f64) -> f64 {
    f64::max(UNEXPLAINED_SIGMAS * noise_mm, UNEXPLAINED_SHARE * moved_rms_mm)
}

/// Estimated forces with the positions and directions of their contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearEstimate {
    /// Forces with their standard deviations, noise and residual.
    pub forces: Estimate,
    /// Covariance of the forces, N^2, in the order of the contacts. The covariance includes the uncertainty of estimated positions and directions.
    pub covariance_n2: DMatrix<f64>,
    /// Position and direction of each contact, given or estimated.
    pub contacts: Vec<Contact>,
    /// Number of Gauss-Newton steps.
    pub steps: usize,
    /// Estimated errors that all markers share, each in units of its standard deviation.
    pub shared_errors: Vec<f64>,
    /// Estimated leans (angles between force and normal).
    leans: Vec<FoundLean>,
}

impl NonlinearEstimate {
    /// Adds an error of the model, N, to the standard deviations and the covariance.
    fn add_model_error(&mut self, error_n: Vec<f64>, warning: fn(ModelError) -> Warning) {
        let error = nalgebra::DVector::from_column_slice(&error_n);
        self.covariance_n2 += &error * error.transpose();
        self.forces.add_model_error(error_n, warning);
    }
}

/// Forces and contacts near the result of a measurement, from the previous frame or from a coarser mesh.
#[derive(Debug, Clone, Copy)]
pub struct NearForces<'n> {
    /// Position and direction of each contact.
    pub contacts: &'n [Contact],
    /// Force of each contact along its direction, N.
    pub forces_n: &'n [f64],
    /// Shape of the mesh near the equilibrium under these forces; `None` to follow the equilibrium from rest.
    pub shape: Option<&'n FrameMotion>,
}

/// Estimates forces with the co-rotational finger on one mesh. Each estimate after the first starts from the previous estimate, which suits a stream
/// of camera frames. For unrelated measurements, call [`reset`](NonlinearEstimator::reset) before each measurement. Use one clone per thread.
///
/// # Requirements
/// Requires at least as many measured coordinates as unknowns. The unknowns are one force per contact, and each unknown position or direction. The
/// ratio of the largest to the smallest singular value of the derivatives must be at most [`LARGEST_SPAN`](super::LARGEST_SPAN).
///
/// # Reference
/// For measured displacements u, the Levenberg-Marquardt method minimises |W (u - u(f, s, angle))|^2 (Nocedal and Wright, Numerical Optimization,
/// sec. 10.3). The function u(f, s, angle) gives the displacements of the co-rotational finger in equilibrium, with derivatives from the factored
/// tangent. Outlying markers are down-weighted (iteratively reweighted least squares).
#[derive(Debug, Clone)]
pub struct NonlinearEstimator<'m> {
    mesh: &'m Mesh,
    questions: Vec<ContactQuestion>,
    pad: Pad,
    object: Option<Touching>,
    unknowns: Vec<Unknown>,
    /// Errors that all markers of the measurement share.
    shared_errors: Vec<SharedError>,
    priors: Priors,
    statics: Statics<Ladder<'m>>,
    last: Option<State>,
    /// The held state, from which estimates start after a [`reset`](NonlinearEstimator::reset).
    held: Option<State>,
    /// Whether the minimum near the last estimate was chosen among all minima on a coarser mesh.
    is_chosen: bool,
    /// Scanned equilibria of the finger under forces at the contacts. The outer option is `None` before the scan. The inner option is `None` if a
    /// scan is impossible for the contacts.
    scan: Option<Option<Scan>>,
}

/// Values of the unknowns, the equilibrium for these values, and the problem linearised at this equilibrium.
#[derive(Debug, Clone)]
struct State {
    forces_n: Vec<f64>,
    contacts: Vec<Contact>,
    nuisances: Nuisances,
    /// Rotation of the plate under the pad at each contact, rad.
    plate_turns_rad: Vec<f64>,
    /// Loads of all contacts in the order of the contacts. Each contact has `Pad::load_count` loads.
    loads: Vec<FrameLoad>,
    motion: FrameMotion,
    linearised: Linearised,
}

impl State {
    /// Shape of the state.
    fn posed(&self) -> Posed<'_> {
        Posed { motion: &self.motion, forces_n: &self.forces_n, nuisances: &self.nuisances }
    }

    /// Shape of the state, and the problem linearised at the state.
    fn split(&mut self) -> (Posed<'_>, &mut Linearised) {
        let shape = Posed { motion: &self.motion, forces_n: &self.forces_n, nuisances: &self.nuisances };
        (shape, &mut self.linearised)
    }

    /// Weights the markers by their distances from the shape.
    fn weigh(&mut self, measurement: &Measurement, noise_mm: Option<f64>) {
        let (shape, linearised) = self.split();
        linearised.weigh(shape, measurement, noise_mm);
    }

    /// Computes the step for a damping.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    fn solve(&mut self, measurement: &Measurement, damping: f64) -> Result<Prediction, SensingError> {
        let (shape, linearised) = self.split();
        linearised.solve(shape, measurement, damping)
    }

    /// Sum of the squared weighted residuals of the measurement and the priors, mm^2.
    fn misfit(&self, measurement: &Measurement) -> f64 {
        self.linearised.misfit(self.posed(), measurement)
    }
}

/// A minimum and the number of steps to this minimum. If `near` is `true`, the search started near the minimum, or every step was complete and as
/// good as predicted. A minimum with `near` counts as locally unique. If `near` is `false`, there may be further minima.
struct Found {
    state: State,
    steps: usize,
    near: bool,
}

impl<'m> NonlinearEstimator<'m> {
    /// Prepares the estimator for contacts on a mesh.
    ///
    /// # Errors
    /// [`SensingError`] if no contact is given, a contact is not on the free front plate, or two contacts are equal.
    pub fn new(mesh: &'m Mesh, questions: &[ContactQuestion]) -> Result<NonlinearEstimator<'m>, SensingError> {
        check_questions(mesh.finger(), questions)?;
        Ok(NonlinearEstimator {
            mesh,
            questions: questions.to_vec(),
            pad: Pad::default(),
            object: None,
            unknowns: Unknown::of(questions, false, None, 0),
            shared_errors: Vec::new(),
            priors: Priors::default(),
            statics: Statics::ladder(mesh, Kinematics::Corotational),
            last: None,
            held: None,
            is_chosen: false,
            scan: None,
        })
    }

    /// This estimator with a pad between objects and the plate. Set the pad before the object ([`with_object`](NonlinearEstimator::with_object)).
    pub fn with_pad(mut self, pad: Pad) -> NonlinearEstimator<'m> {
        self.pad = pad;
        self.scan = None;
        self.forget();
        self
    }

    /// Forgets the last estimate. The next estimate starts from the held estimate or, without one, from least squares.
    pub fn reset(&mut self) {
        self.last.clone_from(&self.held);
    }

    /// Holds the last estimate: estimates after a [`reset`](NonlinearEstimator::reset) start from the held estimate. Suits measurements that differ
    /// only by noise.
    pub fn hold(&mut self) {
        self.held.clone_from(&self.last);
    }

    /// Holds the equilibrium under known forces, N: estimates after a [`reset`](NonlinearEstimator::reset) start from this equilibrium. The
    /// computation of error bounds at known forces uses this method. Holds nothing if positions or directions are unknown, or if the finger has no
    /// equilibrium under the forces.
    pub fn hold_at(&mut self, forces_n: &[f64]) {
        let before = self.held.take();
        self.forget();
        self.held = self.state_at(forces_n, before);
    }

    /// Estimates the forces like [`estimate`](NonlinearEstimator::estimate), but the search starts from `near`: forces and contacts near the result.
    /// If no minimum near the forces of `near` explains the measurement, the search of `estimate` follows. With so few markers that another minimum
    /// may explain the measurement, only the search of `estimate` runs. If `near` was chosen among all minima on a coarser mesh (`is_chosen`), only
    /// the nearest minimum is sought.
    ///
    /// # Errors
    /// [`SensingError`] as for `estimate`.
    pub fn estimate_near(
        &mut self,
        near: NearForces,
        is_chosen: bool,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Result<NonlinearEstimate, SensingError> {
        self.estimate_from(None, near, is_chosen, measurement, noise_mm)
    }

    /// Estimates the forces like [`estimate_near`](NonlinearEstimator::estimate_near). If a minimum is near the state `kept`, an earlier estimate on
    /// this mesh with the same contacts, the search starts from `kept`. Otherwise the search starts from the equilibrium under the forces of `near`.
    fn estimate_from(
        &mut self,
        kept: Option<State>,
        near: NearForces,
        is_chosen: bool,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Result<NonlinearEstimate, SensingError> {
        self.expect(measurement, noise_mm)?;
        self.forget();
        let many = MANY_COORDINATES[usize::from(self.questions.len() > 1)];
        let is_unique = is_chosen || measurement.coordinate_count() >= many;
        if is_unique && self.object.is_none() && near.contacts.len() == self.questions.len() {
            let at_minimum = kept.and_then(|state| self.at_minimum(state, measurement, noise_mm));
            let at_shape = at_minimum.or_else(|| self.state_near(near));
            self.last = at_shape.or_else(|| self.state_under(near.contacts, near.forces_n, None));
        }
        self.is_chosen = is_chosen && self.last.is_some();
        self.estimate(measurement, noise_mm)
    }

    /// The minimum near a state of an earlier estimate, so near that the rest is negligible compared with the noise. [`estimate`](Self::estimate) then
    /// corrects forces and contacts further if needed. `None` if there is no minimum, or if the state has other unknowns.
    fn at_minimum(&mut self, mut state: State, measurement: &Measurement, noise_mm: Option<f64>) -> Option<State> {
        (state.linearised.scales.len() == self.unknowns.len()).then_some(())?;
        state.linearised.priors.clone_from(&self.priors);
        self.correct_below_noise(&mut state, measurement, noise_mm)?;
        Some(state)
    }

    /// State under known forces, N, followed from the state `from`, or from rest if `from` is `None`. `None` if no equilibrium is found, a position
    /// or direction is unknown, or the estimator has an object.
    fn state_at(&mut self, forces_n: &[f64], from: Option<State>) -> Option<State> {
        self.object.is_none().then_some(())?;
        let contacts: Vec<Contact> = self.questions.iter().map(ContactQuestion::known).collect::<Option<_>>()?;
        let near = from.and_then(|from| self.state_under(&contacts, forces_n, Some(&from)));
        near.or_else(|| self.state_under(&contacts, forces_n, None))
    }

    /// State under forces, N, at contacts, followed from the state `from`, or from rest if `from` is `None`. `None` if no equilibrium is found.
    fn state_under(&mut self, contacts: &[Contact], forces_n: &[f64], from: Option<&State>) -> Option<State> {
        self.state_found(contacts, forces_n, |statics, loads| match from {
            Some(from) => statics.tried(&from.motion, [&from.loads, loads], 1, |_, _| true),
            None => statics.equilibrium(loads),
        })
    }

    /// State under the forces of `near`, found from its shape. `None` without a shape, or if no equilibrium is found.
    fn state_near(&mut self, near: NearForces) -> Option<State> {
        let shape = near.shape?;
        let found = |statics: &mut Statics<Ladder<'m>>, loads: &[FrameLoad]| {
            statics.tried(shape, [loads, loads], 1, |_, _| true)
        };
        self.state_found(near.contacts, near.forces_n, found)
    }

    fn state_found(
        &mut self,
        contacts: &[Contact],
        forces_n: &[f64],
        find: impl FnOnce(&mut Statics<Ladder<'m>>, &[FrameLoad]) -> Result<Equilibrium, StaticsError>,
    ) -> Option<State> {
        let of_contacts = contacts.iter().zip(forces_n).flat_map(|(c, f)| self.pad.loads(self.mesh, c, *f, 0.0));
        let loads = of_contacts.collect::<Result<Vec<_>, _>>().ok()?;
        let equilibrium = find(&mut self.statics, &loads);
        let motion = equilibrium.ok()?.motion;
        let nuisances = Nuisances::expected(contacts.len(), &self.shared_errors);
        let linearised = Linearised::new(self.mesh, &self.unknowns, self.priors.clone());
        let (forces_n, plate_turns_rad) = (forces_n.to_vec(), vec![0.0; contacts.len()]);
        let contacts = contacts.to_vec();
        let mut state = State { forces_n, contacts, nuisances, plate_turns_rad, loads, motion, linearised };
        self.statics.linearise(&state.motion, &state.loads).then_some(())?;
        self.differentiate(&mut state).ok()?;
        Some(state)
    }

    /// Forgets the last estimate and the held estimate.
    pub fn forget(&mut self) {
        (self.last, self.held, self.is_chosen) = (None, None, false);
    }

    fn finger(&self) -> &'m Finger {
        self.mesh.finger()
    }

    /// Estimates the forces. `noise_mm` is the standard deviation of one coordinate, mm. The noise is estimated from the residual if `noise_mm` is `None` or
    /// contradicts the residual.
    ///
    /// # Errors
    /// [`SensingError`] if the unknowns are not identifiable, no equilibrium explains the measurement, or the search does not converge.
    pub fn estimate(
        &mut self,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Result<NonlinearEstimate, SensingError> {
        self.expect(measurement, noise_mm)?;
        let coordinates = measurement.coordinate_count();
        // Priors and conditions of an object count as measured coordinates.
        let known = self.priors.count() + self.object.as_ref().map_or(0, Touching::row_count);
        let unknowns = self.unknowns.len().saturating_sub(known);
        if unknowns > coordinates {
            return Err(SensingError::TooFewMarkers { unknowns, coordinates });
        }
        let Minima { best, mut all, starts, mut others, scanned } = self.minima(measurement, noise_mm)?;
        let Found { mut state, steps, near } = best;
        let least_misfit = self.misfit(&state, measurement);
        let mut estimate = self.judged(&mut state, measurement, noise_mm, steps)?;
        estimate.check_against_nothing(least_misfit, state.linearised.misfit_at_rest(measurement))?;
        self.require_linear_range(&state, measurement, &estimate.forces.sigmas_n)?;
        let is_confirmed = near || !scanned.is_empty();
        estimate.check_unconfirmed(coordinates, &starts)?;
        for (_, forces_n) in all.iter_mut().chain(&mut others) {
            let ordered_n = forces_n.clone();
            self.order(&state.contacts).into_iter().zip(ordered_n).for_each(|(i, force_n)| forces_n[i] = force_n);
        }
        estimate.check_rivals(least_misfit, &all, is_confirmed, coordinates)?;
        if !self.unplaced().is_empty() {
            estimate.widen_by_rivals(least_misfit, &all);
            estimate.widen_by_positions(least_misfit, &others);
        }
        // With several unknown positions, the forces of a starting point may belong to other contacts.
        if self.unplaced().len() <= 1 {
            // At a starting point, the forces act along the undeformed normal, so a starting point cannot contradict forces along the deformed
            // normal.
            if !self.follows_plate() {
                let expected = Nuisances::expected(self.questions.len(), &self.shared_errors);
                let starts = starts.iter().map(|(forces_n, motion)| {
                    let shape = Posed { motion, forces_n, nuisances: &expected };
                    (state.linearised.misfit(shape, measurement), forces_n)
                });
                let scanned = scanned.iter().flatten().map(|point| (point.misfit_mm2, &point.forces_n));
                estimate.check_other_forces(least_misfit, starts.chain(scanned))?;
            }
        }
        self.widen_by_curvature(&state, measurement, &mut estimate)?;
        self.widen_by_leans(&state, measurement, noise_mm, &mut estimate)?;
        self.last = Some(state);
        Ok(estimate)
    }

    /// Prepares the estimator for the uncertain base, the shared errors and the noise of a measurement.
    ///
    /// # Errors
    /// [`SensingError::NoiseNotStated`] if a prior or an object requires a stated noise, [`SensingError::NoObject`] if a direction requires an
    /// object.
    fn expect(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<(), SensingError> {
        self.require_object()?;
        let is_base_sought = measurement.base().is_some();
        let has_base = self.unknowns.iter().any(|unknown| matches!(unknown, Unknown::Base(_)));
        if is_base_sought != has_base || self.shared_errors != measurement.shared_errors() {
            self.shared_errors = measurement.shared_errors().to_vec();
            self.list_unknowns(is_base_sought);
        }
        let object = self.object.as_ref().map(|touching| &touching.object);
        self.priors = Priors::new(&self.unknowns, &self.questions, object, measurement, noise_mm);
        if (self.priors.count() > 0 || object.is_some()) && noise_mm.is_none() {
            return Err(SensingError::NoiseNotStated);
        }
        for state in self.last.iter_mut().chain(&mut self.held) {
            state.linearised.priors.clone_from(&self.priors);
        }
        Ok(())
    }

    /// Lists the unknowns. Forgets all estimates, which may have other unknowns.
    fn list_unknowns(&mut self, is_base_sought: bool) {
        let object = self.object.as_ref().map(|touching| &touching.object);
        self.unknowns = Unknown::of(&self.questions, is_base_sought, object, self.shared_errors.len());
        self.scan = None;
        self.forget();
    }
}
