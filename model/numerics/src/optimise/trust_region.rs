//! How far the steps of a search may reach.

/// Share of the predicted decrease of the sum of squares from which on steps may reach further, and below which less far.
const GOOD: f64 = 0.75;
const POOR: f64 = 0.25;
/// How many times as far steps may reach after a good one, and after a poor one.
const FURTHER: f64 = 3.0;
const LESS_FAR: f64 = 0.5;
/// After a step that failed they reach as far as it was carried, but no less and no more than these shares of it.
const AFTER_FAILURE: [f64; 2] = [0.1, 0.5];
/// The same after a step that was carried to its end and is worse there.
const AFTER_WORSE: f64 = 0.25;
/// How far the first step may reach, and the reach below which no step helps, as shares of a scale of the problem.
const FIRST_REACH: f64 = 0.5;
const SHORTEST: f64 = 1e-12;
/// Damping with which the first is looked for, dampings between which one is, and the factor between two that are tried.
const FIRST_DAMPING: f64 = 1e-3;
const DAMPINGS: [f64; 2] = [1e-10, 1e12];
const DAMPING_FACTOR: f64 = 4.0;

/// What a step does to a linearised problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Decrease of the sum of squares.
    pub decrease: f64,
    /// How far it moves the residuals: root of the sum of squares over unknowns, each unknown's move counted alone.
    pub reach: f64,
}

/// The reach that steps are allowed, by how good the last ones were.
///
/// # Reference
/// Nocedal and Wright, Numerical Optimization, 2nd ed., algorithm 4.1; the damping that a reach needs, sec. 10.3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrustRegion {
    longest: f64,
    shortest: f64,
    damping: f64,
}

impl TrustRegion {
    /// For a problem whose residuals move by `scale` from where it makes sense to begin.
    pub fn of_scale(scale: f64) -> TrustRegion {
        TrustRegion { longest: FIRST_REACH * scale, shortest: SHORTEST * scale, damping: FIRST_DAMPING }
    }

    /// Whether steps are so short that none helps: the minimum is reached as far as rounding lets it be seen.
    #[inline]
    pub fn is_exhausted(&self) -> bool {
        self.longest <= self.shortest
    }

    /// Whether a step stays within it.
    #[inline]
    pub fn contains(&self, prediction: Prediction) -> bool {
        prediction.reach <= self.longest
    }

    /// The step with the smallest damping that stays within, to `DAMPING_FACTOR`, from the last one on, by `solve`.
    ///
    /// # Errors
    /// Those of `solve`.
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

    /// After a step that was taken, with its decrease. Returns whether that was as good as predicted. Only where a poor step
    /// is a fault of the linearised problem, as `is_comparable` says, do steps reach less far after it.
    pub fn take(&mut self, prediction: Prediction, decrease: f64, is_comparable: bool) -> bool {
        let gain = decrease / prediction.decrease;
        if gain >= GOOD {
            self.longest = self.longest.max(FURTHER * prediction.reach);
        } else if gain < POOR && is_comparable {
            self.longest = LESS_FAR * prediction.reach;
        }
        gain >= GOOD
    }

    /// After a share of a step.
    #[inline]
    pub fn take_part(&mut self, prediction: Prediction, share: f64) {
        self.longest = share * prediction.reach;
    }

    /// After a step that was not taken: the share of it that was carried, `None` if it was carried to its end.
    pub fn refuse(&mut self, prediction: Prediction, carried: Option<f64>) {
        let [least, most] = AFTER_FAILURE;
        self.longest = prediction.reach * carried.unwrap_or(AFTER_WORSE).clamp(least, most);
    }
}
