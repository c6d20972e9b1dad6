//! Images of a finger under measured forces: the force sensed in each image, and the benefit of each piece of prior knowledge.
//!
//! The scene is used unchanged. The scene does not record whether it was calibrated with these images.

mod knowledge;
mod lens;
pub mod picture;

use crate::prelude::*;
use finray_model::calibration::{self, CalibrationError, LocatedView, View, ViewModel};
use finray_model::observation::{Observation, ObservedBase};
use finray_model::sensing::{ContactQuestion, Direction, Lean};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use image::RgbImage;
use knowledge::{KNOWLEDGE, Knowledge};
use picture::Picture;

/// The force sensed in an image, or the reason why no force was sensed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredForce {
    /// Name of the image.
    pub image: String,
    /// Object that pressed the finger; empty if unknown.
    pub object: String,
    /// Prior knowledge of the estimator, in words.
    pub known: &'static str,
    /// Measured force, N.
    pub measured_n: f64,
    /// Sensed force, N; `None` if refused.
    pub sensed_n: Option<f64>,
    /// Stated standard deviation of the sensed force, N.
    pub sigma_n: Option<f64>,
    /// Error of the sensed force, relative to the measured force.
    pub error: Option<f64>,
    /// Error of the sensed force, in standard deviations.
    pub error_over_sigma: Option<f64>,
    /// Sensed position of the force along the front plate, mm.
    pub s_mm: Option<f64>,
    /// Reason of a refusal; empty otherwise.
    pub refused: String,
}

/// Residual of a marker for the finger under the measured force, with the best-fitting contact position and base.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MarkerResidual {
    /// Name of the image.
    pub image: String,
    /// Node of the marker.
    pub node: usize,
    /// Observed position of the marker along x, finger frame of the image, mm.
    pub x_mm: f64,
    /// Observed position of the marker along y, finger frame of the image, mm.
    pub y_mm: f64,
    /// Computed minus observed position along x, mm.
    pub residual_x_mm: f64,
    /// Computed minus observed position along y, mm.
    pub residual_y_mm: f64,
}

/// Results on the images with measured forces.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredStudy {
    /// Number of images with a measured force.
    pub images: usize,
    /// Sensed forces, ordered by prior knowledge, then by image.
    pub forces: Vec<MeasuredForce>,
    /// Residuals of all markers.
    pub residuals: Vec<MarkerResidual>,
    /// Pictures that show the residuals over the images. Only images whose file is given have a picture.
    pub pictures: Vec<Picture>,
}

/// Name and content of a located image file.
pub type NamedImage = (String, RgbImage);

/// Why the study of measured images failed.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// No shape explains an image under its measured force.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The image was not located, or has no measured force.
    #[error("image {name:?} needs located markers and a measured force, but lacks at least one of them")]
    NotLocated {
        /// Name of the image.
        name: String,
    },
    /// A picture of the residuals cannot be made.
    #[error(transparent)]
    Picture(#[from] image::ImageError),
}

impl MeasuredStudy {
    /// Sensed forces by prior knowledge, in the order of the study.
    pub fn by_knowledge(&self) -> impl Iterator<Item = (&'static str, &[MeasuredForce])> {
        self.forces.chunk_by(|a, b| a.known == b.known).map(|forces| (forces[0].known, forces))
    }
}

