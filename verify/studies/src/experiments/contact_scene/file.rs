//! Reader of contact scenes: a scene with an object, and the corners of its outline from a separate file.

use crate::experiments::contact_scene::study::SceneWithOutline;
use crate::experiments::contact_scene::{OutlineError, TurnedOutline};
use finray_files::table::Table;
use finray_files::{FileError, is_standard_stream, load_scene_and_text};
use finray_model::scene::Outline;
use finray_model::{Scene, Vector};
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

/// The corners `x_mm,y_mm` of a polygon, from the file in `folder` that the scene's object names. Empty if the outline is no polygon, or the scene
/// has no object.
///
/// # Errors
/// [`FileError`] with file and line, if the corners cannot be read or form no valid outline.
pub fn outline_corners(scene: &Scene, folder: &Path) -> Result<Vec<Vector>, FileError> {
    let Some(object) = &scene.object else { return Ok(Vec::new()) };
    let Outline::Polygon { points_csv } = &object.outline else { return Ok(Vec::new()) };
    let file = folder.join(points_csv);
    let table = Table::read(&file, &["x_mm", "y_mm"])?;
    let corner = |row| Ok(Vector::new(table.number(row, "x_mm")?, table.number(row, "y_mm")?));
    let corners: Vec<Vector> = table.rows.iter().map(corner).collect::<Result<_, FileError>>()?;
    match TurnedOutline::new(object, &corners) {
        Ok(_) => Ok(corners),
        Err(error @ OutlineError::TooFar { corner }) => Err(table.wrong(&table.rows[corner - 1], error)),
        Err(error) => Err(FileError::content(&file, error)),
    }
}

/// Message for a scene without an object.
pub const NO_OBJECT: &str =
    "line 1: object is missing: expected a table [object] with shape, at_mm and travel_mm or force_n";
