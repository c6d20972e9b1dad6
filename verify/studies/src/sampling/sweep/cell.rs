//! Cells of a sweep, each with the results for one force at one position and direction.

use crate::truths::TruthId;
use finray_model::estimators::{EstimatorError, EstimatorId};

/// One force at one position, direction and noise level, on one true finger, sensed by one estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The true finger.
    pub truth: TruthId,
    /// The estimator.
    pub estimator: EstimatorId,
    /// Standard deviation of the noise of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Results over the noise samples.
    pub outcome: Outcome,
}

/// Results over a cell's noise samples; without noise there is a single sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Number of noise samples; 0 if the finger has no equilibrium.
    pub samples: usize,
    /// Number of answered samples.
    pub answered: usize,
    /// Errors of the answered samples; `None` if fewer than half of the samples were answered, because few answers are biased.
    pub errors: Option<Errors>,
    /// Numbers of stated intervals that contain the true force; `None` if the estimator states no intervals, or answered no sample.
    pub covered: Option<Covered>,
    /// Reason why the finger has no equilibrium, or why the first refused sample was refused; `None` if all were answered.
    pub refusal: Option<String>,
}

/// Errors over the answered samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Mean of |sensed / true - 1|, dimensionless.
    pub mean_error: f64,
    /// Mean of sensed / true - 1, dimensionless: the systematic error.
    pub bias: f64,
    /// Standard deviation of sensed / true over the noise samples, dimensionless.
    pub spread: f64,
    /// Root mean square of the standard deviations stated by the estimator, N; `None` if it states none.
    pub sigma_n: Option<f64>,
}

/// Numbers of answers whose interval of 1.96 stated standard deviations contains the true force, with and without a warning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Covered {
    /// Number of answers with a warning.
    pub warned: usize,
    /// Among answers without a warning: the number whose interval contains the true force.
    pub covered: usize,
    /// Among answers with a warning: the number whose interval contains the true force.
    pub covered_warned: usize,
}

impl Cell {
    /// Standard deviation of sensed / true over the noise samples, dimensionless; `None` if fewer than two noisy samples were answered.
    pub fn spread(&self) -> Option<f64> {
        let known = self.noise_mm == 0.0 || self.outcome.answered > 1;
        self.outcome.errors.filter(|_| known).map(|errors| errors.spread)
    }
}

impl Outcome {
    pub(super) fn refused(samples: usize, error: &EstimatorError) -> Outcome {
        Outcome { samples, answered: 0, errors: None, covered: None, refusal: Some(error.to_string()) }
    }

    pub(super) fn not_carried() -> Outcome {
        let refusal = "the true finger has no equilibrium under this force".to_owned();
        Outcome { samples: 0, answered: 0, errors: None, covered: None, refusal: Some(refusal) }
    }
}
