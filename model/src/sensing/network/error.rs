//! What can be wrong with a network, its file, or what is asked of it.

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
        /// Place of the number.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A part that cannot be.
    #[error("{part}: expected {expected}, found {found}")]
    Parts {
        /// The tensor or the key of the card.
        part: String,
        /// What it must be.
        expected: String,
        /// What it is.
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
