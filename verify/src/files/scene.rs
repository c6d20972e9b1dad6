//! Scene files.

use super::{FileError, read_text};
use finray_model::Scene;
use std::path::Path;

/// Reads and checks a scene file; `-` is standard input.
///
/// # Errors
/// [`FileError`] naming file, line and key.
pub fn load_scene(path: &Path) -> Result<Scene, FileError> {
    load_scene_and_text(path).map(|(scene, _)| scene)
}

/// Reads and checks a scene file as [`load_scene`], and keeps its text.
///
/// # Errors
/// [`FileError`] naming file, line and key.
pub fn load_scene_and_text(path: &Path) -> Result<(Scene, String), FileError> {
    let text = read_text(path)?;
    let scene = Scene::from_toml(&text).map_err(|error| FileError::content(path, error))?;
    Ok((scene, text))
}
