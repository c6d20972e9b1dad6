//! Estimators that rest on the beam model itself.

use super::prepared_linear::{Linear, SolvedLinear};
use super::prepared_nonlinear::Nonlinear;
use super::{Estimator, EstimatorError, EstimatorId, PreparedEstimator};
use crate::Mesh;
use crate::compliance::NodalCompliance;
use crate::measurement::Measurement;
use crate::sensing::{Contact, Discretisation, LinearEstimator, NonlinearEstimator, Prior};

/// Elements a member of the co-rotational finger that shows the error of linearisation: its own is small beside it.
const LINEARISATION_ELEMENTS: usize = 2;

/// An estimator on a mesh of the beam model.
#[derive(Debug, Clone)]
pub struct BeamEstimator<'m> {
    id: EstimatorId,
    /// Prior of a linear estimator; `None` for the nonlinear one.
    prior: Option<Prior>,
    mesh: &'m Mesh,
    /// Reference of the model error: the co-rotational finger, for the nonlinear estimator on a finer mesh.
    reference: Option<Mesh>,
}

impl<'m> BeamEstimator<'m> {
    /// Linear least squares; the linear finger is exact at its key nodes on any mesh. Its standard deviations hold the error of
    /// linearisation.
    pub fn least_squares(mesh: &'m Mesh) -> BeamEstimator<'m> {
        BeamEstimator::linear(EstimatorId::LeastSquares, Prior::None, mesh)
    }

    /// The same with the paper's range of forces as a prior.
    pub fn ridge(mesh: &'m Mesh) -> BeamEstimator<'m> {
        BeamEstimator::linear(EstimatorId::Ridge, Prior::PAPER, mesh)
    }

    fn linear(id: EstimatorId, prior: Prior, mesh: &'m Mesh) -> BeamEstimator<'m> {
        let reference = Mesh::with_elements_per_member(mesh.finger(), LINEARISATION_ELEMENTS);
        BeamEstimator { id, prior: Some(prior), mesh, reference: Some(reference) }
    }

    /// Gauss-Newton on a mesh of the co-rotational finger. Its standard deviations hold the error of the mesh.
    pub fn nonlinear(mesh: &'m Mesh) -> BeamEstimator<'m> {
        let reference = Some(Discretisation::finer(mesh));
        BeamEstimator { id: EstimatorId::Nonlinear, prior: None, mesh, reference }
    }

    /// The same with standard deviations of the noise alone, as the Cramer-Rao bound has them.
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
        let prior = self.prior?;
        let solved = NodalCompliance::new(self.mesh.finger());
        let reference = self.reference.as_ref().filter(|_| !finger_is_linear);
        Some(Box::new(SolvedLinear { id: self.id, solved, prior, reference }))
    }
}
