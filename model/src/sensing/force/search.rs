//! Searches for the nearest minimum of the misfit (sum of squared weighted residuals) from any starting point, by the Levenberg-Marquardt method with
//! a trust region.
//!
//! The finger hardly responds to a force along a plate until the plate buckles. A step that suits the linearised finger may lead far away, or to no
//! equilibrium. The trust region therefore limits steps to the range in which earlier predictions were accurate. A step also ends at an equilibrium
//! whose misfit is much larger than the misfit at the start of the step ([`follow_step`]).

use super::SETTLED_ANGLE_DEG;
use super::correction::correct;
use super::derivatives::linearise;
use super::linearised::Seen;
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::states::Found;
use super::step_path::{follow_step, part_of_step};
use crate::optimise::{Convergence, Prediction, TrustRegion};
use crate::sensing::SensingError;

/// The search ends after this number of steps. From a good starting point, the search needs three steps.
const MAX_STEPS: usize = 60;
/// Steps have converged when they change every unknown by less than this share of its scale. Steps have also converged when every combination of
/// unknowns differs from its optimum by less than a hundredth of its standard deviation.
const CONVERGENCE: Convergence = Convergence { relative_decrease: 1e-2 * 1e-2, step: 1e-7 };
/// After [`MAX_STEPS`], the result is accepted if the last step changed every unknown by at most this share of its scale. No camera resolves such a change. If
/// the finger does not explain the data, the weights of the markers change in every step and converge slowly.
const SMALL_ENOUGH: f64 = 1e-5;
/// The minimum may be near if a step changes every unknown by at most this share of its scale. If the minimum proves not to be near, the limit is
/// lowered to a tenth of the change in that step.
const MAY_BE_NEAR: f64 = 0.03;
/// A step is accepted if it increases the misfit (sum of squared residuals) by at most this share, or by at most `TURNING_SLACK` while directions
/// that follow the plate turn. Rounding may cause a small increase. Even in a good step, the misfit may increase because a normal turns, but the next
/// step corrects the residual.
const SETTLED_SLACK: f64 = 1e-12;
const TURNING_SLACK: f64 = 0.5;

/// One search for a minimum.
struct Search<'s, 'm> {
    problem: &'s mut ForceProblem<'m>,
    seen: Seen<'s>,
    history: &'s mut SearchHistory,
    /// Current state.
    state: State,
    /// Largest motion of the markers in a step, mm.
    reach: TrustRegion,
    /// Whether the last step left directions that follow the plate unchanged.
    is_settled: bool,
    /// Largest relative change of an unknown in the last step. The minimum may be near if the last step's largest relative change of an unknown does
    /// not exceed `near`.
    last_change: f64,
    near: f64,
    /// Whether every step was taken in full and decreased the misfit about as much as predicted.
    is_straight: bool,
}

/// End of a search.
enum End {
    /// The search has reached a minimum; the number counts the additional steps of a final simultaneous correction, 0 without one.
    Minimum(usize),
    /// The search has met the path of another search.
    Met,
}

/// Searches for a minimum by Gauss-Newton steps. Each step ends at an equilibrium. A step is shortened if it does not reduce the misfit (sum of
/// squared residuals). The minimum counts as near if every step was taken in full and decreased the misfit about as much as predicted. `None` if
/// the search meets an earlier path of `history`.
///
/// # Errors
/// [`SensingError`] if the unknowns are not identifiable, or the steps do not converge.
pub(super) fn search(
    problem: &mut ForceProblem,
    mut state: State,
    seen: Seen,
    history: &mut SearchHistory,
) -> Result<Option<Found>, SensingError> {
    linearise(problem, &mut state)?;
    state.weigh(seen);
    let moved_mm = state.linearised.misfit_at_rest(seen.measurement).sqrt();
    let search = Search {
        problem,
        seen,
        history,
        state,
        reach: TrustRegion::of_scale(moved_mm),
        is_settled: false,
        last_change: f64::INFINITY,
        near: MAY_BE_NEAR,
        is_straight: true,
    };
    search.run()
}

impl Search<'_, '_> {
    fn run(mut self) -> Result<Option<Found>, SensingError> {
        let mut steps = 0;
        while steps < MAX_STEPS && !self.reach.is_exhausted() {
            steps += 1;
            let misfit_mm2 = self.misfit_mm2();
            let whole = self.state.solve(self.seen.measurement, 0.0)?;
            let end = match self.end_at(misfit_mm2, whole) {
                None => self.step(misfit_mm2, whole)?,
                end => end,
            };
            match end {
                None => {}
                Some(End::Met) => return Ok(None),
                Some(End::Minimum(further)) => return Ok(Some(self.found(steps + further))),
            }
        }
        if self.reach.is_exhausted() || self.last_change <= SMALL_ENOUGH {
            return Ok(Some(self.found(steps)));
        }
        let forces = self.state.linearised.step.iter().take(self.problem.questions.len());
        let change_n = forces.fold(0.0, |m: f64, x| m.max(x.abs()));
        Err(SensingError::NotConverged { iterations: steps, change_n })
    }

