//! Camera and markers of a scene, for the commands that need them.

use super::{Failure, bad_input};
use finray_files::name_of;
use finray_model::Scene;
use finray_model::camera::{Camera, Lens, Pose};
use finray_model::keys::{CAMERA, MARKERS, SceneTable};
use finray_model::scene::Markers;
use std::path::Path;

/// Failure that names a missing table. The message gives line 1, as for any missing key.
fn missing(path: &Path, what: &str) -> Failure {
    bad_input(format!("{}: line 1: the scene has no {what}; fixtures/scenes/camera.toml has an example", name_of(path)))
}

/// The camera's lens, and its pose if the scene has one.
pub fn camera_of(path: &Path, scene: &Scene) -> Result<(Lens, Option<Pose>), Failure> {
    let keys = [CAMERA.size_px.name, CAMERA.focal_px.name, CAMERA.principal_point_px.name];
    let camera = scene.camera.ok_or_else(|| missing(path, &CAMERA.with(&keys)))?;
    Ok((camera.lens, camera.pose))
}

/// Markers of the scene.
pub fn markers_of(path: &Path, scene: &Scene) -> Result<Markers, Failure> {
    scene.markers.ok_or_else(|| missing(path, &MARKERS.outline()))
}

/// The camera with its pose, and the markers.
pub fn camera_and_markers(path: &Path, scene: &Scene) -> Result<(Camera, Markers), Failure> {
    let (lens, pose) = camera_of(path, scene)?;
    let keys = [CAMERA.rotation_vector_rad.name, CAMERA.translation_mm.name];
    let pose = pose.ok_or_else(|| missing(path, &CAMERA.with(&keys)))?;
    Ok((Camera { lens, pose }, markers_of(path, scene)?))
}
