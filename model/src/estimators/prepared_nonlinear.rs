//! A nonlinear estimator that is ready to sense.

use super::{EstimatorError, PreparedEstimator, Sensed};
use crate::measurement::Measurement;
use crate::sensing::{Discretisation, NonlinearEstimator};

/// A nonlinear estimator that is ready to sense.
pub(super) struct Nonlinear<'m> {
    pub(super) estimator: NonlinearEstimator<'m>,
    pub(super) discretisation: Option<Discretisation<'m>>,
}

impl PreparedEstimator for Nonlinear<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        // A stream's start from the last frame would be too easy: answers must not depend on the order of measurements.
        self.estimator.reset();
        let mut estimate = self.estimator.estimate(measurement, noise_mm)?;
        if let Some(discretisation) = &mut self.discretisation {
            discretisation.widen(&mut self.estimator, measurement, &mut estimate)?;
        }
        Ok(Sensed {
            sum_sigma_n: Some(estimate.covariance_n2.sum().sqrt()),
            warned: estimate.forces.warning.is_some(),
            forces_n: estimate.forces.forces_n,
            sigmas_n: Some(estimate.forces.sigmas_n),
        })
    }

    fn expect_samples_of(&mut self, noise_free: &Measurement, noise_mm: f64, samples: usize) {
        self.estimator.forget();
        // One sample alone has nothing to share.
        if samples < 2 {
            return;
        }
        // Where the model contradicts the measurement there may be several minima, and a start decides between them.
        if self.estimator.estimate(noise_free, Some(noise_mm)).is_ok_and(|found| found.forces.warning.is_none()) {
            self.estimator.hold();
        }
    }
    fn expect_forces(&mut self, forces_n: &[f64]) {
        self.estimator.hold_at(forces_n);
    }
}
