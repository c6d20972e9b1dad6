//! Further contacts of a network for any subset of its contacts: whether a force acts where none is assumed.

use super::NetworkError;
use super::prepared::Prepared;
use crate::sensing::Contact;
use nalgebra::DMatrix;

/// Assumed contacts are wrong if the force at one further contact exceeds this number of its standard deviations. For random forces up to 9 N on the
/// paper's finger and right contacts, the largest found ratio is 3.6 with the noise of the training, and 5.4 with less noise, where the error of the
/// network is not normally distributed.
const MOST_SIGMAS: f64 = 6.0;

/// A contact of the training at which no force is assumed. The network is prepared for the assumed contacts and this contact, and returns the force at
/// this contact only.
#[derive(Debug, Clone)]
pub(super) struct FurtherContact {
    pub(super) contact: Contact,
    pub(super) prepared: Prepared,
    /// Covariance of the inputs due to hidden markers, dimensionless.
    pub(super) hidden_covariance: DMatrix<f64>,
    /// Root mean square error of the network's force at this contact without noise, N.
    pub(super) clean_rms_n: f64,
}

impl FurtherContact {
    /// Force at this contact beside the assumed contacts, in standard deviations, with the refusal if this force is significant. If the noise is unknown,
    /// every force may be noise.
    pub(super) fn force(&self, displacements: &[f64], noise_mm: f64) -> (f64, Option<NetworkError>) {
        let z = self.prepared.inputs(displacements);
        let (forces_n, derivatives) = self.prepared.forces_and_derivatives(&z);
        let from_noise = noise_mm * (&derivatives * &self.prepared.projection).norm();
        let from_hidden = (&derivatives * &self.hidden_covariance * derivatives.transpose())[(0, 0)].max(0.0);
        let sigma_n = (from_noise.powi(2) + from_hidden + self.clean_rms_n.powi(2)).sqrt();
        let force_n = forces_n[0];
        let sigmas = force_n.abs() / sigma_n;
        let refusal = || NetworkError::FurtherForce { contact: self.contact.to_string(), force_n, sigma_n };
        (sigmas, (sigmas > MOST_SIGMAS).then(refusal))
    }
}
