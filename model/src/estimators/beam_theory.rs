//! The error of beam theory in sensed forces, and estimators that include it.

use super::{Estimator, EstimatorError, EstimatorId, PreparedEstimator, Sensed};
use crate::measurement::Measurement;
use crate::sensing::Contact;

/// Error of beam theory in a marker coordinate, relative to the largest displacement, as a multiple of the relative error of the sensed force. Fitted to
/// plane continua of two fingers, `paper` and `thick` in `fixtures/calculix`: the residual is 0.13 % (root mean square) if the force is wrong by 0.38 %.
const MODEL_ERROR_OF_MARKERS: f64 = 0.34;

/// Relative standard deviation of a sensed force due to the errors of beam theory, dimensionless, zero or more; `model_error` in `[finger]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamTheoryError(pub f64);

impl BeamTheoryError {
    /// Adds the error of beam theory to the errors of the markers. `noise_mm` is the standard deviation of a marker of weight 1. Returns the measurement
    /// with new weights, and the new standard deviation of a marker of weight 1. Unknown and zero noise remain.
    pub(crate) fn in_markers(self, measurement: Measurement, noise_mm: Option<f64>) -> (Measurement, Option<f64>) {
        let Some((noise_mm, model_mm)) = self.of_markers_mm(&measurement, noise_mm) else {
            return (measurement, noise_mm);
        };
        let both_mm = noise_mm.hypot(model_mm);
        let weighted = measurement.with_markers(|marker| {
            marker.weight = both_mm / (noise_mm / marker.weight).hypot(model_mm);
        });
        (weighted, Some(both_mm))
    }

    /// The noise and the error of beam theory in a marker coordinate, mm, if both are above zero.
    fn of_markers_mm(self, measurement: &Measurement, noise_mm: Option<f64>) -> Option<(f64, f64)> {
        let largest_mm = measurement.markers().iter().map(|marker| marker.displacement.norm()).fold(0.0, f64::max);
        let model_mm = MODEL_ERROR_OF_MARKERS * self.0 * largest_mm;
        noise_mm.filter(|noise_mm| model_mm > 0.0 && *noise_mm > 0.0).map(|noise_mm| (noise_mm, model_mm))
    }
}

/// An estimator whose standard deviations include the error of beam theory, as those of a [`Sensor`](crate::sensor::Sensor) do. The markers have equal
/// weights.
pub struct WithBeamTheoryError<'e> {
    estimator: Box<dyn Estimator + 'e>,
    error: BeamTheoryError,
}

impl<'e> WithBeamTheoryError<'e> {
    /// Adds an error to an estimator. Without an error, the estimator remains as it is.
    pub fn around(estimator: Box<dyn Estimator + 'e>, error: BeamTheoryError) -> Box<dyn Estimator + 'e> {
        match error.0 > 0.0 {
            true => Box::new(WithBeamTheoryError { estimator, error }),
            false => estimator,
        }
    }
}

impl Estimator for WithBeamTheoryError<'_> {
    fn id(&self) -> EstimatorId {
        self.estimator.id()
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        let estimator = self.estimator.prepare(contacts, markers)?;
        Ok(Box::new(Prepared { estimator, error: self.error }))
    }

    fn for_many(&self, finger_is_linear: bool) -> Option<Box<dyn Estimator + '_>> {
        let estimator = self.estimator.for_many(finger_is_linear)?;
        Some(Box::new(WithBeamTheoryError { estimator, error: self.error }))
    }
}

/// The prepared estimator of [`WithBeamTheoryError`].
struct Prepared<'a> {
    estimator: Box<dyn PreparedEstimator + 'a>,
    error: BeamTheoryError,
}

impl Prepared<'_> {
    fn noise_mm(&self, measurement: &Measurement, noise_mm: Option<f64>) -> Option<f64> {
        self.error
            .of_markers_mm(measurement, noise_mm)
            .map(|(noise_mm, model_mm)| noise_mm.hypot(model_mm))
            .or(noise_mm)
    }
}

impl PreparedEstimator for Prepared<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let noise_mm = self.noise_mm(measurement, noise_mm);
        let mut sensed = self.estimator.estimate(measurement, noise_mm)?;
        let share = self.error.0;
        for (sigma_n, force_n) in sensed.sigmas_n.iter_mut().flatten().zip(&sensed.forces_n) {
            *sigma_n = sigma_n.hypot(share * force_n);
        }
        // The error of beam theory is a common factor of all forces.
        let sum_n: f64 = sensed.forces_n.iter().sum();
        sensed.sum_sigma_n = sensed.sum_sigma_n.map(|sigma_n| sigma_n.hypot(share * sum_n));
        Ok(sensed)
    }

    fn expect_samples_of(&mut self, noise_free: &Measurement, noise_mm: f64, samples: usize) {
        let noise_mm = self.noise_mm(noise_free, Some(noise_mm)).unwrap_or(noise_mm);
        self.estimator.expect_samples_of(noise_free, noise_mm, samples);
    }

    fn expect_forces(&mut self, forces_n: &[f64]) {
        self.estimator.expect_forces(forces_n);
    }
}
