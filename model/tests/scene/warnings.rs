//! Warnings about scenes that probably do not describe the real finger.

use finray_model::Scene;
use finray_model::scene::SceneWarning;

/// The finger of `fixtures/calculix/paper.toml`, 20 mm deep, with other lines than that of its side faces.
fn paper_with(side_faces: &str, replaced: (&str, &str)) -> Scene {
    let text = include_str!("../../../fixtures/calculix/paper.toml").replace("side_faces = \"fixed\"\n", side_faces);
    Scene::from_toml(&text.replace(replaced.0, replaced.1)).expect("a scene")
}

fn softer(scene: &Scene) -> Option<f64> {
    scene.warnings().iter().find_map(|warning| match warning {
        SceneWarning::SideFaces { softer } => Some(*softer),
        _ => None,
    })
}

const AS_IT_IS: (&str, &str) = ("", "");

/// A solid of this finger in three dimensions is 7.8 % softer than in plane strain, within the error of free side faces.
#[test]
fn unstated_side_faces_are_warned_of_where_they_matter() {
    let found = softer(&paper_with("", AS_IT_IS)).expect("a warning");
    assert!((found - 0.078).abs() < 0.01, "{found}");
    for stated in ["side_faces = \"fixed\"\n", "side_faces = \"free\"\n"] {
        assert_eq!(softer(&paper_with(stated, AS_IT_IS)), None);
    }
    assert_eq!(softer(&paper_with("", ("poissons_ratio = 0.45", "poissons_ratio = 0.0"))), None);
    // Deep fingers are in plane strain within the model error.
    assert!(softer(&paper_with("", ("depth_mm = 20.0", "depth_mm = 200.0"))).is_some());
    assert_eq!(softer(&paper_with("", ("depth_mm = 20.0", "depth_mm = 2000.0"))), None);
    // A stated model error that covers the side faces silences the warning.
    assert_eq!(softer(&paper_with("model_error = 0.1\n", AS_IT_IS)), None);
}

#[test]
fn moduli_in_pascals_are_warned_of() {
    let scene = paper_with("side_faces = \"fixed\"\n", ("[finger.back]", "[finger.back]\nlargest_strain = 0.05"));
    assert_eq!(scene.warnings(), []);
    let text = include_str!("../../../fixtures/scenes/paper.toml").replace("47.976", "47.976e6");
    let warnings = Scene::from_toml(&text).expect("a scene").warnings();
    assert_eq!(warnings.len(), 3);
    assert!(warnings[1].to_string().starts_with("finger.back.youngs_modulus_mpa is 4.7976e7 MPa"), "{}", warnings[1]);
}
