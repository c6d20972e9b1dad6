//! Reads sensing networks from files.

use super::{FileError, read_bytes};
use finray_model::sensing::network::Network;
use sha2::{Digest, Sha256};
use std::path::Path;

/// Reads a network that `finray train` has written. Also returns the SHA-256 of the file in hexadecimal digits.
///
/// # Errors
/// [`FileError`] if the file cannot be read, is not a network or is damaged.
pub fn load_network(path: &Path) -> Result<(Network, String), FileError> {
    let bytes = read_bytes(path)?;
    let network = Network::from_bytes(&bytes).map_err(|error| FileError::content(path, error))?;
    Ok((network, Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect()))
}
