//! Continuation from one equilibrium to another in adaptive load steps.
//!
//! The rotations in a load step determine the largest length that this step could have had. The length of the next step follows from this largest
//! length. Near the predicted end of the stable branch, the prediction limits the length of a load step ([`limit`](super::limit)).

use super::limit::Approach;
use super::load_path::{LoadPath, LoadTransition, ProportionalLoading, TrialTransition};
use super::load_step::Rejected;
use super::newton::{Equilibrium, Newton, Statics};
use super::{EquilibriumEquations, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion};

/// Intended length of a load step, as a share of the largest allowed length.
const AIM: f64 = 0.75;
/// After an accepted load step, the next step is longer by at most this factor.
const GROWTH: f64 = 3.0;
/// A rejected step is shortened to no less than this share of its length, even if the rejection states that the step was far too long.
const LEAST_SHARE: f64 = 0.01;
/// If a step shorter than this share of the path fails, rounding in too fine a mesh may be the cause.
const SHORT_STEP: f64 = 1e-3;
/// Lower limit of the step length, as a share of the path. A path that needs a shorter step ends with an error.
const LEAST_STEP: f64 = 1e-7;
/// Lower limit of the step length on a trial path, as a share of the path. A trial that needs a shorter step fails.
const LEAST_TRIED_STEP: f64 = 0.02;
/// Largest number of load steps along a path. A path that needs more steps ends with an error.
const MOST_STEPS: usize = 2000;

impl<E: EquilibriumEquations> Statics<E> {
    /// Computes the equilibrium under dead loads by continuation from rest.
    ///
    /// # Errors
    /// [`StaticsError`] if a load is not finite, the branch of stable equilibria ends before the full load, or rounding leaves too few digits.
    pub fn equilibrium(&mut self, loads: &[FrameLoad]) -> Result<Equilibrium, StaticsError> {
        self.continued(&self.equations.at_rest(), loads, 0.0, 1.0)
    }

    /// Equilibria under the given multiples of the loads. Continuation leads from rest to the first equilibrium, and from each equilibrium to the
    /// next.
    ///
    /// Stops at the first multiple without an equilibrium. Returns the equilibria of the preceding multiples, and the error.
    pub fn path(&mut self, loads: &[FrameLoad], multiples: &[f64]) -> (Vec<Equilibrium>, Option<StaticsError>) {
        let mut found: Vec<Equilibrium> = Vec::with_capacity(multiples.len());
        let mut motion = self.equations.at_rest();
        let mut from = 0.0;
        for &to in multiples {
            match self.continued(&motion, loads, from, to) {
                Ok(equilibrium) => {
                    motion.clone_from(&equilibrium.motion);
                    found.push(equilibrium);
                    from = to;
                }
                Err(error) => return (found, Some(error)),
            }
        }
        (found, None)
    }

    /// Equilibrium under `to` times the loads. The path begins at `start`, the equilibrium under `from` times the loads.
    ///
    /// # Errors
    /// [`StaticsError`] as for [`equilibrium`](Statics::equilibrium). The converged fraction in the error is the last converged multiple of the
    /// loads, divided by `to`.
    pub fn continued(
        &mut self,
        start: &FrameMotion,
        loads: &[FrameLoad],
        from: f64,
        to: f64,
    ) -> Result<Equilibrium, StaticsError> {
        if !loads.iter().all(FrameLoad::is_finite) || !from.is_finite() || !to.is_finite() {
            return Err(StaticsError::LoadNotFinite);
        }
        let loading = ProportionalLoading { loads, from, to };
        let found = self.follow(start, loading);
        let Err(StaticsError::NoEquilibrium { converged_fraction }) = found else { return found };
        Err(StaticsError::NoEquilibrium { converged_fraction: loading.multiple(converged_fraction) / to })
    }

    /// Equilibrium under the loads given by `to`. The path begins at `start`, the equilibrium under the loads given by `from`. Along the path, the
    /// loads of `from` decrease linearly to zero and the loads of `to` increase linearly from zero.
    ///
    /// # Errors
    /// [`StaticsError`] as for [`equilibrium`](Statics::equilibrium). The converged fraction in the error is the completed share of the path, 0..1.
    pub fn shifted(
        &mut self,
        start: &FrameMotion,
        from: &[FrameLoad],
        to: &[FrameLoad],
    ) -> Result<Equilibrium, StaticsError> {
        if !from.iter().chain(to).all(FrameLoad::is_finite) {
            return Err(StaticsError::LoadNotFinite);
        }
        self.follow(start, LoadTransition { from, to, loads: Vec::with_capacity(from.len() + to.len()) })
    }

