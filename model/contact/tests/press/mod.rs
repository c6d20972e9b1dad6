//! Objects pressed onto a finger: equilibria compared with closed forms and beams (`equilibria`), contacts measured by the camera (`contacts`), and
//! refused scenes (`refusals`). This file builds scenes with the paper's finger.

use finray_contact::path::PreparedObject;
use finray_contact::press::{ContactScene, SceneStep};
use finray_model::Scene;
use finray_model::scene::ObjectDescription;

mod contacts;
mod equilibria;
mod refusals;

/// Number of elements of each member for tests that need only the order of magnitude of the bending.
const COARSE: usize = 1;

/// A scene with the paper's finger and an object.
fn scene(object: &str) -> Scene {
    Scene::from_toml(&format!("{}\n[object]\n{object}", finray_fixtures::PAPER_SCENE)).expect("a good scene")
}

/// An object in front of the paper's finger.
pub(super) fn object_of(object: &str) -> PreparedObject {
    prepared(&scene(object)).object().clone()
}

fn prepared(scene: &Scene) -> ContactScene {
    let object: &ObjectDescription = scene.object.as_ref().expect("an object");
    ContactScene::new(scene, object, &[]).expect("an outline")
}

fn steps(scene: &ContactScene) -> Vec<SceneStep> {
    let mut steps = Vec::new();
    scene.run(|step| steps.push(step)).expect("everything comes to rest");
    steps
}

fn last(object: &str, fineness: usize) -> SceneStep {
    steps(&prepared(&scene(object)).with_fineness(fineness)).pop().expect("a step")
}
