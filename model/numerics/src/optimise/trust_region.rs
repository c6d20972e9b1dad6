//! Trust region: the largest length of the steps of a search.

/// The trust region may grow if the ratio of actual to predicted decrease of the sum of squares is at least this.
const GOOD: f64 = 0.75;
/// The trust region shrinks if the ratio of actual to predicted decrease of the sum of squares is below this.
const POOR: f64 = 0.25;
/// Size to which the trust region grows after a good step, as a multiple of the step's reach ([`Prediction::reach`]).
const FURTHER: f64 = 3.0;
/// Size to which the trust region shrinks after a poor step, as a multiple of the step's reach ([`Prediction::reach`]).
const LESS_FAR: f64 = 0.5;
/// If a step succeeds only in part, the trust region shrinks to the succeeded share of the step's reach, limited to this range of shares.
const AFTER_FAILURE: [f64; 2] = [0.1, 0.5];
/// Share of the step's reach to which the trust region shrinks if the full step succeeded but increased the sum of squares.
const AFTER_WORSE: f64 = 0.25;
/// First size of the trust region, as a share of the norm of the residuals before any step.
const FIRST_REACH: f64 = 0.5;
/// Smallest useful size of the trust region, as a share of the norm of the residuals before any step. In a smaller region, no step helps.
const SHORTEST: f64 = 1e-12;
/// First damping that the search for the first step tries.
const FIRST_DAMPING: f64 = 1e-3;
/// Range of the damping.
const DAMPINGS: [f64; 2] = [1e-10, 1e12];
/// Factor between two successive trials of the damping.
const DAMPING_FACTOR: f64 = 4.0;

/// Decrease that the linearised problem predicts for a step, and length of the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Predicted decrease of the sum of squares, in the squared unit of the residuals.
    pub decrease: f64,
    /// Length of the step in the unit of the residuals: root of the sum of |dr_k|^2 over the unknowns k. dr_k is the change of the residual vector if
    /// only unknown k takes the step.
    pub reach: f64,
}

/// The largest allowed reach of a step, adapted to the quality of the previous steps.
///
/// # Reference
/// Nocedal and Wright, Numerical Optimization, 2nd ed.: algorithm 4.1 for the region, sec. 10.3 for the damping that leads to a given reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrustRegion {
    /// Largest reach that a step may have.
    longest: f64,
    /// Reach below which no step helps.
    shortest: f64,
    /// Damping of the last step.
    damping: f64,
}

impl TrustRegion {
    /// A trust region for a problem of the given scale: the norm of the residuals before any step.
    pub fn of_scale(scale: f64) -> TrustRegion {
        TrustRegion { longest: FIRST_REACH * scale, shortest: SHORTEST * scale, damping: FIRST_DAMPING }
    }

    /// Whether the region is so small that no step helps: the minimum is reached within rounding.
    #[inline]
    pub fn is_exhausted(&self) -> bool {
        self.longest <= self.shortest
    }

    /// Whether the reach of a step lies within the region.
    #[inline]
    pub fn contains(&self, prediction: Prediction) -> bool {
        prediction.reach <= self.longest
    }

    /// A step that stays within the region. The damping of the step is within a factor of `DAMPING_FACTOR` of the smallest damping that keeps the
    /// step within the region. The search for the damping begins at the last damping; `solve` returns the step for a damping.
    ///
    /// # Errors
    /// The errors of `solve`.
    pub fn shortened<E>(&mut self, mut solve: impl FnMut(f64) -> Result<Prediction, E>) -> Result<Prediction, E> {
        let [least, most] = DAMPINGS;
        let mut prediction = solve(self.damping)?;
        while self.contains(prediction) && self.damping > least {
            self.damping /= DAMPING_FACTOR;
            prediction = solve(self.damping)?;
        }
        while !self.contains(prediction) && self.damping < most {
            self.damping *= DAMPING_FACTOR;
            prediction = solve(self.damping)?;
        }
        Ok(prediction)
    }

    /// Adapts the region after an accepted step that reduced the sum of squares by `decrease`. Returns whether the decrease was at least `GOOD` times
    /// the predicted decrease. A poor step shrinks the region only if `is_comparable`, because only then the error of linearisation makes the step
    /// poor.
    pub fn take(&mut self, prediction: Prediction, decrease: f64, is_comparable: bool) -> bool {
        let gain = decrease / prediction.decrease;
        if gain >= GOOD {
            self.longest = self.longest.max(FURTHER * prediction.reach);
        } else if gain < POOR && is_comparable {
            self.longest = LESS_FAR * prediction.reach;
        }
        gain >= GOOD
    }

    /// Shrinks the region to the given share of the step, after only that share was accepted.
    #[inline]
    pub fn take_part(&mut self, prediction: Prediction, share: f64) {
        self.longest = share * prediction.reach;
    }

    /// Shrinks the region after a rejected step. `carried` is the share of the step that succeeded; `None` if the full step succeeded but increased the sum of
    /// squares.
    pub fn refuse(&mut self, prediction: Prediction, carried: Option<f64>) {
        let [least, most] = AFTER_FAILURE;
        self.longest = prediction.reach * carried.unwrap_or(AFTER_WORSE).clamp(least, most);
    }
}
