//! Several images of one finger with the forces that were measured: what `calibrate` reads.

use super::observations::{Coordinates, ObservationTable, RefusedImage};
use super::table::{Table, header};
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

/// A contact force that was measured in an image.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredForce {
    /// The image, by its name among those that were located.
    pub image: String,
    /// The force in the frame of the camera's pose, N.
    pub force: Vector,
    /// What pressed the finger, where the file says it.
    pub object: Option<String>,
}

/// Reads what `locate` wrote of several images, and [`forces`] that were measured.
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
        Some(path) => self::forces(path, &images)?,
    };
    let reason = |image: &&str| Some((image.to_string(), table.refused(image)?.to_owned()));
    let refused: Vec<RefusedImage> =
        images.iter().filter_map(reason).map(|(image, reason)| RefusedImage { image, reason }).collect();
    let located = images.iter().filter(|image| table.refused(image).is_none());
    let view = |image: &str| {
        let seen = table.observation(Some(image))?;
        let measured = forces.iter().find(|measured| measured.image == image);
        let view = LocatedView::new(seen, scene, measured.map(|measured| measured.force))
            .map_err(|error| table.error(Some(image), &error))?;
        Ok(LocatedView { object: measured.and_then(|measured| measured.object.clone()), ..view })
    };
    Ok(LocatedViews { views: located.map(|image| view(image)).collect::<Result<_, _>>()?, refused, misplaced_mm })
}

/// Reads `image,fx_n,fy_n` and, where it is there, `object`: forces in the frame of the camera's pose, which is that of the finger where its base does not
/// move.
///
/// # Errors
/// [`FileError`] for a force of none of `images`, twice of one, or zero, and for an object without a name.
pub fn forces(path: &Path, images: &[&str]) -> Result<Vec<MeasuredForce>, FileError> {
    let text = super::read_text(path)?;
    let table = Table::of_text(path, &text, ["image", "fx_n", "fy_n"])?;
    let has_objects = header(&text).iter().any(|name| name == "object");
    let objects = has_objects.then(|| Table::of_text(path, &text, ["object"])).transpose()?;
    let mut forces: Vec<MeasuredForce> = Vec::new();
    for (i, row) in table.rows().iter().enumerate() {
        let image = image_named(&row.cells[0], images).map_err(|reason| table.wrong(row, reason))?;
        if forces.iter().any(|known| known.image == image) {
            return Err(table.wrong(row, format!("image {image:?} is listed twice")));
        }
        let force = Vector::new(table.number(row, 1)?, table.number(row, 2)?);
        if force == Vector::zeros() {
            return Err(table.wrong(row, "expected a force that is not zero"));
        }
        let object = objects.as_ref().map(|objects| objects.rows()[i].cells[0].clone());
        if object.as_ref().is_some_and(String::is_empty) {
            return Err(table.wrong(row, "object: expected the name of what pressed the finger, found nothing"));
        }
        forces.push(MeasuredForce { image: image.to_owned(), force, object });
    }
    Ok(forces)
}
