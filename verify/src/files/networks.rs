//! Sensing networks in files.

use super::{FileError, read_bytes};
use finray_model::sensing::network::Network;
use std::path::Path;

/// Reads a network that `finray train` has written.
///
/// # Errors
/// [`FileError`] if the file cannot be read, is no network or is damaged.
pub fn load_network(path: &Path) -> Result<Network, FileError> {
    Network::from_bytes(&read_bytes(path)?).map_err(|error| FileError::content(path, error))
}
