//! Errors of networks, of network files and of requests to a network.

use crate::finger::NodeId;
use crate::sensing::SensingError;

/// Reason why a network cannot be read, built or used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// The bytes are not a safetensors file.
    #[error("not a network: expected a safetensors file ({0})")]
    NotSafetensors(String),
    /// A tensor, a key of the card or a list is missing, has an impossible value, or does not fit the other parts.
    #[error("{part}: expected {expected}, found {found}")]
    Part {
        /// Name of the tensor, the key or the list.
        part: String,
        /// Expected value.
        expected: String,
        /// Found value.
        found: String,
    },
    /// The card in the metadata cannot be read.
    #[error("cannot read the network's card: {0}")]
    Card(String),
    /// The file has another version of the format.
    #[error(
        "the network has format {found}, expected format {expected}: train the network again with this version of finray"
    )]
    Format {
        /// Known version.
        expected: u32,
        /// Version of the file.
        found: u64,
    },
    /// The checksum does not match the contents.
    #[error("the network is damaged: its checksum does not match its contents")]
    Damaged,
    /// The network was trained for another finger.
    #[error(
        "the network was trained for another finger: its fingerprint is {trained:.8}..., the fingerprint of this finger {found:.8}..."
    )]
    AnotherFinger {
        /// Fingerprint of the finger for which the network was trained, in hexadecimal digits.
        trained: String,
        /// Fingerprint of the given finger, in hexadecimal digits.
        found: String,
    },
    /// The network was trained for other contacts.
    #[error("the network was trained for {trained}, not for {asked}")]
    OtherContacts {
        /// Contacts of the training, in words.
        trained: String,
        /// Requested contacts.
        asked: String,
    },
    /// A measured node is not a marker of the network.
    #[error(
        "node {node} is not among the {known} markers that the network was trained on: remove this node from the measurement"
    )]
    UnknownMarker {
        /// The measured node.
        node: NodeId,
        /// Number of markers of the network.
        known: usize,
    },
    /// A marker is hidden, but this network cannot estimate displacements of hidden markers.
    #[error(
        "the network needs all of its {expected} markers, found {found}: only a network with principal components as inputs estimates hidden markers"
    )]
    HiddenMarkers {
        /// Number of markers of the network.
        expected: usize,
        /// Number of measured markers.
        found: usize,
    },
    /// The markers differ from those for which the estimator is prepared.
    #[error("expected the markers for which the estimator was prepared, in the same order")]
    OtherMarkers,
    /// A marker has a weight other than 1.
    #[error("node {node} has the weight {weight}, expected 1: the network was trained on markers of equal weight")]
    Weighted {
        /// Node of the marker.
        node: NodeId,
        /// Weight of the marker, dimensionless.
        weight: f64,
    },
    /// The measured shape is unlike the shapes of the training.
    #[error(
        "the shape is unlike those that the network was trained on: its input {input} is {value:.2}, expected at most {largest:.2} (the sum of the \
         training forces is at most {largest_total_n} N)"
    )]
    OutsideTraining {
        /// Number of the input, from 1.
        input: usize,
        /// Absolute value of the input, dimensionless.
        value: f64,
        /// Largest absolute value in training, dimensionless.
        largest: f64,
        /// Largest sum of the forces in training, N.
        largest_total_n: f64,
    },
    /// A force is outside the range of the training.
    #[error(
        "contact {contact}: {force_n:.3} N is outside the forces that the network was trained on, {least_n} to {largest_n} N: check for further \
         contacts"
    )]
    ForceOutsideTraining {
        /// Number of the contact, from 1.
        contact: usize,
        /// Estimated force, N.
        force_n: f64,
        /// Smallest force in training, N.
        least_n: f64,
        /// Largest force in training, N.
        largest_n: f64,
    },
    /// A force acts at a contact of the training that is not among the requested contacts.
    #[error(
        "the contacts are wrong: with contact {contact} added, the network senses {force_n:.2} N there (standard deviation {sigma_n:.2} N)"
    )]
    FurtherForce {
        /// The contact that was not requested.
        contact: String,
        /// Estimated force, N.
        force_n: f64,
        /// Standard deviation of the force, N.
        sigma_n: f64,
    },
    /// An error that is not specific to networks.
    #[error(transparent)]
    Sensing(#[from] SensingError),
}

/// Refuses a part of a network unless `holds` is true.
///
/// # Errors
/// [`NetworkError::Part`] with the expected and the found value.
pub(super) fn require(
    holds: bool,
    part: &str,
    expected: impl ToString,
    found: impl ToString,
) -> Result<(), NetworkError> {
    if holds {
        return Ok(());
    }
    Err(NetworkError::Part { part: part.to_owned(), expected: expected.to_string(), found: found.to_string() })
}

/// Refuses a tensor of the wrong shape.
///
/// # Errors
/// [`NetworkError::Part`] if the shapes differ.
pub(super) fn require_shape(part: &str, expected: &[usize], found: &[usize]) -> Result<(), NetworkError> {
    require(expected == found, part, format!("shape {expected:?}"), format!("{found:?}"))
}
