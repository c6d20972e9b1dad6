//! Reader of contact scenes: a scene with an object, and the corners of its outline from a separate file.

use crate::experiments::contact_scene::study::SceneWithOutline;
use finray_files::{FileError, is_standard_stream, load_scene_and_text, outline_corners};
use std::path::Path;

/// Reads a scene and, if its object is a polygon, the corners `x_mm,y_mm` from the file that the object names. The file of corners is beside the
/// scene's file, or in the working folder if the scene comes from standard input.
///
/// # Errors
/// [`FileError`] with file, line and key, if the scene or the corners cannot be read, or the corners form no valid outline.
pub fn load_scene_with_outline(path: &Path) -> Result<SceneWithOutline, FileError> {
    let (scene, text) = load_scene_and_text(path)?;
    let folder = if is_standard_stream(path) { None } else { path.parent() };
    let corners = outline_corners(&scene, folder.unwrap_or(Path::new("")))?;
    Ok(SceneWithOutline { scene, text, corners })
}
