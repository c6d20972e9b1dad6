//! Images of a finger under forces that were measured: what is sensed in each, and what each thing that is known of the finger brings.
//!
//! The scene is taken as it is: whether these images were used to calibrate it is for the reader to know.

mod knowledge;
mod lens;
pub mod picture;

use crate::prelude::*;
use finray_model::calibration::{self, CalibrationError, LocatedView, View, ViewModel};
use finray_model::observation::ObservedBase;
use finray_model::sensing::{ContactQuestion, Direction, Lean};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use image::RgbImage;
use knowledge::{KNOWLEDGE, Knowledge};
use picture::Picture;

/// A force that was sensed in an image, or why none was.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredForce {
    /// The image.
    pub image: String,
    /// What pressed the finger; empty where that is not known.
    pub object: String,
    /// What was known.
    pub known: &'static str,
    /// The measured force, N.
    pub measured_n: f64,
    /// The sensed one, N.
    pub sensed_n: Option<f64>,
    /// Its standard deviation, N.
    pub sigma_n: Option<f64>,
    /// Its error as a share of the measured force.
    pub error: Option<f64>,
    /// Its error in standard deviations.
    pub error_over_sigma: Option<f64>,
    /// Where it was sensed to act, mm along the front plate.
    pub s_mm: Option<f64>,
    /// Why it was refused.
    pub refused: String,
}

/// What is left of a marker where the finger is bent by the measured force, its place and base being those that fit best.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MarkerResidual {
    /// The image.
    pub image: String,
    /// The node.
    pub node: usize,
    /// Where the marker is seen, finger frame of the image, mm.
    pub x_mm: f64,
    /// The same.
    pub y_mm: f64,
    /// Computed less seen, mm.
    pub residual_x_mm: f64,
    /// The same.
    pub residual_y_mm: f64,
}

/// Images with measured forces as the scene has them.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredStudy {
    /// Images whose force was measured.
    pub images: usize,
    /// Forces: for each thing that is known, all images.
    pub forces: Vec<MeasuredForce>,
    /// What is left of the markers.
    pub residuals: Vec<MarkerResidual>,
    /// The same over some of the images, where these are there.
    pub pictures: Vec<Picture>,
}

/// An image file that was located, by its name.
pub type NamedImage = (String, RgbImage);

/// Why images are not compared.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// An image has no explanation under its measured force.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// An image that was not located, or has no measured force.
    #[error("image {name:?} is not among those that were located and whose force was measured")]
    NotLocated {
        /// Its name.
        name: String,
    },
    /// A picture that cannot be made.
    #[error(transparent)]
    Picture(#[from] image::ImageError),
}

impl MeasuredStudy {
    /// What was known, in the order of the study, with its forces.
    pub fn by_knowledge(&self) -> impl Iterator<Item = (&'static str, &[MeasuredForce])> {
        self.forces.chunk_by(|a, b| a.known == b.known).map(|forces| (forces[0].known, forces))
    }
}

/// Senses the force in every image whose force was measured. Of the images that are given, pictures show what is left of the markers.
///
/// # Errors
/// [`MeasuredError`] where an image has no explanation under its measured force, or one is given that was not located.
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

/// One image; `None` where the direction is not known as it should be.
fn sensed(
    scene: &Scene,
    finger: &Finger,
    knowledge: &Knowledge,
    seen: &LocatedView,
    force: Vector,
) -> Option<MeasuredForce> {
    let measured = Direction::Angle(scene.finger.angle_deg(force));
    let direction = (knowledge.direction)(measured, scene.contact.lean)?;
    let question = ContactQuestion { position: None, direction };
    // Displacements count from the finger that is meant; by what it misses its markers is part of their noise.
    let mut scene = Scene { finger: finger.clone(), ..scene.clone() };
    let mut observation = seen.observation.clone();
    if !knowledge.base_is_sought {
        scene.base = None;
        observation.base = observation.base.map(|base| ObservedBase { uncertainty: None, ..base });
        for marker in &mut observation.markers {
            marker.sd_mm = marker.own_sd_mm.or(marker.sd_mm);
        }
    }
    let sensor = Sensor::new(&scene, SensorContacts::Asked(vec![question]), SensorOptions::default());
    let answer = sensor.and_then(|sensor| sensor.sense(&observation)).map_err(|refusal| refusal.to_string());
    let measured_n = force.norm();
    let (sensed_n, sigma_n, s_mm, refused) = match answer {
        Ok(found) => {
            let s_mm = found.contacts[0].position_mm(finger);
            (Some(found.forces_n[0]), Some(found.sigmas_n[0]), s_mm, String::new())
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
