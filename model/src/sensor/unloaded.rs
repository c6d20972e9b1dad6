//! The unloaded finger of a scene, which may differ from the scene's finger.

use super::Sensor;
use crate::Vector;
use crate::observation::Observation;
use crate::sensing::{AssemblyErrors, CameraAbove, UnloadedFinger};
use nalgebra::{Isometry2, Point2};

impl Sensor {
    /// Possible errors of the finger, as seen in one observation. `frame` transforms from the finger frame to the reference frame of the camera's
    /// pose. `None` if the scene states none.
    pub(super) fn unloaded(&self, frame: &Isometry2<f64>, seen: &Observation) -> Option<UnloadedFinger> {
        let scene = self.scene();
        let Some(assembly) = scene.assembly.clone() else { return self.of_uncertain_thickness() };
        let references = scene.base.as_ref().map_or(&[][..], |base| &base.references);
        let camera = scene.camera.and_then(|camera| camera.pose).zip(scene.markers).map(|(pose, markers)| {
            let eye = (frame.inverse() * Point2::from(pose.eye().xy())).coords;
            // The camera is assumed to be equally high above base references and markers.
            let middle = match references {
                [] => eye,
                some => some.iter().map(|reference| reference.at).sum::<Vector>() / some.len() as f64,
            };
            CameraAbove { eye, middle, distance_mm: pose.eye().z - markers.height_mm }
        });
        let base_sd_rad = scene.base.as_ref().and_then(|base| base.uncertainty).map_or(0.0, |base| base.sd_rad);
        let measured_in_frame_sd_rad = seen.counts_from_rest(&scene.finger).then_some(base_sd_rad);
        Some(UnloadedFinger { assembly, thickness: scene.thickness_error, camera, measured_in_frame_sd_rad })
    }

    /// Possible errors of the thicknesses alone, which do not depend on an image. `None` for exact thicknesses.
    pub(super) fn of_uncertain_thickness(&self) -> Option<UnloadedFinger> {
        let thickness = self.scene().thickness_error;
        let assembly = AssemblyErrors::default();
        let uncertain = UnloadedFinger { assembly, thickness, camera: None, measured_in_frame_sd_rad: None };
        Some(uncertain).filter(|_| thickness.sd > 0.0)
    }
}
