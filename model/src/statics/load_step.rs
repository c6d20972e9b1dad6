//! The decisions of Newton's method in one load step: has it converged, is the step taken.
//!
//! They are apart from the equations so that one load, and each lane of a [batch](super::equilibria), follow the same.

/// Solutions with fewer digits are refused: 0.01 % is what the finest results are compared to.
pub(super) const FEWEST_DIGITS: f64 = 4.0;
/// Newton has converged when the energy norm of its *next* correction would be below this share of the solution's. The
/// next correction is known from the last two: near the solution Newton squares the error, e' = c e^2.
pub(super) const CORRECTION_TOLERANCE: f64 = 1e-11;
/// A linear solution that its residual corrects by less than this share has all its digits after that correction.
const LINEAR_TOLERANCE: f64 = 1e-8;
/// Corrections above this share of the solution are too large to conclude anything from.
const QUADRATIC_RANGE: f64 = 1e-2;
/// Two corrections this small, of which neither is a fourth of the one before it, are rounding noise of a fine mesh or of
/// a needle. One alone may be large by chance: of needles it left errors of 1e-7 where noise is 1e-9.
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

/// A load step that was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Taken {
    pub iterations: usize,
    /// How near it came to what a step may turn, and to how far it may end from its prediction: 0..1.
    pub used: f64,
    /// Energy norm of the last correction, as a share of the solution's; `None` if it was the last that was allowed.
    pub correction: Option<f64>,
}

/// Why a load step was not taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rejected {
    NotPositiveDefinite,
    /// Holds how many times too far, where that is known.
    TooFar(Option<f64>),
    /// Linear corrections do not shrink: too few digits are left. Holds their number.
    Rounding(f64),
}

/// Newton's iteration at one load level.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoadStep {
    linear: bool,
    /// It has converged when the next correction would be below this share of the solution.
    tolerance: f64,
    /// Corrections judged.
    iterations: usize,
    /// Energy norm of the last correction, as a share of the solution's.
    previous: f64,
    /// Whether it was rounding noise, by its size.
    stagnated: bool,
    /// Largest turn of a node by the first correction, rad: what the tangent at the start predicts.
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

    /// Judges a correction: goes on (`None`), or ends the step. `work` is the correction's squared energy norm, `scale` the
    /// solution's; `turn` is how far any node is from where it was before the first correction (at the first one), or from
    /// where that has brought it (later), rad. `keeps_digits` says whether a linear correction loses none.
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
        // One correction by the residual is all that a linear solution needs, if any.
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
