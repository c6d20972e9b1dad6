//! Errors of networks, their files and their requests.

use crate::finger::NodeId;
use crate::sensing::SensingError;

/// Why a network cannot be read, built or used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// The bytes are not a safetensors file.
    #[error("not a network: expected a safetensors file ({0})")]
    NotSafetensors(String),
    /// Something that belongs to a network is not in the file.
    #[error("not a complete network: {0} is missing")]
    Missing(String),
    /// The file holds something else as well.
    #[error("not a network of this kind: {0} does not belong to it")]
    Unexpected(String),
    /// Numbers of another type.
    #[error("{tensor}: expected numbers of type {expected}, found {found}")]
    Type {
        /// The tensor.
        tensor: String,
        /// Type that it must have, as safetensors names it.
        expected: String,
        /// Type that it has.
        found: String,
    },
    /// A tensor of another shape.
    #[error("{part}: expected shape {expected:?}, found {found:?}")]
    Shape {
        /// The tensor.
        part: String,
        /// Shape that fits the other parts.
        expected: Vec<usize>,
        /// Shape that it has.
        found: Vec<usize>,
    },
    /// A number that is not finite.
    #[error("{part}: expected finite numbers, found {value} at index {index}")]
    NotFinite {
        /// The tensor or the key of the card.
        part: String,
        /// Position of the number.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A part that cannot be.
    #[error("{part}: expected {expected}, found {found}")]
    Parts {
        /// The tensor or the key of the card.
        part: String,
        /// What is expected.
        expected: String,
        /// What was found.
        found: String,
    },
    /// The card cannot be read.
    #[error("the network's card (metadata key {key}): {reason}")]
    Card {
        /// Key of the metadata.
        key: &'static str,
        /// What was expected and found.
        reason: String,
    },
    /// A file of another version.
    #[error("the network is written in format {found}, and only format {expected} is known")]
    Format {
        /// The known format.
        expected: u32,
        /// What was found.
        found: u64,
    },
    /// The contents are not those that were written.
    #[error("the network is damaged: its checksum is not that of its contents")]
    Damaged,
    /// Trained for another finger.
    #[error(
        "the network was trained for another finger: its fingerprint is {trained:.8}..., that of this finger {found:.8}..."
    )]
    AnotherFinger {
        /// Fingerprint of the finger that it was trained for, in hexadecimal digits.
        trained: String,
        /// Fingerprint of the finger at hand.
        found: String,
    },
    /// Trained for other contacts.
    #[error("the network was trained for {trained}, not for {asked}")]
    OtherContacts {
        /// The contacts that it was trained for.
        trained: String,
        /// The contacts asked for.
        asked: String,
    },
    /// A measured node that the network does not know.
    #[error("node {node} is none of the {known} markers that the network was trained on: leave it out")]
    UnknownMarker {
        /// The measured node.
        node: NodeId,
        /// Number of markers that it knows.
        known: usize,
    },
    /// Too few markers for a network that cannot fill in what is hidden.
    #[error(
        "the network needs all of its {expected} markers, found {found}: only one whose inputs are principal directions \
         can fill in hidden ones"
    )]
    HiddenMarkers {
        /// Markers that it was trained on.
        expected: usize,
        /// Markers that were measured.
        found: usize,
    },
    /// Other markers than those that the estimator was prepared for.
    #[error("the measured markers are not those that the estimator was prepared for, in their order")]
    OtherMarkers,
    /// Markers that count differently.
    #[error(
        "node {node} has the weight {weight}: the network was trained on markers that all count alike, with weight 1"
    )]
    Weighted {
        /// The marker.
        node: NodeId,
        /// Its weight.
        weight: f64,
    },
    /// Displacements or forces of a wrong number.
    #[error("expected {expected} {what}, found {found}")]
    Length {
        /// What was counted.
        what: &'static str,
        /// How many there must be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A shape unlike those that the network has seen.
    #[error(
        "the shape is unlike those that the network was trained on: its input {input} is {value:.2}, where training reached \
         {largest:.2} (forces up to {largest_total_n} N in all)"
    )]
    OutsideTraining {
        /// Number of the input, from 1.
        input: usize,
        /// |z_i|.
        value: f64,
        /// Largest |z_i| met in training.
        largest: f64,
        /// Largest sum of the forces in training, N.
        largest_total_n: f64,
    },
    /// A force that training never had.
    #[error(
        "contact {contact}: {force_n:.3} N lies beyond the forces that the network was trained on, {least_n} to {largest_n} N: \
         something else pushes, or the contacts are others"
    )]
    ForceOutsideTraining {
        /// Number of the contact, from 1.
        contact: usize,
        /// The force that the network gives, N.
        force_n: f64,
        /// Least force in training, N.
        least_n: f64,
        /// Largest force in training, N.
        largest_n: f64,
    },
    /// Errors that all estimators share.
    #[error(transparent)]
    Sensing(#[from] SensingError),
}

impl NetworkError {
    /// [`NetworkError::Parts`].
    pub(super) fn of_part(part: &str, expected: &str, found: impl ToString) -> NetworkError {
        NetworkError::Parts { part: part.to_owned(), expected: expected.to_owned(), found: found.to_string() }
    }
}

/// Refuses a tensor that does not fit.
///
/// # Errors
/// [`NetworkError::Shape`].
pub(super) fn require_shape(part: &str, expected: &[usize], found: &[usize]) -> Result<(), NetworkError> {
    if expected == found {
        return Ok(());
    }
    Err(NetworkError::Shape { part: part.to_owned(), expected: expected.to_vec(), found: found.to_vec() })
}
