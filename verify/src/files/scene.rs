//! Scene files.

use super::{FileError, read_text};
use finray_model::Scene;
use std::path::Path;

/// Reads and checks a scene file; `-` is standard input.
///
/// # Errors
/// [`FileError`] naming file, line and key.
pub fn load_scene(path: &Path) -> Result<Scene, FileError> {
    Scene::from_toml(&read_text(path)?).map_err(|error| FileError::content(path, error))
}
