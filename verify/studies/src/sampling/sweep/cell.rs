//! The cells of a sweep.

use crate::truths::TruthId;
use finray_model::estimators::{EstimatorError, EstimatorId};

/// One force at one position and direction, at one level of noise, on one truth, by one estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The true finger.
    pub truth: TruthId,
    /// The estimator.
    pub estimator: EstimatorId,
    /// Standard deviation of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Results.
    pub outcome: Outcome,
}

/// Results of a cell's noise samples; a single one without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Noise samples; none where the finger has no equilibrium.
    pub samples: usize,
    /// Samples that were answered.
    pub answered: usize,
    /// `None` where fewer than half of the samples were answered: the few are no fair sample.
    pub errors: Option<Errors>,
    /// How often the stated intervals hold; `None` if none are stated, or nothing was answered.
    pub covered: Option<Covered>,
    /// Why the finger or the first sample that was refused gave no answer; `None` if all were answered.
    pub refusal: Option<String>,
}

/// Errors over the answered samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Mean of |sensed / true - 1|.
    pub mean_error: f64,
    /// Mean of sensed / true - 1: what is wrong even without noise.
    pub bias: f64,
    /// Standard deviation of sensed / true over the noise.
    pub spread: f64,
    /// Root mean square of the standard deviations that the estimator states, N; `None` if it states none.
    pub sigma_n: Option<f64>,
}

/// Answered samples by whether the true force lies within 1.96 stated standard deviations, those with a warning apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Covered {
    /// Answers with a warning.
    pub warned: usize,
    /// Answers without a warning whose interval holds the truth.
    pub covered: usize,
    /// Answers with a warning whose interval holds the truth.
    pub covered_warned: usize,
}

impl Cell {
    /// Standard deviation of sensed / true over the noise; `None` where a single noisy sample was answered, or none.
    pub fn spread(&self) -> Option<f64> {
        let known = self.noise_mm == 0.0 || self.outcome.answered > 1;
        self.outcome.errors.filter(|_| known).map(|errors| errors.spread)
    }
}

impl Outcome {
    /// Every sample was drawn, and none answered.
    pub(super) fn refused(samples: usize, error: &EstimatorError) -> Outcome {
        Outcome { samples, answered: 0, errors: None, covered: None, refusal: Some(error.to_string()) }
    }

    pub(super) fn not_carried() -> Outcome {
        let refusal = "the finger that is sensed has no equilibrium under this force".to_owned();
        Outcome { samples: 0, answered: 0, errors: None, covered: None, refusal: Some(refusal) }
    }
}
