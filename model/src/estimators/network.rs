//! Trained networks as estimators.

use super::{Answer, EstimatorError, EstimatorRow, Question, known_contacts};
use crate::Finger;
use crate::sensing::Contact;
use crate::sensing::network::{ContactSet, Network, NetworkError, NetworkEstimator};
use std::sync::{Arc, LazyLock};

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
    admits: |finger, contacts, networks| {
        networks.choose(finger, &known_contacts(finger, contacts)?)?;
        Ok(())
    },
    answer,
};

fn answer(finger: &Finger, question: &Question) -> Result<Answer, EstimatorError> {
    let contacts = known_contacts(finger, question.contacts)?;
    let mut kept = question.kept.borrow_mut();
    let estimator = kept.network.get_or_compute(question.measurement, || {
        let network = question.networks.choose(finger, &contacts)?;
        Ok::<_, EstimatorError>(NetworkEstimator::new(network, finger, &contacts, question.measurement)?)
    })?;
    let estimate = estimator.estimate(question.measurement, question.marker_noise_mm)?;
    Ok((contacts, estimate))
}

/// A list of networks, from which the estimator selects a network by the finger and the contacts. Clones share the networks.
#[derive(Debug, Clone, PartialEq)]
pub struct Networks(Arc<[Network]>);

/// No network is trained for the finger and contacts.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoNetwork {
    /// The list has only one network, which was trained for another finger or other contacts.
    #[error(transparent)]
    Made(#[from] NetworkError),
    /// No network is trained for this finger.
    #[error("no network ships for this finger: train one (`finray train`)")]
    Finger,
    /// No network is trained for these contacts. The field lists the contacts.
    #[error("no network ships for these contacts ({0}): train one (`finray train`)")]
    Contacts(String),
}

impl Networks {
    /// Reads networks from the bytes of their files.
    ///
    /// # Errors
    /// [`NetworkError`] for the first file that cannot be read.
    pub fn read(files: &[&[u8]]) -> Result<Networks, NetworkError> {
        files.iter().map(|bytes| Network::from_bytes(bytes)).collect::<Result<_, _>>().map(Networks::of)
    }

    /// An empty list of networks.
    pub fn none() -> &'static Networks {
        static NONE: LazyLock<Networks> = LazyLock::new(|| Networks::of(Vec::new()));
        &NONE
    }

    /// A list of the given networks.
    pub fn of(networks: Vec<Network>) -> Networks {
        Networks(networks.into())
    }

    /// Selects the network for the contacts of a finger; the order of the contacts does not matter. A network for exactly these contacts has priority
    /// over a network that accepts any subset of its trained contacts.
    ///
    /// # Errors
    /// [`NoNetwork`] if no network is trained for the finger and the contacts.
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
