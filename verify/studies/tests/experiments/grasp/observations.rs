//! Observations of grasps: totals of the two fingers, and opening compared with closing.

use finray_model::Scene;
use finray_studies::experiments::grasp::observations::{Totals, totals};
use finray_studies::experiments::grasp::{Eyes, GraspScene, GraspStep};

/// Totals of a grasp in which the fingers close on the disc on its support, and open again.
fn observed(friction: &str, noise_mm: f64) -> Totals {
    let changes = [
        ("friction = 0.4", friction),
        ("motor_deg = [0.0, -495.0]", "motor_deg = [0.0, -382.5]"),
        ("path_mm = [[0.0, -40.0], [60.0, -40.0], [60.0, 0.0]]\npath_steps = 12", "open = true"),
    ];
    let text = changes.iter().fold(finray_fixtures::GRASPED_DISC_SCENE.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    let grasp = GraspScene::new(&Scene::from_toml(&text).unwrap(), &[]).unwrap().with_fineness(1);
    let mut steps: Vec<GraspStep> = Vec::new();
    grasp.run(&Eyes::Noise(noise_mm), 1, |step| steps.push(step.clone())).unwrap();
    totals(grasp.finger(), &steps).expect("something is sensed")
}

/// Only friction causes a difference between opening and closing, and only noise causes a difference between the two fingers.
#[test]
fn friction_and_noise_make_the_differences() {
    let [smooth, rough, noisy] = [("friction = 0.0", 0.0), ("friction = 0.4", 0.0), ("friction = 0.0", 0.067)]
        .map(|(friction, noise_mm)| observed(friction, noise_mm));
    assert!(smooth.opening.unwrap() < 1e-3, "{smooth:?}");
    assert!(smooth.opening_at_nodes.unwrap() < 1e-3, "{smooth:?}");
    assert!(rough.opening_at_nodes.unwrap() > rough.opening.unwrap(), "contacts slide, {rough:?}");
    assert!(rough.opening.unwrap() > 10.0 * smooth.opening.unwrap(), "{rough:?}");
    assert!(smooth.opening_sensed.unwrap() < 0.01, "{smooth:?}");
    // Without friction, the disc slides to the middle. Without friction and noise, the sensed totals of the two fingers differ only by rounding.
    assert!(noisy.left_right[0] > 3.0 * smooth.left_right[0], "{noisy:?} {smooth:?}");
    assert!(noisy.left_right[0] < noisy.left_right[1] && noisy.left_right[1] < 1.0, "{noisy:?}");
}

#[test]
fn nothing_sensed_is_nothing_observed() {
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).unwrap().finger;
    assert_eq!(totals(&finger, &[]), None);
}
