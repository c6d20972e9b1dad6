//! Several images of one finger with measured contact forces, as `calibrate` reads them.

use super::observations::{Coordinates, ObservationTable, RefusedImage};
use super::table::Table;
use super::{FileError, image_named};
use finray_model::calibration::LocatedView;
use finray_model::observation::{Observation, ObservationError};
use finray_model::{Scene, Vector};
use std::path::Path;

/// The images in a table of `locate`.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedViews {
    /// Images in which a finger was located.
    pub views: Vec<LocatedView>,
    /// Images that `locate` refused.
    pub refused: Vec<RefusedImage>,
    /// Largest difference, mm, between the positions in the file and the positions that this scene yields for the same markers. The difference is 0 within
    /// rounding if the markers were located with this scene.
    pub misplaced_mm: f64,
}

/// A measured contact force in an image.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredForce {
    /// Name of the image, one of the located images.
    pub image: String,
    /// Force on the finger in the frame in which the scene states the camera's pose, N.
    pub force: Vector,
    /// Name of the object that pressed the finger; `None` if the file does not state it.
    pub object: Option<String>,
}

/// Reads a table of `locate` with several images, and their measured [`forces`].
///
/// # Errors
/// [`FileError`] for a row that does not fit the finger, or for a force whose image is not in the table.
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
        view_with_force(seen, scene, &forces).map_err(|error| table.error(Some(image), &error))
    };
    Ok(LocatedViews { views: located.map(|image| view(image)).collect::<Result<_, _>>()?, refused, misplaced_mm })
}

/// Converts an observation to a view, with the force that was measured in its image.
///
/// # Errors
/// [`ObservationError`] if the observation does not fit the scene's finger or states no standard deviations.
pub fn view_with_force(
    seen: Observation,
    scene: &Scene,
    forces: &[MeasuredForce],
) -> Result<LocatedView, ObservationError> {
    let measured = forces.iter().find(|measured| measured.image == seen.image);
    let view = LocatedView::new(seen, scene, measured.map(|measured| measured.force))?;
    Ok(LocatedView { object: measured.and_then(|measured| measured.object.clone()), ..view })
}

/// Reads the columns `image,fx_n,fy_n` and, if present, `object`. Forces are in the frame in which the scene states the camera's pose, N; for a base that does not move, this is
/// the finger frame.
///
/// # Errors
/// [`FileError`] for a force whose image is not in `images`, for a second force of an image, for a zero force, and for an empty `object`.
pub fn forces(path: &Path, images: &[&str]) -> Result<Vec<MeasuredForce>, FileError> {
    let table = Table::of_text(path, &super::read_text(path)?)?;
    table.require(&["image", "fx_n", "fy_n"], &["object"])?;
    let mut forces: Vec<MeasuredForce> = Vec::new();
    for row in &table.rows {
        let image = image_named(table.cell(row, "image"), images).map_err(|reason| table.wrong(row, reason))?;
        if forces.iter().any(|known| known.image == image) {
            return Err(table.wrong(row, format!("image {image:?} is listed twice")));
        }
        let force = Vector::new(table.number(row, "fx_n")?, table.number(row, "fy_n")?);
        if force == Vector::zeros() {
            return Err(table.wrong(row, "expected a force that is not zero"));
        }
        let object = table.has(&["object"]).then(|| table.cell(row, "object").to_owned());
        if object.as_ref().is_some_and(String::is_empty) {
            return Err(
                table.wrong(row, "object: expected the name of the object that pressed the finger, found nothing")
            );
        }
        forces.push(MeasuredForce { image: image.to_owned(), force, object });
    }
    Ok(forces)
}
