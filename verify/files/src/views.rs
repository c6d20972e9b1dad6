//! Several images of one finger with the forces that were measured: what `calibrate` reads.

use super::FileError;
use super::displacements::{self, Reading};
use super::table::{Table, header};
use finray_model::calibration::View;
use finray_model::measurement::{BaseUncertainty, MarkerErrors};
use finray_model::scene::Base;
use finray_model::{Scene, Vector};
use nalgebra::{Isometry2, Point2};
use std::path::Path;

/// An image that was located.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedView {
    /// Where the base is, in the frame of the camera's pose.
    pub base: Isometry2<f64>,
    /// What was measured.
    pub view: View,
}

/// Images that were located.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedViews {
    /// Each image.
    pub views: Vec<LocatedView>,
    /// By how much the file differs, at worst, from what this scene would have made of the same markers, mm: zero but for rounding where they were
    /// located with it.
    pub misplaced_mm: f64,
}

/// Standard deviations of a base, mm and rad, that is known exactly: far below what an image shows.
const EXACT: (f64, f64) = (1e-4, 1e-6);

/// Reads what `locate` wrote of several images, and `image,fx_n,fy_n` with the forces that were measured, in the frame of the camera's pose: that of the
/// finger where its base does not move.
///
/// # Errors
/// [`FileError`] for anything that does not fit the finger, or a force of an image that is not there.
pub fn load(located: &Path, forces: Option<&Path>, scene: &Scene) -> Result<LocatedViews, FileError> {
    let text = super::read_text(located)?;
    let misplaced_mm = super::origin::misplaced_mm(located, &text, scene)?;
    let is_of_pose = scene.base.as_ref().is_some_and(Base::is_of_pose);
    let has_base = !is_of_pose && header(&text).iter().any(|column| column == "base_deg");
    let mut images: Vec<(String, Isometry2<f64>)> = Vec::new();
    let mut note = |image: &str, base: Isometry2<f64>| {
        if images.iter().all(|(known, _)| known != image) {
            images.push((image.to_owned(), base));
        }
    };
    if has_base {
        let table = Table::of_text(located, &text, ["image", "base_x_mm", "base_y_mm", "base_deg"])?;
        for row in table.rows() {
            let at = Vector::new(table.number(row, 1)?, table.number(row, 2)?);
            note(&row.cells[0], Isometry2::new(at, table.number(row, 3)?.to_radians()));
        }
    } else {
        let table = Table::of_text(located, &text, ["image"])?;
        table.rows().iter().for_each(|row| note(&row.cells[0], Isometry2::identity()));
    }
    let forces = match forces {
        None => Vec::new(),
        Some(path) => load_forces(path, &images)?,
    };
    // The camera stands above the frame of its pose; without a camera, nowhere in particular.
    let eye = scene.camera.and_then(|camera| camera.pose).map_or(Vector::zeros(), |pose| pose.eye().xy());
    let reading = Reading {
        from_positions: true,
        errors: MarkerErrors::default(),
        base: scene.base.as_ref().and_then(|base| base.uncertainty),
        base_is_sought: true,
        base_is_of_pose: is_of_pose,
        noise_mm: scene.noise_mm,
    };
    let view = |(image, base): (String, Isometry2<f64>)| {
        let found = displacements::of_text(located, &text, &scene.finger, Some(&image), reading)?;
        let noise_mm = found.noise_mm.or(scene.noise_mm).ok_or_else(|| {
            FileError::content(
                located,
                "expected a column sigma_mm, as locate writes it, or noise_mm in the scene's table camera",
            )
        })?;
        let force = forces.iter().find(|(name, _)| *name == image).map(|(_, force)| base.rotation.inverse() * force);
        let known = found.measurement.base().unwrap_or_default();
        let uncertainty =
            BaseUncertainty { sd_mm: known.sd_mm.max(EXACT.0), sd_rad: known.sd_rad.max(EXACT.1), ..known };
        let eye = (base.inverse() * Point2::from(eye)).coords;
        let view = View { name: image, measurement: found.measurement, noise_mm, base: uncertainty, eye, force };
        Ok(LocatedView { base, view })
    };
    Ok(LocatedViews { views: images.into_iter().map(view).collect::<Result<_, _>>()?, misplaced_mm })
}

fn load_forces(path: &Path, images: &[(String, Isometry2<f64>)]) -> Result<Vec<(String, Vector)>, FileError> {
    let table = Table::read(path, ["image", "fx_n", "fy_n"])?;
    let mut forces: Vec<(String, Vector)> = Vec::new();
    for row in table.rows() {
        let image = row.cells[0].as_str();
        if images.iter().all(|(known, _)| known != image) {
            return Err(table.wrong(row, format!("image {image:?} is not among those that were located")));
        }
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
