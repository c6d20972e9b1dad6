//! The nonlinear estimator, and the course of one estimate: find the minima, assess the best, compare it with others, widen its intervals.

use super::alternatives::{check_against_nothing, check_other_forces, check_rivals, check_unconfirmed, widen_by};
use super::assessment::{assess, require_determined};
use super::correction::{correct, correct_below_noise};
use super::estimate::{Alternatives, NonlinearEstimate};
use super::leaning::widen_by_leans;
use super::linear_range::{require_linear_range, widen_by_curvature};
use super::linearised::Seen;
use super::marker_motion::Posed;
use super::minima::{KeptScan, MANY_COORDINATES, Minima, find_minima, minimum_near};
use super::object_start::{require_touch, without_object};
use super::position::{Profiled, profile_over_position};
use super::position_profile::PositionProfile;
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::states::{Found, carry_over, state_near, state_under};
use super::values::Nuisances;
use crate::frame::FrameMotion;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::{Contact, ContactQuestion, SensingError, TouchedObject};

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
/// Requires at least as many measured coordinates as unknowns. The unknowns are one force per contact, each unknown position or direction, and
/// the uncertain pose of a base, of an object, or other errors that the measurement states. The ratio of the largest to the smallest singular value of the derivatives must be at most [`LARGEST_SPAN`](crate::sensing::LARGEST_SPAN).
///
/// # Reference
/// For measured displacements u, the Levenberg-Marquardt method minimises |W (u - u(f, s, angle))|^2 (Nocedal and Wright, Numerical Optimization,
/// sec. 10.3). The function u(f, s, angle) gives the displacements of the co-rotational finger in equilibrium, with derivatives from the factored
/// tangent. Outlying markers are down-weighted (iteratively reweighted least squares).
#[derive(Debug, Clone)]
pub struct NonlinearEstimator<'m> {
    pub(super) problem: ForceProblem<'m>,
    /// State of the last estimate.
    pub(super) last: Option<State>,
    scan: KeptScan,
}

impl<'m> NonlinearEstimator<'m> {
    /// Prepares the estimator for contacts on a mesh.
    ///
    /// # Errors
    /// [`SensingError`] if no contact is given, a contact is not on a free part of its plate, or two contacts are equal.
    pub fn new(mesh: &'m Mesh, questions: &[ContactQuestion]) -> Result<NonlinearEstimator<'m>, SensingError> {
        let problem = ForceProblem::new(mesh, questions)?;
        Ok(NonlinearEstimator { problem, last: None, scan: None })
    }

    /// This estimator with an object of known shape, for contacts whose lean (angle between force and normal) is measured from
    /// [`Normal::Object`](crate::sensing::Normal::Object).
    pub fn with_object(mut self, object: Option<&TouchedObject>) -> NonlinearEstimator<'m> {
        self.problem = self.problem.with_object(object);
        self.forget();
        self
    }

    /// Forgets the last estimate. The next estimate starts from least squares.
    pub fn reset(&mut self) {
        self.last = None;
    }

    /// Forgets the last estimate and the scanned equilibria.
    pub fn forget(&mut self) {
        (self.last, self.scan) = (None, None);
    }

    /// Estimates the forces. `marker_noise_mm` is the standard deviation of one coordinate, mm. The noise is estimated from the residual if
    /// `marker_noise_mm` is `None` or contradicts the residual.
    ///
    /// # Errors
    /// [`SensingError`] if the unknowns are not identifiable, no equilibrium explains the measurement, or the search does not converge.
    pub fn estimate(
        &mut self,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
    ) -> Result<NonlinearEstimate, SensingError> {
        let seen = Seen { measurement, marker_noise_mm };
        self.expect(seen)?;
        let state = self.last.take();
        self.estimate_from(Near { state, is_chosen: false }, seen)
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
        marker_noise_mm: Option<f64>,
    ) -> Result<NonlinearEstimate, SensingError> {
        self.estimate_from_kept(None, near, is_chosen, Seen { measurement, marker_noise_mm })
    }

