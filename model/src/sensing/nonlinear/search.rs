//! The way to the nearest minimum, from any start: the method of Levenberg and Marquardt with a trust region.
//!
//! The finger answers a force along a plate hardly at all, until the plate buckles: a step that is good for the linearised
//! finger may lead far away, or where no equilibrium is. So steps reach only as far as the last ones were right, and a
//! step is given up on the way where an equilibrium is worse than its start.

use super::search_history::SearchHistory;
use super::{NonlinearEstimator, Posed, SETTLED_ANGLE_DEG, State};
use crate::frame::FrameMotion;
use crate::measurement::Measurement;
use crate::sensing::SensingError;
use crate::statics::StaticsError;

/// Most steps that are tried; a good start needs three.
const MAX_STEPS: usize = 60;
/// Steps have converged when they change every unknown by less than this share of its scale, ...
const STEP_TOLERANCE: f64 = 1e-7;
/// ... or when no combination of the unknowns is further from its best value than this share of its standard deviation
/// (Bates and Watts, Nonlinear Regression Analysis and Its Applications, sec. 2.2.3, relative offset).
const OFFSET_TOLERANCE: f64 = 1e-2;
/// Where the finger does not explain the data, markers are weighed anew in every step, and these converge slowly. After
/// [`MAX_STEPS`], changes of less than this share are small enough: no camera would see them.
const SMALL_ENOUGH: f64 = 1e-5;
/// After a step that changes every unknown by less than this share, the minimum may be near; if it was not, after one
/// that changes them by a tenth of it.
const MAY_BE_NEAR: f64 = 0.03;
/// An equilibrium on the way of a step with so many times the misfit of its start ends the step.
const WORSE: f64 = 2.0;
/// Decrease of the misfit, as a share of what was predicted, from which on steps may reach further, and below which they
/// reach less far (Nocedal and Wright, Numerical Optimization, algorithm 4.1).
const GOOD: f64 = 0.75;
const POOR: f64 = 0.25;
/// How many times as far steps may reach after a good one, and after a poor one.
const FURTHER: f64 = 3.0;
const LESS_FAR: f64 = 0.5;
/// After a step that failed they reach as far as it was carried, but no less and no more than these shares of it.
const AFTER_FAILURE: [f64; 2] = [0.1, 0.5];
/// The same after a step that the finger carries but that is worse.
const AFTER_WORSE: f64 = 0.25;
/// How far the first step may reach, as a share of what the markers moved.
const FIRST_REACH: f64 = 0.5;
/// Reach, as a share of what the markers moved, below which no step helps: the minimum is reached as far as rounding lets
/// it be seen, or as the finger carries it.
const SHORTEST: f64 = 1e-12;
/// A step ends where the finger was seen to carry it so far when so many shorter ones were rejected on its way.
const MOST_REJECTED: usize = 2;
/// Damping with which the first is looked for.
const FIRST_DAMPING: f64 = 1e-3;

