//! Builds fingers from scene files, and defines the fineness of the meshes in tests.

use finray_model::finger::{FingerDescription, RibPositions};
use finray_model::{Finger, Scene};

/// Elements per member of the meshes on which tests sense forces. With this number of elements, the discretisation error is small compared with the
/// noise.
pub const ELEMENTS: usize = 4;

/// The paper's finger.
pub fn paper() -> Finger {
    finger_of(finray_fixtures::PAPER_SCENE)
}

/// The mirror image of a finger without zones: front and back plate are exchanged, and y changes its sign.
pub fn mirrored(finger: &Finger) -> Finger {
    let mut mirrored: FingerDescription = finger.description().clone();
    assert!(mirrored.zones.is_empty(), "a finger without zones");
    std::mem::swap(&mut mirrored.front_length_mm, &mut mirrored.back_length_mm);
    std::mem::swap(&mut mirrored.front, &mut mirrored.back);
    mirrored.rigid_ends.reverse();
    mirrored.ribs.clip_mm.reverse();
    mirrored.ribs.bracket_mm.all_mut().iter_mut().for_each(|ends_mm| ends_mm.reverse());
    if let RibPositions::Positions(positions) = &mut mirrored.ribs.positions {
        positions.iter_mut().for_each(|ends_mm| ends_mm.reverse());
    }
    Finger::new(mirrored).expect("a finger")
}

/// The finger that the text of a scene file describes.
#[track_caller]
pub fn finger_of(scene: &str) -> Finger {
    Scene::from_toml(scene).expect("a good scene").finger
}

/// The paper's scene after replacements in its text: in each pair, the second string replaces every occurrence of the first string.
#[track_caller]
pub fn paper_scene_with(changes: &[(&str, &str)]) -> Scene {
    let text = changes.iter().fold(finray_fixtures::PAPER_SCENE.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the paper's scene has no {from}");
        text.replace(from, to)
    });
    Scene::from_toml(&text).expect("a good scene")
}