/// Senses the force in every image with a measured force. Pictures show the residuals of the markers over the given image files.
///
/// # Errors
/// [`MeasuredError`] if no shape explains an image under its measured force, or a given image was not located.
pub fn run(scene: &Scene, seen: &[LocatedView], images: &[NamedImage]) -> Result<MeasuredStudy, MeasuredError> {
    let measured: Vec<(&LocatedView, Vector)> =
        seen.iter().filter_map(|seen| seen.view.force.map(|force| (seen, force))).collect();
    let mut forces = Vec::new();
    for knowledge in &KNOWLEDGE {
        let Some(finger) = (knowledge.finger)(&scene.finger) else { continue };
        if (knowledge.direction)(Direction::NORMAL, scene.contact.lean).is_none() {
            continue;
        }
        let of = |(seen, force): &(&LocatedView, Vector)| match knowledge.lens_is_known {
            true => sensed(scene, &finger, knowledge, seen, *force),
            false => {
                let seen = lens::without_distortion(scene, seen)?;
                sensed(scene, &finger, knowledge, &seen, seen.view.force?)
            }
        };
        forces.extend(measured.par_iter().filter_map(of).collect::<Vec<_>>());
    }
    let model = ViewModel::of_scene(scene, scene.contact.lean.unwrap_or(Lean::NONE));
    let views: Vec<View> = measured.iter().map(|(seen, _)| seen.view.clone()).collect();
    let fitted = calibration::views(&scene.finger, &views, &[], &model)?;
    if let Some((name, _)) = images.iter().find(|(name, _)| measured.iter().all(|(seen, _)| seen.view.name != *name)) {
        return Err(MeasuredError::NotLocated { name: name.clone() });
    }
    let (mut residuals, mut pictures) = (Vec::new(), Vec::new());
    for ((seen, _), found) in measured.iter().zip(&fitted.views) {
        let markers = seen.view.measurement.markers().iter().zip(&found.residuals_mm);
        let of_image = markers.map(|(marker, residual)| {
            let at = scene.finger.marker_position(marker.node) + marker.displacement;
            MarkerResidual {
                image: seen.view.name.clone(),
                node: marker.node.0,
                x_mm: at.x,
                y_mm: at.y,
                residual_x_mm: residual.x,
                residual_y_mm: residual.y,
            }
        });
        let of_image: Vec<MarkerResidual> = of_image.collect();
        if let Some((_, image)) = images.iter().find(|(name, _)| *name == seen.view.name) {
            pictures.extend(picture::picture(scene, seen, &of_image, image)?);
        }
        residuals.extend(of_image);
    }
    Ok(MeasuredStudy { images: measured.len(), forces, residuals, pictures })
}

/// Senses the force in one image; `None` if this prior knowledge requires a direction that is not available.
fn sensed(
    scene: &Scene,
    finger: &Finger,
    knowledge: &Knowledge,
    seen: &LocatedView,
    force: Vector,
) -> Option<MeasuredForce> {
    let measured = Direction::Angle(scene.finger.angle_deg(force));
    let direction = (knowledge.direction)(measured, scene.contact.lean)?;
    let question = ContactQuestion::new(None, direction);
    // Displacements are computed relative to the assumed finger; the model error of this finger counts as noise of the markers.
    let mut scene = Scene { finger: finger.clone(), ..scene.clone() };
    // A scene that knows less is not a change of the scene with which the markers were located.
    let mut observation = Observation { located_with: None, ..seen.observation.clone() };
    if !knowledge.base_is_sought {
        scene.base = None;
        observation.base = observation.base.map(|base| ObservedBase { uncertainty: None, ..base });
        for marker in &mut observation.markers {
            marker.sd_mm = marker.own_sd_mm.or(marker.sd_mm);
        }
    }
    let sensor = Sensor::new(scene, SensorContacts::Asked(vec![question]), SensorOptions::default());
    let answer = sensor.and_then(|sensor| sensor.sense(&observation)).map_err(|refusal| refusal.to_string());
    let measured_n = force.norm();
    let (sensed_n, sigma_n, s_mm, refused) = match answer {
        Ok(found) => {
            let force = found.forces[0];
            (Some(force.force_n), Some(force.sigma_n), force.contact.position_mm(finger), String::new())
        }
        Err(reason) => (None, None, None, reason),
    };
    let off_n = sensed_n.map(|sensed_n| sensed_n - measured_n);
    Some(MeasuredForce {
        image: seen.view.name.clone(),
        object: seen.object.clone().unwrap_or_default(),
        known: knowledge.name,
        measured_n,
        sensed_n,
        sigma_n,
        error: off_n.map(|off_n| off_n / measured_n),
        error_over_sigma: off_n.zip(sigma_n).map(|(off_n, sigma_n)| off_n / sigma_n),
        s_mm,
        refused,
    })
}