    /// Estimates the forces like [`estimate_near`](NonlinearEstimator::estimate_near). If a minimum is near the state `kept`, an earlier estimate on
    /// this mesh with the same contacts, the search starts from `kept`. Otherwise the search starts from the equilibrium under the forces of `near`.
    pub(super) fn estimate_from_kept(
        &mut self,
        kept: Option<State>,
        near: NearForces,
        is_chosen: bool,
        seen: Seen,
    ) -> Result<NonlinearEstimate, SensingError> {
        self.expect(seen)?;
        self.last = None;
        let problem = &mut self.problem;
        let many = MANY_COORDINATES[usize::from(problem.questions.len() > 1)];
        let is_unique = is_chosen || seen.measurement.coordinate_count() >= many;
        let mut state = None;
        if is_unique && problem.object.is_none() && near.contacts.len() == problem.questions.len() {
            let at_minimum = kept.and_then(|state| minimum_of_earlier(problem, state, seen));
            let at_shape = at_minimum.or_else(|| state_near(problem, near.contacts, near.forces_n, near.shape?));
            state = at_shape.or_else(|| state_under(problem, near.contacts, near.forces_n, None));
        }
        let is_chosen = is_chosen && state.is_some();
        self.estimate_from(Near { state, is_chosen }, seen)
    }

    fn estimate_from(&mut self, near: Near, seen: Seen) -> Result<NonlinearEstimate, SensingError> {
        let (estimate, state) = estimate_forces(&mut self.problem, near, &mut self.scan, seen)?;
        self.last = Some(state);
        Ok(estimate)
    }

    /// Prepares the problem for a measurement. Forgets all states if they have other unknowns.
    fn expect(&mut self, seen: Seen) -> Result<(), SensingError> {
        if self.problem.expect(seen)? {
            self.forget();
        }
        Ok(())
    }
}

/// Where the search for a minimum starts.
#[derive(Debug, Default)]
pub(super) struct Near {
    /// State near the minimum. Without a state, searches start from least squares on the linear finger.
    pub state: Option<State>,
    /// Whether the minimum near the state was chosen among all minima, for example on a coarser mesh.
    pub is_chosen: bool,
}

/// The minimum near a state of an earlier estimate, so near that the rest is negligible compared with the noise. The estimate then corrects forces and
/// contacts further if needed. `None` if there is no minimum, or if the state has other unknowns.
fn minimum_of_earlier(problem: &mut ForceProblem, mut state: State, seen: Seen) -> Option<State> {
    (state.linearised.unknowns == problem.unknowns).then_some(())?;
    match problem.shared_errors.is_empty() {
        // The noise of the measurement scales the priors.
        true => problem.write_prior_rows(&mut state),
        // The markers' displacements by shared errors are those of the earlier measurement.
        false => state = carry_over(problem, state, seen).ok()?,
    }
    correct_below_noise(problem, &mut state, seen)?;
    Some(state)
}

/// Estimates the forces of a problem that [expects](ForceProblem::expect) the measurement. Returns the estimate and its state.
///
/// # Errors
/// [`SensingError`] if the unknowns are not identifiable, no equilibrium explains the measurement, or the search does not converge.
fn estimate_forces(
    problem: &mut ForceProblem,
    near: Near,
    scan: &mut KeptScan,
    seen: Seen,
) -> Result<(NonlinearEstimate, State), SensingError> {
    let measurement = seen.measurement;
    let coordinates = measurement.coordinate_count();
    // Priors and conditions of an object count as measured coordinates.
    let unknowns = problem.unknowns.len().saturating_sub(problem.known_count());
    if unknowns > coordinates {
        return Err(SensingError::TooFewMarkers { unknowns, coordinates });
    }
    let near_is_chosen = near.is_chosen;
    let at_hand = minimum_at_hand(problem, near.state, seen)?;
    let minima = match at_hand {
        Some(best) if near_is_chosen => Minima::only(best),
        at_hand => find_minima(problem, at_hand, scan, seen)?,
    };
    estimate_best(problem, minima, near_is_chosen, seen)
}

