//! Newton's method: the equilibrium under one load, near the one before it.
//!
//! Every load step must keep the rotations small and end in a stable equilibrium (positive definite tangent), so the
//! solution stays on the branch that starts at rest. How long the steps are is decided in [`load_path`](super::load_path).

use super::digits::{self, FEWEST_DIGITS};
use super::load_path::{Growing, Shifting};
use super::{EquilibriumEquations, Ladder, SparseEquations, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};
use crate::mesh::Mesh;

/// Newton has converged when the energy norm of its *next* correction would be below this share of the solution's. The
/// next correction is known from the last two: near the solution Newton squares the error, e' = c e^2.
pub(super) const CORRECTION_TOLERANCE: f64 = 1e-11;
/// A linear solution that its residual corrects by less than this share has all its digits after that correction.
const LINEAR_TOLERANCE: f64 = 1e-8;
/// Corrections above this share of the solution are too large to conclude anything from.
const QUADRATIC_RANGE: f64 = 1e-2;
/// A correction this small that no longer shrinks is rounding noise of a fine mesh.
const STAGNATION_TOLERANCE: f64 = 1e-6;
/// More iterations than this mean that the step was too long.
const MAX_ITERATIONS: usize = 20;
/// Rotation of a node in one load step, rad, beyond which another branch might be met.
const MAX_STEP_ROTATION: f64 = 0.8;
/// A load step may turn no node further from what the tangent at its start predicts than this share of the largest
/// rotation predicted. On a smooth path that holds for every step that is short enough; a snap to another branch hardly
/// ever passes: of 9715 random loads that random fingers carry, arc length finds 22 to be beyond a limit load.
const MAX_PREDICTION_ERROR: f64 = 0.5;
/// Rotations, rad, that count as none: a frame that only stretches turns by rounding alone.
const ROTATION_NOISE: f64 = 1e-9;
/// A load step whose prediction is off by so many times what is allowed will not come back to it.
const HOPELESS: f64 = 1.25;

/// Equilibrium of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Displacements and rotations.
    pub motion: FrameMotion,
    /// Newton iterations spent, over all load steps.
    pub iterations: usize,
    /// Load steps taken.
    pub load_steps: usize,
}

/// Solver for one structure and one kinematics; what can be prepared once is kept between loads.
#[derive(Debug, Clone)]
pub struct Statics<E> {
    pub(super) equations: E,
    /// Rotations that the tangent at the start of a load step predicts for its end.
    predicted: Vec<f64>,
    /// The last correction of the last load step, as a share of the solution: by energy norm or by displacement, whichever
    /// is more. What is left to correct is less, or as much if it is rounding noise.
    pub(super) last_correction: f64,
}

/// A load step that was taken.
pub(super) struct Taken {
    pub iterations: usize,
    /// How near it came to what a step may turn, and to how far it may end from its prediction: 0..1.
    pub used: f64,
}

/// Why a load step was not taken.
pub(super) enum Rejected {
    NotPositiveDefinite,
    /// Holds how many times too far, where that is known.
    TooFar(Option<f64>),
    /// Linear corrections do not shrink: too few digits are left. Holds their number.
    Rounding(f64),
}

impl<'f> Statics<SparseEquations<'f>> {
    /// Prepares the equations of any frame: the general sparse path.
    pub fn sparse(frame: &'f PlaneFrame, kinematics: Kinematics) -> Self {
        Statics::new(SparseEquations::new(frame, kinematics))
    }
}

impl<'m> Statics<Ladder<'m>> {
    /// Prepares the equations of a finger: block elimination along the ladder.
    pub fn ladder(mesh: &'m Mesh, kinematics: Kinematics) -> Self {
        Statics::new(Ladder::new(mesh, kinematics))
    }
}

impl<E: EquilibriumEquations> Statics<E> {
    fn new(equations: E) -> Self {
        Statics { equations, predicted: Vec::new(), last_correction: f64::INFINITY }
    }

    /// The equations that are solved.
    pub fn equations(&self) -> &E {
        &self.equations
    }

    /// The same, for sensitivities, which need room.
    pub fn equations_mut(&mut self) -> &mut E {
        &mut self.equations
    }

    /// Makes the next linear solution factorise again. Its stiffness never changes, so one factor serves all loads; this
    /// is for timing a factorisation.
    pub fn forget_factor(&mut self) {
        self.equations.forget_factor();
    }

    /// Equilibrium under dead loads, followed from rest.
    ///
    /// # Errors
    /// See [`StaticsError`].
    pub fn equilibrium(&mut self, loads: &[FrameLoad]) -> Result<Equilibrium, StaticsError> {
        self.continued(&self.equations.at_rest(), loads, 0.0, 1.0)
    }

    /// Equilibria under growing multiples of the loads, each followed from the one before it; the first from rest.
    ///
    /// The list ends before the first multiple that has no equilibrium; the second part says why.
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

