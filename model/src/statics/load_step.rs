//! Decisions of Newton's method in one load step: convergence, acceptance, rejection.
//!
//! They are separate from the equations so that the scalar solver and each lane of a [batch](super::equilibria) share them.

/// Smallest number of correct decimal digits of an accepted solution: the finest results are compared to 0.01 %.
pub(super) const FEWEST_DIGITS: f64 = 4.0;
/// Newton has converged when the predicted energy norm of its *next* correction is below this share of the solution's. The last two
/// corrections predict it, since Newton's method squares the error near the solution, e' = c e^2.
pub(super) const CORRECTION_TOLERANCE: f64 = 1e-11;
/// A linear solution whose last correction is below this share of it has all its digits after that correction.
const LINEAR_TOLERANCE: f64 = 1e-8;
/// Largest correction, as a share of the solution, from which the next one is predicted.
const QUADRATIC_RANGE: f64 = 1e-2;
/// Two successive corrections below this count as rounding noise if each exceeds a quarter of the previous one. Very fine meshes and needle
/// shapes show such noise. A single one may be large by chance and leave an error of 1e-7 where noise is 1e-9.
const STAGNATION_TOLERANCE: f64 = 1e-6;
/// Largest number of Newton iterations in a load step; a step that needs more is rejected as too long.
const MAX_ITERATIONS: usize = 20;
/// Largest rotation of a node in one load step, rad; a larger one may lead to another branch.
const MAX_STEP_ROTATION: f64 = 0.8;
/// Largest deviation of a rotation from the prediction of the tangent at the start, as a share of the largest predicted rotation. On a
/// smooth path every sufficiently short step meets this limit; a snap to another branch rarely does. For random fingers under random
/// loads, arc length finds 22 of 9715 accepted equilibria beyond a limit load.
const MAX_PREDICTION_ERROR: f64 = 0.5;
/// Rotations below this, rad, count as zero: a frame that only elongates rotates by rounding alone.
const ROTATION_NOISE: f64 = 1e-9;
/// Ratio of prediction error to its limit beyond which an iteration is abandoned.
const HOPELESS: f64 = 1.25;

/// Result of an accepted load step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Taken {
    /// Number of Newton corrections.
    pub iterations: usize,
    /// Largest of rotation and prediction error, each divided by its limit; 0..1.
    pub used: f64,
    /// Energy norm of the last correction, as a share of the solution's; `None` if the iterations ran out.
    pub correction: Option<f64>,
}

/// Reason for a rejected load step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rejected {
    NotPositiveDefinite,
    /// The step is too long. Holds the ratio of its rotation or prediction error to the limit, if known.
    TooFar(Option<f64>),
    /// Linear corrections do not shrink. Holds the number of correct digits, which is too small.
    Rounding(f64),
}

/// Newton's iteration at one load level.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoadStep {
    linear: bool,
    /// Convergence tolerance for the predicted next correction, as a share of the solution.
    tolerance: f64,
    /// Number of corrections judged so far.
    iterations: usize,
    /// Energy norm of the last correction, as a share of the solution's.
    previous: f64,
    /// Whether the last correction was small enough and shrank too little, as rounding noise does.
    stagnated: bool,
    /// Largest rotation of a node by the first correction, rad: the prediction of the tangent at the start.
    predicted_turn: f64,
}

impl LoadStep {
    pub(super) fn new(linear: bool, tolerance: f64) -> LoadStep {
        LoadStep { linear, tolerance, iterations: 0, previous: f64::INFINITY, stagnated: false, predicted_turn: 0.0 }
    }

    /// Whether the next correction is the first of the step.
    pub(super) fn is_first(&self) -> bool {
        self.iterations == 0
    }

    /// Judges a correction: `None` to continue, else the end of the step. `work` is the correction's squared energy norm and `scale` the
    /// solution's, both N mm. `turn` is the largest rotation of a node, rad: from the start for the first correction, from the prediction for
    /// later ones. `keeps_digits` states whether a linear correction loses no digits.
    #[inline(always)]
    pub(super) fn judge(
        &mut self,
        work: f64,
        scale: f64,
        turn: f64,
        keeps_digits: impl Fn() -> bool,
    ) -> Option<Result<Taken, Rejected>> {
        let LoadStep { linear, previous, .. } = *self;
        let mut prediction_error = 0.0;
        if self.is_first() {
            self.predicted_turn = turn;
        } else {
            prediction_error = turn;
        }
        self.iterations += 1;
        let turned = (self.predicted_turn + prediction_error) / MAX_STEP_ROTATION;
        let off = prediction_error / (MAX_PREDICTION_ERROR * self.predicted_turn + ROTATION_NOISE);
        let used = f64::max(turned, off);
        if !linear && (turned.is_nan() || turned > 1.0 || off > HOPELESS) {
            return Some(Err(Rejected::TooFar(Some(used).filter(|used| used.is_finite()))));
        }
        if work.is_nan() {
            return Some(Err(if linear { Rejected::NotPositiveDefinite } else { Rejected::TooFar(None) }));
        }
        let relative = (work / scale).max(0.0).sqrt();
        let next = relative.powi(3) / (previous * previous);
        let converges = previous.max(relative) <= QUADRATIC_RANGE && next <= self.tolerance;
        // A linear solution needs at most one correction by the residual.
        let converges = converges || (linear && (relative <= LINEAR_TOLERANCE || keeps_digits()));
        let stagnates = relative <= STAGNATION_TOLERANCE && relative > 0.25 * previous;
        if work <= 0.0 || converges || (stagnates && self.stagnated) {
            let follows = linear || used <= 1.0;
            return Some(if follows {
                Ok(Taken { iterations: self.iterations, used, correction: Some(relative) })
            } else {
                Err(Rejected::TooFar(Some(used)))
            });
        }
        (self.previous, self.stagnated) = (relative, stagnates);
        if self.iterations < MAX_ITERATIONS {
            return None;
        }
        Some(match -relative.log10() {
            _ if !linear => Err(Rejected::TooFar(None)),
            digits if digits >= FEWEST_DIGITS => Ok(Taken { iterations: self.iterations, used: 0.0, correction: None }),
            digits => Err(Rejected::Rounding(digits.max(0.0))),
        })
    }
}
