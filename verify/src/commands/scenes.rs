//! Parts of a scene that commands need: the finger (by default the paper's), camera and markers.

use super::{Failure, bad_input, hints, not_computed};
use finray_files::{load_network, load_scene_and_text, name_of};
use finray_fixtures::PAPER_SCENE;
use finray_model::Scene;
use finray_model::camera::{Camera, Lens, Pose};
use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::keys::{CAMERA, MARKERS, SceneTable};
use finray_model::scene::{Markers, SceneWarning};
use std::path::Path;

/// The scene of a file with its text; without a path, the paper's finger. Prints the warnings about the scene, except those that do not matter to the
/// command.
///
/// # Errors
/// [`Failure`] if the file cannot be read or is not a valid scene.
pub fn scene_or_papers(
    path: Option<&Path>,
    no_matter: impl Fn(&SceneWarning) -> bool,
) -> Result<(Scene, String), Failure> {
    let Some(path) = path else {
        let scene = Scene::from_toml(PAPER_SCENE).map_err(not_computed)?;
        return Ok((scene, PAPER_SCENE.to_owned()));
    };
    let (scene, text) = load_scene_and_text(path)?;
    hints::of_scene_without(path, &scene, no_matter);
    Ok((scene, text))
}

/// The networks for `estimators`: with a path, the network of that file and the digest of the file; without a path, the shipped networks.
pub fn networks_of(path: Option<&Path>, estimators: &[EstimatorId]) -> Result<(Networks, Option<String>), Failure> {
    let Some(path) = path else { return Ok((Networks::read(&finray_fixtures::NETWORKS)?, None)) };
    if !estimators.contains(&EstimatorId::Network) {
        return Err(bad_input("--network: expected the option --estimator network as well, found another estimator"));
    }
    let (network, digest) = load_network(path)?;
    Ok((Networks::of(vec![network]), Some(digest)))
}

/// The error for a missing table. The message names line 1, as for any missing key.
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