    /// Equilibrium under `to` times the loads, followed from one under `from` times the loads.
    ///
    /// # Errors
    /// See [`StaticsError`]; the converged fraction refers to `to`.
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
        let growing = Growing { loads, from, to };
        let found = self.follow(start, growing);
        let Err(StaticsError::NoEquilibrium { converged_fraction }) = found else { return found };
        Err(StaticsError::NoEquilibrium { converged_fraction: growing.multiple(converged_fraction) / to })
    }

    /// Equilibrium under the loads `to`, followed from one under the loads `from` while the first fade and the second
    /// grow.
    ///
    /// # Errors
    /// See [`StaticsError`]; the converged fraction is that of the way.
    pub fn shifted(
        &mut self,
        start: &FrameMotion,
        from: &[FrameLoad],
        to: &[FrameLoad],
    ) -> Result<Equilibrium, StaticsError> {
        if !from.iter().chain(to).all(FrameLoad::is_finite) {
            return Err(StaticsError::LoadNotFinite);
        }
        self.follow(start, Shifting { from, to, loads: Vec::with_capacity(from.len() + to.len()) })
    }

    /// Linearises the equations at a motion under loads; `false` if it is not a stable shape.
    pub fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad]) -> bool {
        self.equations.linearise(motion, loads, 1.0)
    }

    /// One correction by Newton's method from a motion near the equilibrium under loads: the largest turn of a node, rad,
    /// or `None` if the motion is no stable shape. Leaves the factored tangent of the motion before the correction behind.
    pub fn corrected(&mut self, motion: &mut FrameMotion, loads: &[FrameLoad]) -> Option<f64> {
        if !self.equations.linearise(motion, loads, 1.0) {
            return None;
        }
        self.predicted.clone_from(&motion.rotations);
        let work = self.equations.correct(motion);
        work.is_finite().then(|| largest_difference(&motion.rotations, &self.predicted))
    }

    /// Newton's iteration at one load level, from the equilibrium before it, until the next correction would be below
    /// `tolerance`. Leaves the factored tangent of the last iterate behind, and `motion` anywhere if the step is rejected.
    pub(super) fn load_step(
        &mut self,
        motion: &mut FrameMotion,
        loads: &[FrameLoad],
        multiple: f64,
        tolerance: f64,
    ) -> Result<Taken, Rejected> {
        let linear = self.equations.kinematics() == Kinematics::Linear;
        self.last_correction = f64::INFINITY;
        let mut previous = f64::INFINITY;
        let mut predicted_turn = 0.0;
        for iteration in 1..=MAX_ITERATIONS {
            if !self.equations.linearise(motion, loads, multiple) {
                return Err(Rejected::NotPositiveDefinite);
            }
            let scale = 2.0 * self.equations.elastic_energy();
            if iteration == 1 && !linear {
                self.predicted.clone_from(&motion.rotations);
            }
            let work = self.equations.correct(motion);
            let mut prediction_error = 0.0;
            if iteration == 1 && !linear {
                // The first correction is what the tangent at the start predicts.
                predicted_turn = largest_difference(&motion.rotations, &self.predicted);
                self.predicted.clone_from(&motion.rotations);
            } else if !linear {
                prediction_error = largest_difference(&motion.rotations, &self.predicted);
            }
            let turned = (predicted_turn + prediction_error) / MAX_STEP_ROTATION;
            let off = prediction_error / (MAX_PREDICTION_ERROR * predicted_turn + ROTATION_NOISE);
            let used = f64::max(turned, off);
            if !linear && (turned.is_nan() || turned > 1.0 || off > HOPELESS) {
                return Err(Rejected::TooFar(Some(used).filter(|used| used.is_finite())));
            }
            if work.is_nan() {
                return Err(if linear { Rejected::NotPositiveDefinite } else { Rejected::TooFar(None) });
            }
            let relative = (work / scale).max(0.0).sqrt();
            let next = relative.powi(3) / (previous * previous);
            let converges = previous.max(relative) <= QUADRATIC_RANGE && next <= tolerance;
            // One correction by the residual is all that a linear solution needs, if any.
            let converges = converges || (linear && (relative <= LINEAR_TOLERANCE || self.equations.keeps_digits()));
            let stagnates = relative <= STAGNATION_TOLERANCE && relative > 0.25 * previous;
            if work <= 0.0 || converges || stagnates {
                let moved = self.equations.largest_correction();
                self.last_correction = relative.max(digits::share(moved, motion.largest_displacement()));
                let follows = linear || used <= 1.0;
                return if follows {
                    Ok(Taken { iterations: iteration, used })
                } else {
                    Err(Rejected::TooFar(Some(used)))
                };
            }
            previous = relative;
        }
        match -previous.log10() {
            _ if !linear => Err(Rejected::TooFar(None)),
            digits if digits >= FEWEST_DIGITS => Ok(Taken { iterations: MAX_ITERATIONS, used: 0.0 }),
            digits => Err(Rejected::Rounding(digits.max(0.0))),
        }
    }

    /// Motions of the linear structure under each load alone: columns of its compliance.
    ///
    /// # Errors
    /// [`StaticsError::NotHeld`] if the structure has no stiffness against some motion.
    pub fn unit_motions(&mut self, loads: &[FrameLoad]) -> Result<Vec<FrameMotion>, StaticsError> {
        loads.iter().map(|load| self.equilibrium(std::slice::from_ref(load)).map(|found| found.motion)).collect()
    }
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
