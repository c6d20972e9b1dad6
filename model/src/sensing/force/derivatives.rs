//! Linearises states: derivatives of the markers' displacements with respect to the unknowns of a force problem.
//!
//! Without an object, they follow from the factored tangent ([`MarkerRates`]). With an object, they are differences of states.

use super::linearised::Linearised;
use super::marker_motion::{MarkerRates, marker_displacement};
use super::problem::{ForceProblem, State};
use crate::frame::FrameLoad;
use crate::sensing::{PadForce, SensingError};
use crate::statics::StaticsError;

/// Step of the difference quotients, as a share of each unknown's scale. The differenced quantities are almost linear within such a small step.
const STEP: f64 = 1e-5;
/// Number of times that the loads are updated to the bent shape, which determines their directions and levers. Each update removes at least four fifths
/// of the change that remains.
const FOLLOWED: usize = 6;
/// A tangent that is not positive definite belongs to no stable equilibrium.
const UNSTABLE: SensingError = SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 });

/// Factors the tangent at a state and computes the derivatives of the shape with respect to the unknowns.
///
/// # Errors
/// [`SensingError::Statics`] if the tangent is not positive definite.
pub(super) fn linearise(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    factor(problem, state)?;
    differentiate(problem, state)
}

fn factor(problem: &mut ForceProblem, state: &State) -> Result<(), SensingError> {
    let is_stable = problem.statics.linearise(&state.motion, &state.loads);
    is_stable.then_some(()).ok_or(UNSTABLE)
}

/// Factors the tangent at a state and computes the derivatives of the shape, including the effect of the shape on loads that follow it.
///
/// # Errors
/// [`SensingError::Statics`] if the tangent is not positive definite.
pub(super) fn linearise_with_loads(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    if !problem.loads_follow_plate() {
        return linearise(problem, state);
    }
    factor(problem, state)?;
    prepare(problem, state);
    differentiate_by_differences(problem, state)
}

/// Linearises a shape that is near an equilibrium under its loads. Residuals are those after Newton's correction of the shape, which is left to
/// [`corrected_under`](crate::statics::Statics::corrected_under). `None` if the tangent is not positive definite.
pub(super) fn look_ahead(problem: &mut ForceProblem, state: &mut State) -> Option<()> {
    problem.statics.linearise(&state.motion, &state.loads).then_some(())?;
    differentiate(problem, state).ok()?;
    let State { motion, nuisances, linearised, .. } = state;
    problem.statics.equations().corrected_markers(motion, &mut linearised.ahead);
    linearised.ahead.iter_mut().for_each(|ahead| *ahead = marker_displacement(nuisances, *ahead));
    Some(())
}

/// Scales the unknowns and linearises the priors.
fn prepare(problem: &ForceProblem, state: &mut State) {
    problem.rescale(state);
    state.linearised.turn_signs.clone_from(&problem.priors.turn_signs);
    problem.write_prior_rows(state);
}

/// Computes the derivatives of the shape with respect to the unknowns from the factored tangent.
pub(super) fn differentiate(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    prepare(problem, state);
    if problem.object.is_some() {
        return differentiate_by_differences(problem, state);
    }
    let forces: Vec<PadForce> = state.pad_forces(&problem.questions).collect();
    let State { nuisances, motion, linearised, .. } = state;
    let Linearised { marker_points, rates, room, .. } = linearised;
    let ForceProblem { mesh, questions, shared_errors, statics, .. } = problem;
    let ladder = statics.equations_mut();
    let mut of_markers =
        MarkerRates { mesh, questions, shared_errors, ladder, motion, nuisances, forces: &forces, room };
    for (&unknown, rates) in problem.unknowns.iter().zip(rates.chunks_exact_mut(marker_points.len())) {
        of_markers.differentiate(unknown, marker_points, rates)?;
    }
    Ok(())
}

/// Computes the same derivatives as [`differentiate`], but by first-order differences of states. The differences include the effect of the shape on
/// loads that follow it.
///
/// # Errors
/// [`SensingError::Statics`] if a state is not finite.
fn differentiate_by_differences(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    let (object, marker_noise_mm) = (problem.object.clone(), problem.priors.marker_noise_mm());
    let mesh = problem.mesh;
    let misses = |state: &State| -> Vec<f64> {
        object.iter().flat_map(|object| object.misses_mm(mesh, state.posed(), marker_noise_mm)).collect()
    };
    let mut applied = state.loads.clone();
    let before = state_after_step(problem, state, None, &mut applied)?;
    let before_misses = misses(&before);
    let at_state = misses(state);
    state.linearised.take_misses(at_state);
    for unknown in 0..problem.unknowns.len() {
        let step = STEP * state.linearised.scales[unknown];
        let after = state_after_step(problem, state, Some((unknown, step)), &mut applied)?;
        let after_misses = misses(&after);
        let states = [(&before, &before_misses), (&after, &after_misses)]
            .map(|(state, misses)| (state.posed(), misses.as_slice()));
        state.linearised.take_differences(unknown, states, step);
    }
    Ok(())
}

/// State after a step of one unknown (index and change). The tangent determines the new shape, and the new shape determines the loads. If `step` is
/// `None`, no unknown changes. Without an object, the tangent is that factored at `from`, under the loads `applied`, which become those of the
/// state. With an object, each new shape is linearised: to first order, 9 instead of 2 of 48 searches on reassembled fingers did not converge.
///
/// # Errors
/// [`SensingError::Statics`] if the state is not finite.
pub(super) fn state_after_step(
    problem: &mut ForceProblem,
    from: &State,
    step: Option<(usize, f64)>,
    applied: &mut Vec<FrameLoad>,
) -> Result<State, SensingError> {
    let mut state = from.clone();
    state.linearised.step.clear();
    state.linearised.step.resize(problem.unknowns.len(), 0.0);
    if let Some((unknown, by)) = step {
        state.linearised.step[unknown] = by;
    }
    for _ in 0..FOLLOWED {
        problem.advance(&mut state)?;
        if problem.object.is_some() {
            problem.statics.corrected(&mut state.motion, &state.loads).ok_or(UNSTABLE)?;
        } else {
            state.motion.clone_from(&from.motion);
            problem.statics.corrected_under(&mut state.motion, applied, &state.loads).ok_or(UNSTABLE)?;
            applied.clone_from(&state.loads);
        }
        state.linearised.step.fill(0.0);
    }
    Ok(state)
}
