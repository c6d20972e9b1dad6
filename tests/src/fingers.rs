//! Fingers of scene files, and the meshes of the paper's.

use finray_model::{Finger, Scene};

/// Elements a member of the meshes on which tests sense: their error is small beside the noise.
pub const ELEMENTS: usize = 4;

/// The paper's finger.
pub fn paper() -> Finger {
    finger_of(finray_fixtures::PAPER_SCENE)
}

/// The finger of a scene's text.
#[track_caller]
pub fn finger_of(scene: &str) -> Finger {
    Scene::from_toml(scene).expect("a good scene").finger
}

/// The paper's scene with texts replaced, everywhere they stand.
#[track_caller]
pub fn paper_scene_with(changes: &[(&str, &str)]) -> Scene {
    let text = changes.iter().fold(finray_fixtures::PAPER_SCENE.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the paper's scene has no {from}");
        text.replace(from, to)
    });
    Scene::from_toml(&text).expect("a good scene")
}
