//! The way from one equilibrium to another, in load steps that adapt themselves.
//!
//! A step is as long as the rules of Newton's method allowed the one before it to be. Where the branch of stable
//! equilibria ends, it is approached in steps that its predicted end sets ([`limit`](super::limit)), and the last
//! equilibrium before it is reported.

use super::limit::Approach;
use super::load_step::{CORRECTION_TOLERANCE, Rejected};
use super::newton::{Equilibrium, Statics};
use super::{EquilibriumEquations, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion};

/// Of what the rules allow, steps are made to use this share.
const AIM: f64 = 0.75;
/// A step is at most so many times as long as the one before it.
const GROWTH: f64 = 3.0;
/// A step whose rejection says how much too long it was is shortened to no less than this share.
const LEAST_SHARE: f64 = 0.01;
/// Tolerance of equilibria on the way: the next step corrects what is left, which must not count beside a short step.
const STATION_TOLERANCE: f64 = 1e-8;
/// Tolerance of all equilibria on a way that is a trial: Newton's corrections shrink by so much at once that these are good to 1e-9.
const TRIED_TOLERANCE: f64 = 1e-6;
/// Where a step as short as this share of the way fails, it may be for too fine a mesh.
const SHORT_STEP: f64 = 1e-3;
/// Smallest step that is tried where no end of the branch can be told, as a share of the whole way.
const LEAST_STEP: f64 = 1e-7;
/// The same of a way that is a trial.
const LEAST_TRIED_STEP: f64 = 0.02;
/// A way that is a trial ends no earlier than after so many rejected steps where none was taken yet.
const MOST_REJECTED_AT_START: usize = 4;
/// A path that has taken so many steps is given up.
const MOST_STEPS: usize = 2000;

/// Loads that change along a way, from share 0 to share 1.
pub(super) trait LoadPath {
    /// The loads at a share of the way, and their common multiple.
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64);

    /// Whether an equilibrium on the way, at this share of it, is worth going on from.
    fn goes_on(&mut self, _share: f64, _motion: &FrameMotion) -> bool {
        true
    }

    /// Whether a step that was rejected is tried again, shorter; `rejected` counts those of the whole way.
    fn tries_again(&self, _share: f64, _rejected: usize) -> bool {
        true
    }

    /// Tolerance of the equilibrium at a share of it.
    fn tolerance(&self, share: f64) -> f64 {
        if share < 1.0 { STATION_TOLERANCE } else { CORRECTION_TOLERANCE }
    }

    /// Whether the caller shortens the way where it fails: where exactly does not matter then.
    fn is_trial(&self) -> bool {
        false
    }
}

/// The same loads between two multiples.
#[derive(Clone, Copy)]
pub(super) struct Growing<'l> {
    pub loads: &'l [FrameLoad],
    pub from: f64,
    pub to: f64,
}

impl Growing<'_> {
    pub(super) fn multiple(&self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }
}

impl LoadPath for Growing<'_> {
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64) {
        (self.loads, self.multiple(share))
    }
}

/// Loads that fade while others grow.
pub(super) struct Shifting<'l> {
    pub from: &'l [FrameLoad],
    pub to: &'l [FrameLoad],
    /// Room for both.
    pub loads: Vec<FrameLoad>,
}

impl LoadPath for Shifting<'_> {
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64) {
        self.loads.clear();
        if share < 1.0 {
            self.loads.extend(self.from.iter().map(|load| load.scaled(1.0 - share)));
        }
        self.loads.extend(self.to.iter().map(|load| load.scaled(share)));
        (&self.loads, 1.0)
    }
}

/// Loads that fade while others grow, for a caller who shortens the way where it fails.
pub(super) struct Tried<'l, W> {
    pub shifting: Shifting<'l>,
    pub goes_on: W,
    /// The way ends at so many rejected steps.
    pub most_rejected: usize,
}

impl<W: FnMut(f64, &FrameMotion) -> bool> LoadPath for Tried<'_, W> {
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64) {
        self.shifting.at(share)
    }

    fn goes_on(&mut self, share: f64, motion: &FrameMotion) -> bool {
        (self.goes_on)(share, motion)
    }

    fn tries_again(&self, share: f64, rejected: usize) -> bool {
        rejected < if share > 0.0 { self.most_rejected } else { MOST_REJECTED_AT_START.max(self.most_rejected) }
    }

    fn tolerance(&self, _share: f64) -> f64 {
        TRIED_TOLERANCE
    }

    fn is_trial(&self) -> bool {
        true
    }
}

impl<E: EquilibriumEquations> Statics<E> {
    /// Follows equilibria from `start` to the end of the way.
    pub(super) fn follow(&mut self, start: &FrameMotion, mut path: impl LoadPath) -> Result<Equilibrium, StaticsError> {
        let linear = self.equations.kinematics() == Kinematics::Linear;
        let least_step = if path.is_trial() { LEAST_TRIED_STEP } else { LEAST_STEP };
        let mut motion = start.clone();
        // The last equilibrium on the way, if it is not the start.
        let mut before: Option<FrameMotion> = None;
        let (mut done, mut step) = (0.0, 1.0);
        let (mut iterations, mut load_steps) = (0, 0);
        // Where every step succeeds, nobody asks for the end.
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
            match self.load_step(&mut motion, loads, multiple, tolerance) {
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
