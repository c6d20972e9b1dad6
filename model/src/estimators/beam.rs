//! Estimators based on the beam model.

use super::{Estimator, EstimatorError, EstimatorId, PreparedEstimator, Sensed};
use crate::Mesh;
use crate::measurement::Measurement;
use crate::sensing::{Contact, Discretisation, LinearEstimator, Linearisation, NonlinearEstimator, Prior};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Beam elements per member of the co-rotational mesh that is used to compute the error of linearisation. The discretisation error of this mesh is
/// small compared with the error of linearisation.
const LINEARISATION_ELEMENTS: usize = 2;

/// An estimator on a mesh of the beam model.
#[derive(Debug, Clone)]
pub struct BeamEstimator<'m> {
    id: EstimatorId,
    /// Prior of a linear estimator. `None` for the nonlinear estimator.
    prior: Option<Prior>,
    mesh: &'m Mesh,
    /// Mesh of the co-rotational finger, used to compute the model error. For the nonlinear estimator, this mesh is finer than `mesh`. `None` if the
    /// standard deviations follow from noise alone.
    reference: Option<Arc<Mesh>>,
}

impl<'m> BeamEstimator<'m> {
    /// Linear least squares. For the linear finger, the displacements of the key nodes are exact on any mesh. The standard deviations include the
    /// error of linearisation.
    pub fn least_squares(mesh: &'m Mesh) -> BeamEstimator<'m> {
        BeamEstimator::linear(EstimatorId::LeastSquares, Prior::None, mesh)
    }

    /// Linear least squares with the range of forces of Xu et al. (2021) as a prior. The standard deviations include the error of linearisation.
    pub fn ridge(mesh: &'m Mesh) -> BeamEstimator<'m> {
        BeamEstimator::linear(EstimatorId::Ridge, Prior::PAPER, mesh)
    }

    fn linear(id: EstimatorId, prior: Prior, mesh: &'m Mesh) -> BeamEstimator<'m> {
        let reference = Mesh::with_elements_per_member(mesh.finger(), LINEARISATION_ELEMENTS);
        BeamEstimator { id, prior: Some(prior), mesh, reference: Some(Arc::new(reference)) }
    }

    /// Estimator that uses the Gauss-Newton method on a mesh of the co-rotational finger. The standard deviations include the error of the mesh.
    pub fn nonlinear(mesh: &'m Mesh) -> BeamEstimator<'m> {
        let reference = Some(Arc::new(Discretisation::finer(mesh)));
        BeamEstimator { id: EstimatorId::Nonlinear, prior: None, mesh, reference }
    }

    /// The same estimator with standard deviations that follow from noise alone, as in the Cramer-Rao bound.
    pub fn of_noise_alone(self) -> BeamEstimator<'m> {
        BeamEstimator { reference: None, ..self }
    }
}

impl Estimator for BeamEstimator<'_> {
    fn id(&self) -> EstimatorId {
        self.id
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        match self.prior {
            Some(prior) => {
                let estimator = LinearEstimator::new(self.mesh.finger(), contacts, markers)?;
                let linearisation = self.reference.as_ref().map(|mesh| Linearisation::new(mesh.clone(), contacts));
                Ok(Box::new(Linear { sum: SumSigma::of(&estimator, prior), estimator, prior, linearisation }))
            }
            None => {
                let questions: Vec<_> = contacts.iter().map(|&contact| contact.into()).collect();
                let estimator = NonlinearEstimator::new(self.mesh, &questions)?;
                let discretisation = self.reference.as_ref().map(|finer| Discretisation::new(self.mesh, finer));
                Ok(Box::new(Nonlinear { estimator, discretisation }))
            }
        }
    }
}

/// A linear estimator prepared for contacts and markers.
struct Linear {
    estimator: LinearEstimator,
    prior: Prior,
    sum: SumSigma,
    linearisation: Option<Linearisation>,
}

impl PreparedEstimator for Linear {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let estimate = match &mut self.linearisation {
            Some(linearisation) => self.estimator.estimate_on(linearisation, measurement, noise_mm, self.prior)?,
            None => self.estimator.estimate(measurement, noise_mm, self.prior),
        };
        let sum_sigma_n = self.sum.sigma_n(estimate.noise_mm, self.prior);
        let sum_sigma_n = sum_sigma_n.map(|sigma_n| estimate.misfit_factor * sigma_n);
        let sum_error_n: f64 = estimate.model_error_n.iter().sum();
        Ok(Sensed {
            sum_sigma_n: sum_sigma_n.map(|sigma| sigma.hypot(sum_error_n)),
            warned: estimate.warning.is_some(),
            forces_n: estimate.forces_n,
            sigmas_n: Some(estimate.sigmas_n),
        })
    }
}

/// Standard deviation of the sum of linearly estimated forces: sqrt(1^T P 1), where P = s^2 (C^T W^2 C + (s / p)^2)^-1 is the covariance of the
/// forces. Here C is the compliance at the markers, W holds their weights, s is the noise, and p is the prior's standard deviation (infinite for
/// least squares).
struct SumSigma {
    /// C^T W^2 C, mm^2/N^2, for an estimator with a prior. `None` without a prior, or if rounding makes the matrix singular.
    information: Option<DMatrix<f64>>,
    /// Standard deviation of the sum of least-squares forces per mm of noise, N/mm.
    per_noise: f64,
}

impl SumSigma {
    fn of(estimator: &LinearEstimator, prior: Prior) -> SumSigma {
        // The gain G is the pseudo-inverse of the weighted compliance W C, so G G^T = (C^T W^2 C)^-1.
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

/// A nonlinear estimator prepared for contacts and markers.
struct Nonlinear<'m> {
    estimator: NonlinearEstimator<'m>,
    discretisation: Option<Discretisation<'m>>,
}

impl PreparedEstimator for Nonlinear<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        // If the search started from the last estimate, the result would depend on the order of measurements.
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

    fn expect_forces(&mut self, forces_n: &[f64]) {
        self.estimator.hold_at(forces_n);
    }
}
