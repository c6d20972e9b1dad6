//! Every way to sense forces, behind one small trait: maps, scatter and tables put them all to the same test.
//!
//! An [`Estimator`] is shared by threads; each thread prepares its own [`PreparedEstimator`] for the contacts and markers of
//! a question. Every estimate starts afresh: what was sensed before does not count.

pub mod network;

use finray_model::Mesh;
use finray_model::compliance::NodalCompliance;
use finray_model::measurement::Measurement;
use finray_model::sensing::network::NetworkError;
use finray_model::sensing::{
    Contact, Discretisation, LinearEstimator, Linearisation, NonlinearEstimator, Prior, SensingError,
};
use nalgebra::{DMatrix, DVector};
use network::NoNetwork;
use serde::Serialize;

/// Elements a member on which the nonlinear estimator works: what is left of the mesh is small beside the noise.
pub const ELEMENTS: usize = 4;

/// Elements a member of the co-rotational finger that shows the error of linearisation: its own is small beside it.
const LINEARISATION_ELEMENTS: usize = 2;

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
    /// `None` where that gains nothing. If the finger that is sensed is linear, a linear estimator is told so, and seeks no
    /// error of linearisation.
    fn for_many(&self, _finger_is_linear: bool) -> Option<Box<dyn Estimator + '_>> {
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
    /// Whether the estimator warns: the measurement contradicts its model, or the model errs by more than noise does.
    pub warned: bool,
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
#[derive(Debug, Clone)]
pub struct BeamEstimator<'m> {
    kind: EstimatorKind,
    mesh: &'m Mesh,
    /// What the error of the model is found with: the co-rotational finger, for the nonlinear estimator on a finer mesh.
    reference: Option<Mesh>,
}

impl<'m> BeamEstimator<'m> {
    /// An estimator on a mesh (the linear finger is exact at its key nodes on any), whose standard deviations hold the
    /// error of linearisation or of the mesh.
    pub fn new(kind: EstimatorKind, mesh: &'m Mesh) -> BeamEstimator<'m> {
        let reference = match kind {
            EstimatorKind::Nonlinear => Discretisation::finer(mesh),
            _ => Mesh::with_elements_per_member(mesh.finger(), LINEARISATION_ELEMENTS),
        };
        BeamEstimator { kind, mesh, reference: Some(reference) }
    }

    /// The same with standard deviations of the noise alone, as the Cramer-Rao bound has them.
    pub fn of_noise_alone(kind: EstimatorKind, mesh: &'m Mesh) -> BeamEstimator<'m> {
        BeamEstimator { kind, mesh, reference: None }
    }
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
                Ok(Box::new(Linear::new(estimator, prior, contacts, self.reference.as_ref())))
            }
            None => {
                let questions: Vec<_> = contacts.iter().map(|&contact| contact.into()).collect();
                let estimator = NonlinearEstimator::new(self.mesh, &questions)?;
                let discretisation = self.reference.as_ref().map(|finer| Discretisation::new(self.mesh, finer));
                Ok(Box::new(Nonlinear { estimator, discretisation }))
            }
        }
    }

    fn for_many(&self, finger_is_linear: bool) -> Option<Box<dyn Estimator + '_>> {
        let prior = self.kind.prior()?;
        let solved = NodalCompliance::new(self.mesh.finger());
        let reference = self.reference.as_ref().filter(|_| !finger_is_linear);
        Some(Box::new(SolvedLinear { kind: self.kind, solved, prior, reference }))
    }
}

/// A linear estimator on a finger that is solved once for all contacts.
struct SolvedLinear<'m> {
    kind: EstimatorKind,
    solved: NodalCompliance,
    prior: Prior,
    reference: Option<&'m Mesh>,
}

impl Estimator for SolvedLinear<'_> {
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
        Ok(Box::new(Linear::new(estimator, self.prior, contacts, self.reference)))
    }
}

struct Linear<'m> {
    estimator: LinearEstimator,
    prior: Prior,
    sum: SumSigma,
    linearisation: Option<Linearisation<'m>>,
}

impl<'m> Linear<'m> {
    fn new(estimator: LinearEstimator, prior: Prior, contacts: &[Contact], reference: Option<&'m Mesh>) -> Linear<'m> {
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

struct Nonlinear<'m> {
    estimator: NonlinearEstimator<'m>,
    discretisation: Option<Discretisation<'m>>,
}

impl PreparedEstimator for Nonlinear<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        // A stream's start from the last frame would be too easy.
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
