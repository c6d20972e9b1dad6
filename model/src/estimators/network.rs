//! Sensing networks as estimators.

use super::{
    Answer, Estimator, EstimatorError, EstimatorId, EstimatorRow, PreparedEstimator, Question, Sensed, known_contacts,
};
use crate::measurement::Measurement;
use crate::sensing::Contact;
use crate::sensing::network::{ContactSet, Network, NetworkError, NetworkEstimator};
use crate::{Finger, Mesh};

pub(super) const ROW: EstimatorRow = EstimatorRow {
    name: "network",
    label: "network",
    help: "A trained network",
    is_linear: false,
    searches: false,
    at_nodes: true,
    needs: "a training for each set of contacts",
    refuses: "other contacts, displacements unlike its training",
    unseen_contacts: "none",
    mesh: Mesh::key_nodes,
    on: |mesh, networks| Box::new(NetworkSensing { networks, finger: mesh.finger(), refuses: true }),
    admits: |finger, contacts, networks| {
        networks.choose(finger, &known_contacts(finger, contacts)?)?;
        Ok(())
    },
    answer,
};

fn answer(finger: &Finger, question: &Question) -> Result<Answer, EstimatorError> {
    let contacts = known_contacts(finger, question.contacts)?;
    let network = question.networks.choose(finger, &contacts)?;
    let mut estimator = NetworkEstimator::new(network, finger, &contacts, question.measurement)?;
    let estimate = estimator.estimate(question.measurement, question.noise_mm)?;
    Ok((contacts, estimate))
}

/// Networks to choose from by finger and contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct Networks(Vec<Network>);

/// No network is trained for the request.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoNetwork {
    /// There is a single one, and this is why not.
    #[error(transparent)]
    Made(#[from] NetworkError),
    /// Not for this finger.
    #[error(
        "no network ships for this finger: train one with `finray train SCENE --contact ... --out FILE` and give it with --network FILE"
    )]
    Finger,
    /// Not for these contacts.
    #[error(
        "no network ships for these contacts ({0}): train one with `finray train SCENE --contact ... --out FILE` and give it with \
         --network FILE"
    )]
    Contacts(String),
}

impl Networks {
    /// Networks from the bytes of their files.
    ///
    /// # Errors
    /// [`NetworkError`] for the first one that does not read.
    pub fn read(files: &[&[u8]]) -> Result<Networks, NetworkError> {
        files.iter().map(|bytes| Network::from_bytes(bytes)).collect::<Result<_, _>>().map(Networks)
    }

    /// No networks.
    pub fn none() -> &'static Networks {
        static NONE: Networks = Networks(Vec::new());
        &NONE
    }

    /// Some networks.
    pub fn of(networks: Vec<Network>) -> Networks {
        Networks(networks)
    }

    /// The network for contacts of a finger, in any order: one for exactly these before one for any of many.
    ///
    /// # Errors
    /// [`NoNetwork`].
    pub fn choose(&self, finger: &Finger, contacts: &[Contact]) -> Result<&Network, NoNetwork> {
        let mut why = NoNetwork::Finger;
        let by_set = |set: ContactSet| self.0.iter().filter(move |network| network.card.contact_set == set);
        for network in by_set(ContactSet::Fixed).chain(by_set(ContactSet::AnyOf)) {
            match network.check_made_for(finger, contacts) {
                Ok(()) => return Ok(network),
                Err(error) if self.0.len() == 1 => return Err(error.into()),
                Err(NetworkError::OtherContacts { asked, .. }) => why = NoNetwork::Contacts(asked),
                Err(_) => {}
            }
        }
        Err(why)
    }
}

/// Networks as an estimator for one finger; which of them answers depends on the contacts.
#[derive(Debug, Clone, Copy)]
pub struct NetworkSensing<'n> {
    /// The networks.
    pub networks: &'n Networks,
    /// The finger.
    pub finger: &'n Finger,
    /// Whether shapes unlike those of the training are refused.
    pub refuses: bool,
}

impl Estimator for NetworkSensing<'_> {
    fn id(&self) -> EstimatorId {
        EstimatorId::Network
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        let network = self.networks.choose(self.finger, contacts)?;
        let estimator = NetworkEstimator::new(network, self.finger, contacts, markers)?;
        Ok(if self.refuses { Box::new(estimator) } else { Box::new(Unjudged(estimator)) })
    }
}

impl PreparedEstimator for NetworkEstimator {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let estimate = NetworkEstimator::estimate(self, measurement, noise_mm)?;
        let warned = estimate.warning.is_some();
        Ok(Sensed { forces_n: estimate.forces_n, sigmas_n: Some(estimate.sigmas_n), sum_sigma_n: None, warned })
    }
}

/// Forces for any shape, as the paper's network gives them: nothing is refused, and no deviation is stated.
struct Unjudged(NetworkEstimator);

impl PreparedEstimator for Unjudged {
    fn estimate(&mut self, measurement: &Measurement, _: Option<f64>) -> Result<Sensed, EstimatorError> {
        let displacements = measurement.markers().iter().flat_map(|m| [m.displacement.x, m.displacement.y]);
        let displacements: Vec<f64> = displacements.collect();
        let mut forces_n = vec![0.0; self.0.contact_count()];
        self.0.forces(&displacements, &mut forces_n)?;
        Ok(Sensed { forces_n, sigmas_n: None, sum_sigma_n: None, warned: false })
    }
}
