//! The way to the nearest minimum, from any start: the method of Levenberg and Marquardt.

use super::{NonlinearEstimator, SETTLED_ANGLE_DEG, State};
use crate::measurement::Measurement;
use crate::sensing::SensingError;
use crate::statics::StaticsError;

/// Most Gauss-Newton steps; a good start needs three.
const MAX_STEPS: usize = 60;
/// Steps have converged when they change every unknown by less than this share of its scale.
const STEP_TOLERANCE: f64 = 1e-7;
/// Where the finger does not explain the data, markers are weighed anew in every step, and these converge slowly. After
/// [`MAX_STEPS`], changes of less than this share are small enough: no camera would see them.
const SMALL_ENOUGH: f64 = 1e-5;
/// Damping after a step that made things worse; it grows tenfold as long as that goes on.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping beyond which no step helps: the minimum is reached as far as rounding lets it be seen.
const MAX_DAMPING: f64 = 1e8;

impl NonlinearEstimator<'_> {
    /// Gauss-Newton steps, each to the equilibrium that belongs to it, damped where they do not help. Returns their
    /// number.
    ///
    /// # Errors
    /// [`SensingError`] if the unknowns are not identifiable, or the steps do not settle.
    pub(super) fn search(
        &mut self,
        state: &mut State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Result<usize, SensingError> {
        self.linearise(state)?;
        state.linearised.weigh(&state.motion, measurement, noise_mm);
        let mut damping = 0.0;
        let (mut iterations, mut last_change) = (0, f64::INFINITY);
        for steps in 1..=MAX_STEPS {
            iterations = steps;
            state.linearised.solve(&state.motion, measurement, damping)?;
            let change = self.relative_change(state);
            let mut next = state.clone();
            let turn_deg = self.advance(&mut next)?;
            let settles = turn_deg <= SETTLED_ANGLE_DEG;
            // Share of a step that the finger does not carry as a whole.
            let mut carried = None;
            let better = match self.statics.shifted(&state.motion, &state.loads, &next.loads) {
                Ok(equilibrium) => {
                    next.motion = equilibrium.motion;
                    // Compared under the same weights: reweighting is not progress.
                    let [before, after] = [&*state, &next].map(|at| state.linearised.misfit(&at.motion, measurement));
                    // A turning normal may make a good step look worse; the next corrects its residual.
                    let slack = if settles { 1e-12 } else { 0.5 };
                    after <= before * (1.0 + slack) || change <= STEP_TOLERANCE
                }
                Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                    carried = Some(converged_fraction);
                    false
                }
                Err(_) => {
                    carried = Some(0.0);
                    false
                }
            };
            if better {
                last_change = if settles { change } else { f64::INFINITY };
                *state = next;
                self.linearise(state)?;
                state.linearised.weigh(&state.motion, measurement, noise_mm);
                damping = if damping > FIRST_DAMPING { 0.1 * damping } else { 0.0 };
                if change <= STEP_TOLERANCE && settles {
                    return Ok(steps);
                }
            } else if damping >= MAX_DAMPING && carried.is_none() {
                return Ok(steps);
            } else if damping >= MAX_DAMPING {
                // The finger does not carry what would explain more.
                break;
            } else {
                // A damping shortens the step of a single unknown by 1 + damping: those that leave it too long are not tried.
                let least = carried.filter(|share| *share > 0.0).map_or(0.0, |share| (1.0 + damping) / share - 1.0);
                damping = f64::max(10.0 * damping, FIRST_DAMPING);
                while damping < least.min(MAX_DAMPING) {
                    damping *= 10.0;
                }
            }
        }
        if last_change <= SMALL_ENOUGH {
            return Ok(iterations);
        }
        let forces = state.linearised.step.iter().take(self.questions.len());
        Err(SensingError::NotConverged { iterations, change_n: forces.fold(0.0, |m: f64, x| m.max(x.abs())) })
    }

    /// Factors the tangent at a state and derives the shape by the unknowns.
    fn linearise(&mut self, state: &mut State) -> Result<(), SensingError> {
        if !self.statics.linearise(&state.motion, &state.loads) {
            return Err(SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 }));
        }
        self.differentiate(state)
    }
}
