//! Every way to sense forces, behind one small trait: maps, scatter and tables put them all to the same test.
//!
//! An [`Estimator`] is shared by threads; each thread prepares its own [`PreparedEstimator`] for the contacts and markers of
//! a question. Every estimate starts afresh: what was sensed before does not count.

use crate::networks::NoNetwork;
use finray_model::Mesh;
use finray_model::compliance::NodalCompliance;
use finray_model::measurement::Measurement;
use finray_model::sensing::network::NetworkError;
use finray_model::sensing::{Contact, LinearEstimator, NonlinearEstimator, Prior, SensingError};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Elements a member on which the nonlinear estimator works: what is left of the mesh is small beside the noise.
pub const ELEMENTS: usize = 4;

/// A way to sense forces of known place and direction.
pub trait Estimator: Sync {
    /// What it is, for tables, captions and files.
    fn name(&self) -> &str;

    /// Prepares for contacts, and for the markers of a measurement; their displacements are not used yet.
    ///
    /// # Errors
    /// [`EstimatorError`] when a contact is wrong, the problem has no unique answer or the estimator is not made for it.
    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError>;

    /// The same estimator, to rounding, with what all contacts have in common worked out once, for who prepares for many;
    /// `None` where that gains nothing.
    fn for_many(&self) -> Option<Box<dyn Estimator + '_>> {
        None
    }
}

/// An estimator that is ready to sense, measurement by measurement.
pub trait PreparedEstimator {
    /// Senses the forces from the displacements of the markers that it was prepared for. `noise_mm` is the standard
    /// deviation of one coordinate, `None` if unknown.
    ///
    /// # Errors
    /// [`EstimatorError`] when the estimator refuses to answer.
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError>;
}

/// Sensed forces, with as much as the estimator states of their errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensed {
    /// Force of each contact along its direction, N, in the order of the contacts.
    pub forces_n: Vec<f64>,
    /// Standard deviation of each force, N.
    pub sigmas_n: Option<Vec<f64>>,
    /// Standard deviation of the sum of the forces, N.
    pub sum_sigma_n: Option<f64>,
}

/// Why an estimator does not answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// The model cannot tell the forces.
    #[error(transparent)]
    Sensing(#[from] SensingError),
    /// A network refuses.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// No network is made for the contacts.
    #[error(transparent)]
    NoNetwork(#[from] NoNetwork),
}

/// The estimators that rest on the beam model itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum EstimatorKind {
    /// Linear least squares
    LeastSquares,
    /// Least squares with the paper's range of forces as a prior
    Ridge,
    /// Gauss-Newton on the finger with large rotations
    Nonlinear,
}

impl EstimatorKind {
    /// All of them.
    pub const ALL: [EstimatorKind; 3] = [EstimatorKind::LeastSquares, EstimatorKind::Ridge, EstimatorKind::Nonlinear];

    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            EstimatorKind::LeastSquares => "least-squares",
            EstimatorKind::Ridge => "ridge",
            EstimatorKind::Nonlinear => "nonlinear",
        }
    }

    /// What a linear estimator assumes of the forces; `None` for the nonlinear one.
    fn prior(self) -> Option<Prior> {
        match self {
            EstimatorKind::LeastSquares => Some(Prior::None),
            EstimatorKind::Ridge => Some(Prior::PAPER),
            EstimatorKind::Nonlinear => None,
        }
    }
}

/// An estimator on a mesh of the beam model.
#[derive(Debug, Clone, Copy)]
pub struct BeamEstimator<'m> {
    /// Which one.
    pub kind: EstimatorKind,
    /// The mesh that the nonlinear estimator works on; the linear finger is exact at its key nodes on any.
    pub mesh: &'m Mesh,
}

impl Estimator for BeamEstimator<'_> {
    fn name(&self) -> &str {
        self.kind.name()
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        match self.kind.prior() {
            Some(prior) => {
                let estimator = LinearEstimator::new(self.mesh.finger(), contacts, markers)?;
                Ok(Box::new(Linear::new(estimator, prior)))
            }
            None => {
                let questions: Vec<_> = contacts.iter().map(|&contact| contact.into()).collect();
                Ok(Box::new(NonlinearEstimator::new(self.mesh, &questions)?))
            }
        }
    }

    fn for_many(&self) -> Option<Box<dyn Estimator + '_>> {
        let solved = NodalCompliance::new(self.mesh.finger());
        self.kind.prior().map(|prior| Box::new(SolvedLinear { kind: self.kind, solved, prior }) as Box<dyn Estimator>)
    }
}

/// A linear estimator on a finger that is solved once for all contacts.
struct SolvedLinear {
    kind: EstimatorKind,
    solved: NodalCompliance,
    prior: Prior,
}

impl Estimator for SolvedLinear {
    fn name(&self) -> &str {
        self.kind.name()
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
        Ok(Box::new(Linear::new(estimator, self.prior)))
    }
}

struct Linear {
    estimator: LinearEstimator,
    prior: Prior,
    sum: SumSigma,
}

impl Linear {
    fn new(estimator: LinearEstimator, prior: Prior) -> Linear {
        Linear { sum: SumSigma::of(&estimator, prior), estimator, prior }
    }
}

impl PreparedEstimator for Linear {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let estimate = self.estimator.estimate(measurement, noise_mm, self.prior);
        Ok(Sensed {
            sum_sigma_n: self.sum.sigma_n(estimate.noise_mm, self.prior),
            forces_n: estimate.forces_n,
            sigmas_n: Some(estimate.sigmas_n),
        })
    }
}

impl PreparedEstimator for NonlinearEstimator<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        // A stream's start from the last frame would be too easy.
        self.reset();
        let estimate = NonlinearEstimator::estimate(self, measurement, noise_mm)?;
        Ok(Sensed {
            sum_sigma_n: Some(estimate.covariance_n2.sum().sqrt()),
            forces_n: estimate.forces.forces_n,
            sigmas_n: Some(estimate.forces.sigmas_n),
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
