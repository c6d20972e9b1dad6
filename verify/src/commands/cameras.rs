//! The camera and markers that a command needs of a scene.

use super::{Failure, bad_input};
use finray_model::Scene;
use finray_model::camera::{Camera, Lens, Pose};
use finray_model::scene::Markers;

fn missing(what: &str) -> Failure {
    bad_input(format!("the scene has no {what}; fixtures/scenes/camera.toml has an example"))
}

/// The lens, and the pose where the scene has it.
pub fn camera_of(scene: &Scene) -> Result<(Lens, Option<Pose>), Failure> {
    let camera = scene.camera.ok_or_else(|| missing("[camera] with size_px, focal_px and principal_point_px"))?;
    Ok((camera.lens, camera.pose))
}

/// The markers.
pub fn markers_of(scene: &Scene) -> Result<Markers, Failure> {
    scene.markers.ok_or_else(|| missing("[markers]"))
}

/// The camera with its pose, and the markers.
pub fn camera_and_markers(scene: &Scene) -> Result<(Camera, Markers), Failure> {
    let (lens, pose) = camera_of(scene)?;
    let pose = pose.ok_or_else(|| missing("rotation_vector_rad and translation_mm in [camera]"))?;
    Ok((Camera { lens, pose }, markers_of(scene)?))
}