    /// Follows the path of [`shifted`](Statics::shifted) as a trial, for a caller that shortens the path if the trial fails. The trial does not
    /// locate the end of a branch exactly. The trial ends without a result after `most_rejected` rejected steps, or at an equilibrium that `goes_on`
    /// rejects.
    ///
    /// # Errors
    /// [`StaticsError`] as for [`equilibrium`](Statics::equilibrium). The converged fraction in the error is the completed share of the path, 0..1.
    pub(crate) fn tried(
        &mut self,
        start: &FrameMotion,
        [from, to]: [&[FrameLoad]; 2],
        most_rejected: usize,
        goes_on: impl FnMut(f64, &FrameMotion) -> bool,
    ) -> Result<Equilibrium, StaticsError> {
        if !from.iter().chain(to).all(FrameLoad::is_finite) {
            return Err(StaticsError::LoadNotFinite);
        }
        let transition = LoadTransition { from, to, loads: Vec::with_capacity(from.len() + to.len()) };
        self.follow(start, TrialTransition { transition, goes_on, most_rejected })
    }

    /// Follows equilibria from `start` to the end of the path.
    fn follow(&mut self, start: &FrameMotion, mut path: impl LoadPath) -> Result<Equilibrium, StaticsError> {
        let linear = self.equations.kinematics() == Kinematics::Linear;
        let least_step = if path.is_trial() { LEAST_TRIED_STEP } else { LEAST_STEP };
        let mut motion = start.clone();
        // The last equilibrium on the path; `None` before the first step.
        let mut before: Option<FrameMotion> = None;
        let (mut done, mut step) = (0.0, 1.0);
        let (mut iterations, mut load_steps) = (0, 0);
        // Predicts the end of the branch. The prediction is created only at the first rejected step, because earlier steps do not need it.
        let mut approach: Option<Approach> = None;
        let (mut failed_since, mut digits_checked, mut rejected) = (false, false, 0);
        while done < 1.0 {
            if load_steps == MOST_STEPS {
                return Err(StaticsError::NoEquilibrium { converged_fraction: done });
            }
            let mut target = f64::min(done + step, 1.0);
            let mut is_beyond = false;
            if let Some(approach) = &mut approach {
                if approach.asks_for(done) {
                    let (loads, multiple) = path.at(done);
                    if self.equations.linearise(&motion, loads, multiple) {
                        approach.add(done, self.equations.log_determinant());
                        self.equations.correct(&mut motion);
                        before.get_or_insert_with(|| start.clone()).clone_from(&motion);
                        iterations += 1;
                    }
                }
                if path.is_trial() && approach.ends_before(1.0) {
                    return Err(StaticsError::NoEquilibrium { converged_fraction: done });
                }
                if let Some(beyond) = approach.beyond() {
                    (target, is_beyond) = (beyond.min(1.0), true);
                } else if let Some(near) = approach.near() {
                    target = target.min(near.max(done + LEAST_STEP));
                }
            }
            let taken = target - done;
            let tolerance = path.tolerance(target);
            let (loads, multiple) = path.at(target);
            // Near the end of the branch, only the exact tangent shows whether an equilibrium is stable.
            let newton = if approach.is_none() { Newton::Mixed } else { Newton::Exact };
            match self.load_step(&mut motion, loads, multiple, tolerance, newton) {
                Ok(found) => {
                    done = target;
                    if done < 1.0 {
                        if !path.goes_on(done, &motion) {
                            return Err(StaticsError::NoEquilibrium { converged_fraction: done - taken });
                        }
                        before.get_or_insert_with(|| start.clone()).clone_from(&motion);
                    }
                    iterations += found.iterations;
                    load_steps += 1;
                    step = taken * (AIM / found.used).clamp(0.5, if failed_since { 1.0 } else { GROWTH });
                    failed_since = false;
                    approach = approach.filter(|approach| !approach.is_disproved_by(done));
                }
                Err(Rejected::NotPositiveDefinite) if linear => return Err(StaticsError::NotHeld),
                Err(Rejected::Rounding(digits)) => return Err(StaticsError::TooFewDigits { digits }),
                Err(why) => {
                    let ends = is_beyond || taken < 2.0 * least_step;
                    if (ends || taken < SHORT_STEP) && !digits_checked && start.is_at_rest() {
                        self.require_digits_at_rest(path.at(1.0).0)?;
                        digits_checked = true;
                    }
                    rejected += 1;
                    if ends || !path.tries_again(done, rejected) {
                        return Err(StaticsError::NoEquilibrium { converged_fraction: done });
                    }
                    motion.clone_from(before.as_ref().unwrap_or(start));
                    approach.get_or_insert_default();
                    failed_since = true;
                    step = taken
                        * match why {
                            Rejected::TooFar(Some(used)) => (AIM / used).clamp(LEAST_SHARE, 0.5),
                            _ => 0.5,
                        };
                }
            }
        }
        Ok(Equilibrium { motion, iterations, load_steps })
    }
}
