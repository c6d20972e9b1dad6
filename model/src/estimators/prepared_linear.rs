//! Linear estimators that are ready to sense.

use super::{Estimator, EstimatorError, EstimatorId, PreparedEstimator, Sensed};
use crate::Mesh;
use crate::compliance::NodalCompliance;
use crate::measurement::Measurement;
use crate::sensing::{Contact, LinearEstimator, Linearisation, Prior, SensingError};
use nalgebra::{DMatrix, DVector};

/// A linear estimator on a finger that is solved once for all contacts.
pub(super) struct SolvedLinear<'m> {
    pub(super) id: EstimatorId,
    pub(super) solved: NodalCompliance,
    pub(super) prior: Prior,
    pub(super) reference: Option<&'m Mesh>,
}

impl Estimator for SolvedLinear<'_> {
    fn id(&self) -> EstimatorId {
        self.id
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        let estimator = LinearEstimator::on(&self.solved, contacts, markers).or_else(|error| match error {
            // Rounding may spoil a moment where it leaves the force alone.
            SensingError::Statics(_) => LinearEstimator::new(self.solved.finger(), contacts, markers),
            error => Err(error),
        })?;
        Ok(Box::new(Linear::new(estimator, self.prior, contacts, self.reference)))
    }
}

/// A linear estimator that is ready to sense.
pub(super) struct Linear<'m> {
    estimator: LinearEstimator,
    prior: Prior,
    sum: SumSigma,
    linearisation: Option<Linearisation<'m>>,
}

impl<'m> Linear<'m> {
    pub(super) fn new(
        estimator: LinearEstimator,
        prior: Prior,
        contacts: &[Contact],
        reference: Option<&'m Mesh>,
    ) -> Linear<'m> {
        let linearisation = reference.map(|mesh| Linearisation::new(mesh, contacts));
        Linear { sum: SumSigma::of(&estimator, prior), estimator, prior, linearisation }
    }
}

impl PreparedEstimator for Linear<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let estimate = match &mut self.linearisation {
            Some(linearisation) => self.estimator.estimate_on(linearisation, measurement, noise_mm, self.prior)?,
            None => self.estimator.estimate(measurement, noise_mm, self.prior),
        };
        let sum_sigma_n = self.sum.sigma_n(estimate.noise_mm, self.prior);
        let sum_error_n: f64 = estimate.model_error_n.iter().sum();
        Ok(Sensed {
            sum_sigma_n: sum_sigma_n.map(|sigma| sigma.hypot(sum_error_n)),
            warned: estimate.warning.is_some(),
            forces_n: estimate.forces_n,
            sigmas_n: Some(estimate.sigmas_n),
        })
    }
}

/// Standard deviation of the sum of linearly sensed forces: sqrt(1^T P 1) with the covariance of the forces
/// P = s^2 (C^T W^2 C + (s / p)^2)^-1, s the noise and p the prior's standard deviation (infinite for least squares).
struct SumSigma {
    /// C^T W^2 C, mm^2/N^2, beside a prior; `None` where rounding leaves nothing of it.
    information: Option<DMatrix<f64>>,
    /// That of least squares, a noise of 1 mm.
    per_noise: f64,
}

impl SumSigma {
    fn of(estimator: &LinearEstimator, prior: Prior) -> SumSigma {
        // G of full rank with G C = 1: G G^T = (C^T W^2 C)^-1.
        let gain = &estimator.inverse().gain;
        let covariance = gain * gain.transpose();
        let per_noise = covariance.sum().sqrt();
        let information = if prior == Prior::None { None } else { covariance.try_inverse() };
        SumSigma { information, per_noise }
    }

    fn sigma_n(&self, noise_mm: f64, prior: Prior) -> Option<f64> {
        match prior {
            Prior::Gaussian { force_n } if noise_mm > 0.0 && noise_mm.is_finite() => {
                let mut information = self.information.clone()?;
                let ridge = (noise_mm / force_n).powi(2);
                for k in 0..information.nrows() {
                    information[(k, k)] += ridge;
                }
                let ones = DVector::from_element(information.nrows(), 1.0);
                Some(noise_mm * information.cholesky()?.solve(&ones).sum().sqrt())
            }
            _ => Some(noise_mm * self.per_noise),
        }
    }
}
