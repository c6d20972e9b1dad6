//! Reader of the corners of an object's outline.

use crate::FileError;
use crate::table::Table;
use finray_contact::outline::{ContactOutline, OutlineError};
use finray_model::scene::Outline;
use finray_model::{Scene, Vector};
use std::path::Path;

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
    match ContactOutline::of_object(object, &corners) {
        Ok(_) => Ok(corners),
        Err(error @ OutlineError::TooFar { corner }) => Err(table.wrong(&table.rows[corner - 1], error)),
        Err(error) => Err(FileError::content(&file, error)),
    }
}