    fn found(self, steps: usize) -> Found {
        Found { state: self.state, steps, near: self.is_straight }
    }

    fn misfit_mm2(&self) -> f64 {
        self.problem.misfit(&self.state, self.seen.measurement)
    }

    /// End of the search at the current state. `None` if the search goes on. `next` is the prediction for the next step.
    fn end_at(&mut self, misfit_mm2: f64, next: Prediction) -> Option<End> {
        if self.is_settled && self.history.ends_far(misfit_mm2, next.decrease) {
            self.history.reach(&self.state);
            self.is_straight = false;
            return Some(End::Minimum(0));
        }
        let of_residual_mm2 = misfit_mm2 / self.seen.measurement.coordinate_count() as f64;
        let variance_mm2 = f64::max(self.seen.marker_noise_mm.unwrap_or(0.0).powi(2), of_residual_mm2);
        let is_there = self.is_settled && CONVERGENCE.is_small_decrease(next.decrease, variance_mm2);
        if is_there || self.last_change <= self.near {
            let corrected = self.corrected();
            if corrected.is_some() {
                return corrected;
            }
            self.near = 0.1 * f64::min(self.near, self.last_change);
        }
        is_there.then_some(End::Minimum(0))
    }

    /// Corrects forces and shape together. `None` if the minimum is not near enough.
    fn corrected(&mut self) -> Option<End> {
        let mut corrected = self.state.clone();
        let steps = correct(self.problem, &mut corrected, self.seen)?;
        self.state = corrected;
        self.history.reach(&self.state);
        Some(End::Minimum(steps))
    }

    /// Accepts the next step or a part of this step, or rejects the step and shrinks the trust region. `whole` is the prediction for the step without
    /// damping.
    fn step(&mut self, misfit_mm2: f64, whole: Prediction) -> Result<Option<End>, SensingError> {
        let prediction = self.within_reach(whole)?;
        let change = self.problem.relative_change(&self.state);
        let mut next = self.state.clone();
        self.is_settled = self.problem.advance(&mut next)? <= SETTLED_ANGLE_DEG;
        let (followed, best) = follow_step(self.problem, &self.state, &mut next, self.seen.measurement, misfit_mm2);
        if let Ok(after_mm2) = followed {
            let slack = if self.is_settled { SETTLED_SLACK } else { TURNING_SLACK };
            if after_mm2 <= misfit_mm2 * (1.0 + slack) || CONVERGENCE.is_small_step(change) {
                return self.take(next, change, prediction, misfit_mm2 - after_mm2);
            }
        }
        self.is_straight = false;
        if let Some((share, state)) =
            best.and_then(|best| part_of_step(self.problem, &self.state, best, self.seen.measurement, misfit_mm2))
        {
            self.arrive_at(state)?;
            self.reach.take_part(prediction, share);
            (self.is_settled, self.last_change) = (false, f64::INFINITY);
            return Ok(self.history.meets(&self.state).then_some(End::Met));
        }
        self.reach.refuse(prediction, followed.err());
        Ok(None)
    }

    /// Computes a step within the trust region.
    fn within_reach(&mut self, whole: Prediction) -> Result<Prediction, SensingError> {
        if self.reach.contains(whole) {
            return Ok(whole);
        }
        self.is_straight = false;
        self.reach.shortened(|damping| self.state.solve(self.seen.measurement, damping))
    }

    /// Accepts a complete step.
    fn take(
        &mut self,
        next: State,
        change: f64,
        prediction: Prediction,
        decrease_mm2: f64,
    ) -> Result<Option<End>, SensingError> {
        self.arrive_at(next)?;
        if self.is_settled && CONVERGENCE.is_small_step(change) {
            return Ok(Some(End::Minimum(0)));
        }
        if self.history.meets(&self.state) {
            return Ok(Some(End::Met));
        }
        self.last_change = if self.is_settled { change } else { f64::INFINITY };
        let is_good = self.reach.take(prediction, decrease_mm2, self.is_settled);
        self.is_straight &= is_good || change <= MAY_BE_NEAR;
        Ok(None)
    }

    fn arrive_at(&mut self, state: State) -> Result<(), SensingError> {
        self.state = state;
        linearise(self.problem, &mut self.state)?;
        self.state.weigh(self.seen);
        Ok(())
    }
}
