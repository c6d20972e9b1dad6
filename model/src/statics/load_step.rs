//! Decisions of Newton's method in one load step: convergence, acceptance and rejection.
//!
//! The decisions are separate from the equations, so the scalar solver and each SIMD lane of a [batch](super::equilibria) decide by the same code.

/// A solution with fewer correct decimal digits than this number is rejected. Four digits suffice, because the tightest tolerance of a comparison is
/// 0.01 %.
pub(super) const FEWEST_DIGITS: f64 = 4.0;
/// Newton's method has converged when the predicted energy norm of its *next* correction is below this share of the solution's energy norm. The last
/// two corrections predict the next one, because Newton's method squares the error near the solution: e' = c e^2.
pub(super) const CORRECTION_TOLERANCE: f64 = 1e-11;
/// A linear solution has converged when its last correction is at most this share of the solution.
const LINEAR_TOLERANCE: f64 = 1e-8;
/// The next correction is predicted only if the last two corrections are at most this share of the solution.
const QUADRATIC_RANGE: f64 = 1e-2;
/// Two successive corrections below this share of the solution count as rounding noise if each is larger than a quarter of the correction before it.
/// Very fine meshes and needle-shaped fingers show such noise. One correction is not enough: it may be large by chance and leave an error of 1e-7,
/// although the noise is 1e-9.
const STAGNATION_TOLERANCE: f64 = 1e-6;
/// Largest number of Newton iterations in a load step. A step that needs more iterations is rejected as too long.
const MAX_ITERATIONS: usize = 20;
/// Largest rotation of a node in one load step, rad. A larger rotation may lead to another branch of equilibria, so the step is rejected.
const MAX_STEP_ROTATION: f64 = 0.8;
/// A step is rejected if a rotation deviates by more than this limit from the prediction by the tangent at the start of the step. The limit is a
/// share of the largest predicted rotation. On a smooth path, every sufficiently short step satisfies this limit; a snap to another branch rarely
/// satisfies it. Among 9715 accepted equilibria of random fingers under random loads, 22 lie beyond a limit load according to the arc-length method.
const MAX_PREDICTION_ERROR: f64 = 0.5;
/// Rotations up to this angle, rad, count as zero. In a frame that only elongates, rounding causes such rotations.
const ROTATION_NOISE: f64 = 1e-9;
/// An iteration is abandoned if the prediction error exceeds its limit by more than this factor.
const HOPELESS: f64 = 1.25;

/// Result of an accepted load step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Taken {
    /// Number of Newton corrections in the step.
    pub iterations: usize,
    /// The larger of two ratios, 0..1, dimensionless: the largest rotation of a node to its limit, and the prediction error to its limit.
    pub used: f64,
    /// Energy norm of the last correction, as a share of the solution's norm. `None` if the iteration limit was reached.
    pub correction: Option<f64>,
}

/// Reason for a rejected load step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rejected {
    NotPositiveDefinite,
    /// The step is too long. The field is the larger of two ratios: rotation to its limit, and prediction error to its limit; `None` if unknown.
    TooFar(Option<f64>),
    /// Linear corrections do not shrink. The field is the number of correct digits, which is below the required number.
    Rounding(f64),
}

/// State of Newton's iteration at one load level.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoadStep {
    linear: bool,
    /// Tolerance of the energy norm of the predicted next correction, as a share of the solution's norm.
    tolerance: f64,
    /// Number of corrections judged so far.
    iterations: usize,
    /// Energy norm of the last correction, as a share of the solution's norm.
    previous: f64,
    /// Whether the last correction was small but shrank too little, which is typical of rounding noise.
    stagnated: bool,
    /// Largest rotation of a node by the first correction, rad. The first correction is the motion that the tangent at the start of the step
    /// predicts.
    predicted_turn: f64,
}

impl LoadStep {
    pub(super) fn new(linear: bool, tolerance: f64) -> LoadStep {
        LoadStep { linear, tolerance, iterations: 0, previous: f64::INFINITY, stagnated: false, predicted_turn: 0.0 }
    }

    /// Whether the next correction is the first one of the step.
    pub(super) fn is_first(&self) -> bool {
        self.iterations == 0
    }

    /// Judges a correction. Returns `None` to continue, otherwise the result of the step. `work` and `scale` are the squared energy norms of the
    /// correction and of the solution, N mm. `turn` is an angle in rad: for the first correction, the largest rotation of a node; for later
    /// corrections, the largest deviation of a node's rotation from the prediction. `keeps_digits` is as in
    /// [`EquilibriumEquations`](super::EquilibriumEquations::keeps_digits).
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
        // A linear solution needs no further correction by the residual if its factorisation keeps enough digits.
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