/// Estimates the forces of the best minimum, and compares it with all others. `is_chosen` states whether it was chosen on a coarser mesh.
///
/// # Errors
/// [`SensingError`] if the unknowns are not identifiable, or no equilibrium explains the measurement.
fn estimate_best(
    problem: &mut ForceProblem,
    minima: Minima,
    is_chosen: bool,
    seen: Seen,
) -> Result<(NonlinearEstimate, State), SensingError> {
    let measurement = seen.measurement;
    let coordinates = measurement.coordinate_count();
    let Minima { best, mut all, mut rivals, starts, mut others, scanned } = minima;
    let Found { mut state, steps, near } = best;
    let least_misfit = problem.misfit(&state, measurement);
    let mut estimate = assess(problem, &mut state, seen, steps)?;
    check_against_nothing(&estimate, least_misfit, state.linearised.misfit_at_rest(measurement))?;
    let is_confirmed = near || !scanned.is_empty();
    check_unconfirmed(&estimate, coordinates, &starts)?;
    for (_, forces_n) in all.iter_mut().chain(&mut others) {
        let ordered_n = forces_n.clone();
        problem.order(&state.contacts).into_iter().zip(ordered_n).for_each(|(i, force_n)| forces_n[i] = force_n);
    }
    let unplaced = problem.unplaced().len();
    // The profile compares minima at different positions. A minimum that was chosen on a coarser mesh has its profile from that mesh.
    let profile = match is_chosen {
        true => None,
        false => match profile_over_position(problem, &state, &rivals, seen, &estimate)? {
            Profiled::Nothing => None,
            Profiled::Profile(profile) => Some(profile),
            Profiled::Better(start) => {
                let start = carry_over(problem, *start, seen)?;
                let best = minimum_near(problem, start, seen, &mut SearchHistory::default())?;
                let best = best.filter(|it| problem.misfit(&it.state, measurement) < least_misfit);
                let best = best.ok_or(SensingError::Unconfirmed)?;
                rivals.push(state);
                let minima = Minima { best, all, rivals, starts, others: Vec::new(), scanned };
                return estimate_best(problem, minima, is_chosen, seen);
            }
        },
    };
    // The profile decides on a weakly known position, on this mesh or on a coarser one.
    let is_weak = problem.is_weak(measurement);
    let is_profiled = is_weak && (profile.is_some() || is_chosen);
    require_determined(problem, &estimate, is_profiled)?;
    if !(is_weak && is_chosen) {
        let at_position = profile.as_ref().filter(|_| is_weak).and_then(PositionProfile::best);
        let sigmas_n = at_position.map_or(&estimate.forces.sigmas_n, |best| &best.sigmas_n);
        require_linear_range(problem, &state, measurement, sigmas_n)?;
    }
    if profile.is_none() {
        check_rivals(&estimate, least_misfit, &all, is_confirmed, coordinates)?;
    }
    if unplaced > 0 {
        let grown =
            |all: Vec<(f64, Vec<f64>)>| all.into_iter().map(|(of_other, it)| (of_other - least_misfit, it)).collect();
        let alternatives = Alternatives { minima: grown(all.clone()), others: grown(others), profile };
        widen_by(&alternatives, &mut estimate, problem.finger());
        if alternatives.profile.is_some() {
            check_rivals(&estimate, least_misfit, &all, is_confirmed, coordinates)?;
        }
        estimate.alternatives = alternatives;
    }
    // With several unknown positions, the forces of a starting point may belong to other contacts. At a starting point, the forces act along the
    // undeformed normal, so a starting point cannot contradict forces along the deformed normal.
    if unplaced <= 1 && !problem.follows_plate() {
        let expected = Nuisances::expected(problem.questions.len(), &problem.shared_errors);
        let starts = starts.iter().map(|(forces_n, motion)| {
            let shape = Posed { motion, contacts: &state.contacts, forces_n, nuisances: &expected };
            (problem.misfit_of(shape, &state.linearised, measurement), forces_n)
        });
        let scanned = scanned.iter().flatten().map(|point| (point.misfit_mm2, &point.forces_n));
        check_other_forces(&estimate, least_misfit, starts.chain(scanned))?;
    }
    widen_by_curvature(problem, &state, measurement, &mut estimate)?;
    widen_by_leans(problem, &state, seen, &mut estimate)?;
    Ok((estimate, state))
}

/// Minimum of the misfit near a state or, for contacts with an object, near the estimate from markers alone. `None` without such a minimum.
fn minimum_at_hand(problem: &mut ForceProblem, near: Option<State>, seen: Seen) -> Result<Option<Found>, SensingError> {
    if let Some(mut state) = near
        && let Some(steps) = correct(problem, &mut state, seen)
    {
        return Ok(Some(Found { state, steps, near: true }));
    }
    if problem.object.is_none() {
        return Ok(None);
    }
    let Some(start) = sense_without_object(problem, seen)? else { return Ok(None) };
    Ok(minimum_near(problem, start, seen, &mut SearchHistory::default()).ok().flatten())
}

/// The estimate from markers alone, as a starting point. `None` if the markers do not identify the unknowns.
///
/// # Errors
/// [`SensingError::NotTouching`] if the object cannot touch the plate.
fn sense_without_object(problem: &mut ForceProblem, seen: Seen) -> Result<Option<State>, SensingError> {
    let mut plain = without_object(problem)?;
    let found = plain.expect(seen).and_then(|_| estimate_forces(&mut plain, Near::default(), &mut None, seen));
    let Ok((_, state)) = found else { return Ok(None) };
    require_touch(problem, &state, seen)?;
    carry_over(problem, state, seen).map(Some)
}
