//! Several images of one finger with the forces that were measured: what `calibrate` reads.

use super::observations::{Coordinates, ObservationTable, RefusedImage};
use super::table::Table;
use super::{FileError, image_named};
use finray_model::calibration::LocatedView;
use finray_model::{Scene, Vector};
use std::path::Path;

/// Images that were located.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedViews {
    /// Each image.
    pub views: Vec<LocatedView>,
    /// Images that were refused when they were located.
    pub refused: Vec<RefusedImage>,
    /// By how much the file differs, at worst, from what this scene would have made of the same markers, mm: zero but for rounding where they were
    /// located with it.
    pub misplaced_mm: f64,
}

/// Reads what `locate` wrote of several images, and `image,fx_n,fy_n` with the forces that were measured, in the frame of the camera's pose: that of the
/// finger where its base does not move.
///
/// # Errors
/// [`FileError`] for anything that does not fit the finger, or a force of an image that is not there.
pub fn load(located: &Path, forces: Option<&Path>, scene: &Scene) -> Result<LocatedViews, FileError> {
    let text = super::read_text(located)?;
    let misplaced_mm = super::origin::misplaced_mm(located, &text, scene)?;
    let table = ObservationTable::new(located, &text, &scene.finger, Coordinates::Positions)?;
    let images = table.images()?;
    let forces = match forces {
        None => Vec::new(),
        Some(path) => load_forces(path, &images)?,
    };
    let reason = |image: &&str| Some((image.to_string(), table.refused(image)?.to_owned()));
    let refused: Vec<RefusedImage> =
        images.iter().filter_map(reason).map(|(image, reason)| RefusedImage { image, reason }).collect();
    let located = images.iter().filter(|image| table.refused(image).is_none());
    let view = |image: &str| {
        let seen = table.observation(Some(image))?;
        let force = forces.iter().find(|(name, _)| name == image).map(|(_, force)| *force);
        LocatedView::new(seen, scene, force).map_err(|error| table.error(Some(image), &error))
    };
    Ok(LocatedViews { views: located.map(|image| view(image)).collect::<Result<_, _>>()?, refused, misplaced_mm })
}

fn load_forces(path: &Path, images: &[&str]) -> Result<Vec<(String, Vector)>, FileError> {
    let table = Table::read(path, ["image", "fx_n", "fy_n"])?;
    let mut forces: Vec<(String, Vector)> = Vec::new();
    for row in table.rows() {
        let image = image_named(&row.cells[0], images).map_err(|reason| table.wrong(row, reason))?;
        if forces.iter().any(|(known, _)| known == image) {
            return Err(table.wrong(row, format!("image {image:?} is listed twice")));
        }
        let force = Vector::new(table.number(row, 1)?, table.number(row, 2)?);
        if force == Vector::zeros() {
            return Err(table.wrong(row, "expected a force that is not zero"));
        }
        forces.push((image.to_owned(), force));
    }
    Ok(forces)
}
