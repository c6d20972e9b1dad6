//! Linearises states: derivatives of the markers' displacements with respect to the unknowns of a force problem.
//!
//! Without an object, they follow from the factored tangent ([`MarkerRates`]). With an object, they are differences of states.

use super::linearised::Linearised;
use super::marker_motion::MarkerRates;
use super::problem::{ForceProblem, State};
use crate::sensing::{PadForce, SensingError};
use crate::statics::StaticsError;
use nalgebra::UnitComplex;

/// Step of the difference quotients, as a share of each unknown's scale. The differenced quantities are almost linear within such a small step.
const STEP: f64 = 1e-5;
/// Number of times that the loads are updated to the bent shape, which determines their directions and levers.
const FOLLOWED: usize = 3;

/// Factors the tangent at a state and computes the derivatives of the shape with respect to the unknowns.
///
/// # Errors
/// [`SensingError::Statics`] if the tangent is not positive definite.
pub(super) fn linearise(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    if !problem.statics.linearise(&state.motion, &state.loads) {
        return Err(SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 }));
    }
    differentiate(problem, state)
}

/// Linearises a shape that is near an equilibrium under its loads. Residuals are those after Newton's correction of the shape, which is left to
/// [`corrected_under`](crate::statics::Statics::corrected_under). `None` if the tangent is not positive definite.
pub(super) fn look_ahead(problem: &mut ForceProblem, state: &mut State) -> Option<()> {
    problem.statics.linearise(&state.motion, &state.loads).then_some(())?;
    differentiate(problem, state).ok()?;
    let State { motion, nuisances, linearised, .. } = state;
    problem.statics.equations().corrected_markers(motion, &mut linearised.ahead);
    let turn = nuisances.base.rotation;
    if turn != UnitComplex::identity() {
        linearised.ahead.iter_mut().for_each(|ahead| *ahead = turn * *ahead);
    }
    Some(())
}

/// Computes the derivatives of the shape with respect to the unknowns from the factored tangent.
pub(super) fn differentiate(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    problem.rescale(state);
    state.linearised.turn_signs.clone_from(&problem.priors.turn_signs);
    state.linearised.prior_rows.clear();
    state.linearised.prior_rows.extend(problem.priors.rows(&state.nuisances, &state.forces_n));
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

/// Computes the same derivatives as [`differentiate`], but by first-order differences of states. Here,
/// directions follow the object, and the differences include the effect of changed directions on the shape.
///
/// # Errors
/// [`SensingError::Statics`] if the tangent does not belong to an equilibrium.
fn differentiate_by_differences(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    let Some(touching) = problem.object.clone() else { return Ok(()) };
    let marker_noise_mm = problem.priors.marker_noise_mm();
    let misses =
        |state: &State| -> Vec<f64> { touching.misses_mm(problem.mesh, state.posed(), marker_noise_mm).collect() };
    let before = state_after_step(problem, state, None)?;
    let before_misses = misses(&before);
    let at_state = misses(state);
    state.linearised.take_misses(at_state);
    for unknown in 0..problem.unknowns.len() {
        let step = STEP * state.linearised.scales[unknown];
        let after = state_after_step(problem, state, Some((unknown, step)))?;
        let after_misses = misses(&after);
        let states = [(&before, &before_misses), (&after, &after_misses)]
            .map(|(state, misses)| (state.posed(), misses.as_slice()));
        state.linearised.take_differences(unknown, states, step);
    }
    Ok(())
}

/// State after a step of one unknown (index and change). The tangent determines the new shape, and the new shape determines the loads. If `step`
/// is `None`, no unknown changes.
fn state_after_step(
    problem: &mut ForceProblem,
    state: &State,
    step: Option<(usize, f64)>,
) -> Result<State, SensingError> {
    let none = SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 });
    let mut state = state.clone();
    state.linearised.step.clear();
    state.linearised.step.resize(problem.unknowns.len(), 0.0);
    if let Some((unknown, by)) = step {
        state.linearised.step[unknown] = by;
    }
    for _ in 0..FOLLOWED {
        problem.advance(&mut state)?;
        problem.statics.corrected(&mut state.motion, &state.loads).ok_or(none.clone())?;
        state.linearised.step.fill(0.0);
    }
    Ok(state)
}
