//! Follows a step of the search along equilibria, from share zero to share one of the step. The misfit is the sum of squared weighted residuals.

use super::marker_motion::Posed;
use super::problem::{ForceProblem, State, known_misfit};
use super::projection::project;
use crate::frame::FrameMotion;
use crate::measurement::Measurement;
use crate::statics::StaticsError;

/// A step of the search ends early at the first equilibrium whose misfit (sum of squared weighted residuals) exceeds this factor times the misfit at
/// the start of the step.
const WORSE: f64 = 2.0;
/// A step ends after this number of rejected shorter steps, at the largest share of the step for which an equilibrium was found.
const MOST_REJECTED: usize = 2;

/// Equilibrium under the loads after a share of a step.
pub(super) struct OnTheWay {
    share: f64,
    misfit_mm2: f64,
    motion: FrameMotion,
}

/// Follows the equilibrium from `state` to the loads of `next`, and stores the resulting motion in `next`. All misfits (sums of squared weighted residuals)
/// use the weights of `state`, because new weights would change the misfit without progress of the search. `current_mm2` is the misfit of `state`.
///
/// The first result is the misfit at the end of the step, mm^2. If no equilibrium exists at the end, the first result is an error: the share of
/// the step (0 to 1) up to which equilibria exist. The second result is the equilibrium with the smallest misfit on the path, if this misfit does
/// not exceed `current_mm2`.
pub(super) fn follow_step(
    problem: &mut ForceProblem,
    state: &State,
    next: &mut State,
    measurement: &Measurement,
    current_mm2: f64,
) -> (Result<f64, f64>, Option<OnTheWay>) {
    let ForceProblem { mesh, object, unknowns, shared_errors, priors, statics, .. } = problem;
    let projected = |motion: &FrameMotion| {
        let shape = Posed { motion, ..next.posed() };
        project((unknowns, shared_errors, priors), (mesh, object.as_ref()), &state.linearised, shape, measurement)
    };
    let misfit_mm2 = |motion: &FrameMotion| {
        let projected = projected(motion);
        let shape = Posed { motion, nuisances: projected.as_ref().unwrap_or(&next.nuisances), ..next.posed() };
        state.linearised.misfit(shape, measurement) + known_misfit(mesh, priors, object.as_ref(), shape)
    };
    let mut best: Option<OnTheWay> = None;
    let loads = [&state.loads[..], &next.loads];
    let tried = statics.tried(&state.motion, loads, MOST_REJECTED, |share, motion| {
        let there_mm2 = misfit_mm2(motion);
        if there_mm2 <= best.as_ref().map_or(current_mm2, |best| best.misfit_mm2) {
            best = Some(OnTheWay { share, misfit_mm2: there_mm2, motion: motion.clone() });
        }
        there_mm2 <= WORSE * current_mm2
    });
    let misfit_mm2 = match tried {
        Ok(equilibrium) => {
            let after_mm2 = misfit_mm2(&equilibrium.motion);
            let projected = projected(&equilibrium.motion);
            next.motion = equilibrium.motion;
            next.nuisances = projected.unwrap_or_else(|| next.nuisances.clone());
            Ok(after_mm2)
        }
        Err(StaticsError::NoEquilibrium { converged_fraction }) => Err(converged_fraction),
        Err(_) => Err(0.0),
    };
    (misfit_mm2, best)
}

/// State after the share of a step that `on_the_way` states, iterated to equilibrium. Also returns the share of the step (0 to 1). `None` if no
/// equilibrium is found, or if the equilibrium's misfit exceeds `current_mm2`, the misfit of `state`.
pub(super) fn part_of_step(
    problem: &mut ForceProblem,
    state: &State,
    on_the_way: OnTheWay,
    measurement: &Measurement,
    current_mm2: f64,
) -> Option<(f64, State)> {
    let OnTheWay { share, motion, .. } = on_the_way;
    let mut state = state.clone();
    state.linearised.step.iter_mut().for_each(|x| *x *= share);
    problem.advance(&mut state).ok()?;
    let loads = [&state.loads[..], &state.loads];
    state.motion = problem.statics.tried(&motion, loads, 1, |_, _| true).ok()?.motion;
    let ForceProblem { mesh, object, unknowns, shared_errors, priors, .. } = &*problem;
    let projected = project(
        (unknowns, shared_errors, priors),
        (mesh, object.as_ref()),
        &state.linearised,
        state.posed(),
        measurement,
    );
    state.nuisances = projected.unwrap_or(state.nuisances);
    let is_better = problem.misfit(&state, measurement) <= current_mm2;
    is_better.then_some((share, state))
}
