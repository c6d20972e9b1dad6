//! Cells of a sweep, each with the results for one force at one position and direction.

use crate::prelude::*;
use crate::truths::TruthId;

/// One force at one position, direction and noise level, on one true finger, sensed by one estimator. The fields are the columns of
/// [`Table::Sweep`](super::Table::Sweep).
///
/// Errors refer to the answered samples. The errors are `None` if fewer than half of the samples were answered, because the answered samples are then
/// a biased selection. The counts `warned`, `covered` and `covered_warned` are `None` if the estimator states no standard deviations, or answered no
/// sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// Number of noise samples: 1 at the noise level 0, and 0 if the finger has no equilibrium.
    pub samples: usize,
    /// Number of answered samples.
    pub answered: usize,
    /// Mean of |sensed / true - 1| over the samples and over the uncertain stiffness of the scene's finger, dimensionless.
    pub mean_error: Option<f64>,
    /// Mean of sensed / true - 1, dimensionless: the systematic error.
    pub bias: Option<f64>,
    /// Standard deviation of sensed / true over the noise samples, dimensionless. `None` like `mean_error`, or if fewer than two noisy samples were
    /// answered.
    pub spread: Option<f64>,
    /// Root mean square of the standard deviations stated by the estimator, N. `None` like `mean_error`, or if the estimator states no standard
    /// deviations.
    pub sigma_n: Option<f64>,
    /// Reason for missing answers, on one line: the finger has no equilibrium, or the reason of the first refusal. `None` if all samples were answered.
    pub refusal: Option<String>,
    /// Number of answers with a warning.
    pub warned: Option<usize>,
    /// Number of answers without a warning whose interval of 1.96 stated standard deviations contains the true force.
    pub covered: Option<usize>,
    /// Number of answers with a warning whose interval of 1.96 stated standard deviations contains the true force.
    pub covered_warned: Option<usize>,
}