impl NonlinearEstimator<'_> {
    /// Gauss-Newton steps, each to the equilibrium that belongs to it, shortened where they do not help. Returns their
    /// number, and whether the way was straight: every step was whole and as good as predicted.
    ///
    /// # Errors
    /// [`SensingError`] if the unknowns are not identifiable, or the steps do not settle.
    pub(super) fn search(
        &mut self,
        state: &mut State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        ways: &mut SearchHistory,
    ) -> Result<Option<(usize, bool)>, SensingError> {
        self.linearise(state)?;
        let (shape, linearised) = state.split();
        linearised.weigh(shape, measurement, noise_mm);
        let moved_mm = state.linearised.misfit_at_rest(measurement).sqrt();
        let shortest_mm = SHORTEST * moved_mm;
        let (mut longest_mm, mut damping) = (FIRST_REACH * moved_mm, FIRST_DAMPING);
        let (mut settled, mut last_change, mut near) = (false, f64::INFINITY, MAY_BE_NEAR);
        let mut iterations = 0;
        // Whether every step was whole and as good as predicted.
        let mut straight = true;
        while iterations < MAX_STEPS && longest_mm > shortest_mm {
            iterations += 1;
            let before = self.misfit(state, measurement);
            let (shape, linearised) = state.split();
            let mut prediction = linearised.solve(shape, measurement, 0.0)?;
            let variance_mm2 =
                f64::max(noise_mm.unwrap_or(0.0).powi(2), before / measurement.coordinate_count() as f64);
            if settled && ways.ends_far(before, prediction.decrease_mm2) {
                ways.reach(state);
                return Ok(Some((iterations, false)));
            }
            let is_there = settled && prediction.decrease_mm2 <= OFFSET_TOLERANCE * OFFSET_TOLERANCE * variance_mm2;
            if is_there || last_change <= near {
                let mut corrected = state.clone();
                if let Some(steps) = self.correct(&mut corrected, measurement, noise_mm) {
                    *state = corrected;
                    ways.reach(state);
                    return Ok(Some((iterations + steps, straight)));
                }
                near = 0.1 * f64::min(near, last_change);
            }
            if is_there {
                return Ok(Some((iterations, straight)));
            }
            if prediction.reach_mm > longest_mm {
                straight = false;
                let (shape, linearised) = state.split();
                (damping, prediction) = linearised.shorten(shape, measurement, longest_mm, damping)?;
            }
            let change = self.relative_change(state);
            let mut next = state.clone();
            settled = self.advance(&mut next)? <= SETTLED_ANGLE_DEG;
            // Compared under the same weights: reweighting is not progress.
            let (mesh, object, noise_of_rows_mm) = (self.mesh, &self.object, self.priors.noise_mm());
            let misfit = |motion: &_| {
                let shape = Posed { motion, forces_n: &next.forces_n, nuisances: &next.nuisances };
                let touched = object.as_ref().map(|it| it.misfit(mesh, &next.contacts, shape, noise_of_rows_mm));
                state.linearised.misfit(shape, measurement) + touched.unwrap_or_default()
            };
            // The best equilibrium on the way, and its share of the step.
            let mut reached: Option<(f64, f64, FrameMotion)> = None;
            let loads = [&state.loads[..], &next.loads];
            let tried = self.statics.tried(&state.motion, loads, MOST_REJECTED, |share, on_the_way| {
                let there = misfit(on_the_way);
                if there <= reached.as_ref().map_or(before, |best| best.1) {
                    reached = Some((share, there, on_the_way.clone()));
                }
                there <= WORSE * before
            });
            let failed_at = match tried {
                Ok(equilibrium) => {
                    let after = misfit(&equilibrium.motion);
                    next.motion = equilibrium.motion;
                    // A turning normal may make a good step look worse; the next corrects its residual.
                    let slack = if settled { 1e-12 } else { 0.5 };
                    if after <= before * (1.0 + slack) || change <= STEP_TOLERANCE {
                        *state = next;
                        self.linearise(state)?;
                        let (shape, linearised) = state.split();
                        linearised.weigh(shape, measurement, noise_mm);
                        if change <= STEP_TOLERANCE && settled {
                            return Ok(Some((iterations, straight)));
                        }
                        if ways.meets(state) {
                            return Ok(None);
                        }
                        last_change = if settled { change } else { f64::INFINITY };
                        let gain = (before - after) / prediction.decrease_mm2;
                        straight &= gain >= GOOD || change <= MAY_BE_NEAR;
                        if gain >= GOOD {
                            longest_mm = longest_mm.max(FURTHER * prediction.reach_mm);
                        } else if gain < POOR && settled {
                            longest_mm = LESS_FAR * prediction.reach_mm;
                        }
                        continue;
                    }
                    AFTER_WORSE
                }
                Err(StaticsError::NoEquilibrium { converged_fraction }) => converged_fraction,
                Err(_) => 0.0,
            };
            straight = false;
            if let Some((share, _, motion)) = reached
                && let Some(part) = self.part_of_step(state, share, &motion)
                && self.misfit(&part, measurement) <= before
            {
                *state = part;
                self.linearise(state)?;
                let (shape, linearised) = state.split();
                linearised.weigh(shape, measurement, noise_mm);
                if ways.meets(state) {
                    return Ok(None);
                }
                (settled, last_change) = (false, f64::INFINITY);
                longest_mm = share * prediction.reach_mm;
                continue;
            }
            longest_mm = prediction.reach_mm * failed_at.clamp(AFTER_FAILURE[0], AFTER_FAILURE[1]);
        }
        if longest_mm <= shortest_mm || last_change <= SMALL_ENOUGH {
            return Ok(Some((iterations, straight)));
        }
        let forces = state.linearised.step.iter().take(self.questions.len());
        Err(SensingError::NotConverged { iterations, change_n: forces.fold(0.0, |m: f64, x| m.max(x.abs())) })
    }

    /// The state after a share of its step, in the equilibrium that is near a motion; `None` if there is none.
    fn part_of_step(&mut self, state: &State, share: f64, motion: &FrameMotion) -> Option<State> {
        let mut part = state.clone();
        part.linearised.step.iter_mut().for_each(|x| *x *= share);
        self.advance(&mut part).ok()?;
        let loads = [&part.loads[..], &part.loads];
        part.motion = self.statics.tried(motion, loads, 1, |_, _| true).ok()?.motion;
        Some(part)
    }

    /// Factors the tangent at a state and derives the shape by the unknowns.
    fn linearise(&mut self, state: &mut State) -> Result<(), SensingError> {
        if !self.statics.linearise(&state.motion, &state.loads) {
            return Err(SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 }));
        }
        self.differentiate(state)
    }
}
