//! Tests of the report's checks of contact scenes.

use crate::check::assert_all_pass;
use finray_contact::press::{ContactScene, SensedForce};
use finray_model::scene::{ObjectDescription, ObjectMotion, Until};
use finray_model::sensing::ContactPosition;
use finray_model::{NodeId, Scene};
use finray_studies::experiments::contact_scene::samples::NoiseSamples;
use finray_studies::experiments::contact_scene::study::{SAMPLES, SceneStudy, SceneWithOutline, run_all, shipped};
use finray_tests::CAMERA_NOISE_MM;

/// Number of elements of each member for tests that need only the order of magnitude of the bending.
const COARSE: usize = 1;

/// A scene with the paper's finger and an object.
fn scene(object: &str) -> Scene {
    Scene::from_toml(&format!("{}\n[object]\n{object}", finray_fixtures::PAPER_SCENE)).expect("a good scene")
}

fn prepared(scene: &Scene) -> ContactScene {
    let object: &ObjectDescription = scene.object.as_ref().expect("an object");
    ContactScene::new(scene, object, &[]).expect("an outline")
}

/// The report's first scene passes all its checks, here with fewer steps.
#[test]
fn a_disc_pressed_to_5_n_passes_every_check() {
    let mut given = shipped().expect("scenes that ship").swap_remove(0);
    let object = given.scene.object.as_mut().expect("an object");
    assert!(matches!(object.motion, ObjectMotion::Press { until: Until::Force(5.0), .. }));
    object.steps = 2;
    let prepared = prepared(&given.scene);
    let study = SceneStudy::run("disc", &prepared, CAMERA_NOISE_MM, SAMPLES, &|| ()).expect("a study");
    assert_all_pass(&study.shipped_checks());
    let end = &study.steps[1].step;
    let nodes: Vec<_> = end.contacts.iter().map(|seen| seen.contact.position).collect();
    assert_eq!(nodes, [19, 18].map(|node| ContactPosition::Node(NodeId(node))), "two neighbours share the force");
    assert_eq!(study.steps[1].samples.as_ref().expect("noise").sensed.len(), 3);
}

/// With friction within its known bound, the stated intervals contain the forces and are narrow enough. If sensing assumes normal forces, its
/// intervals miss the true forces, and the checks fail.
#[test]
fn friction_is_within_the_stated_intervals() {
    let mut given = shipped().expect("scenes that ship").swap_remove(3);
    given.scene.object.as_mut().expect("an object").steps = 3;
    let known = prepared(&given.scene);
    let run = |scene: &ContactScene| SceneStudy::run("friction", scene, CAMERA_NOISE_MM, 50, &|| ()).expect("a study");
    let study = run(&known);
    assert_all_pass(&study.shipped_checks());
    assert!(
        study.shipped_checks().iter().filter(|check| check.problem.contains("within 1.96 stated sigma")).count() == 4
    );
    for studied in &study.steps {
        let samples = studied.samples.as_ref().expect("noise");
        for (which, seen) in studied.step.contacts.iter().enumerate() {
            let sigma_n = samples.rms_sigma_n(which);
            assert!(sigma_n < 0.5 * seen.normal_n, "{sigma_n} N says little of {} N", seen.normal_n);
        }
    }
    let unknown = run(&known.with_assumed_friction(0.0));
    let failed: Vec<_> = unknown.shipped_checks().into_iter().filter(|check| !check.passes()).collect();
    assert!(failed.iter().any(|check| check.problem.contains("every contact's force")), "{failed:?}");
    let frictionless = SceneStudy { friction: 0.0, ..study };
    assert!(frictionless.checks().iter().any(|check| !check.passes() && check.source == "Coulomb"));
}

/// Refused samples count as not covered: if half of the samples are refused, the coverage is at most 50 %.
#[test]
fn refused_samples_are_not_covered() {
    let exact = SensedForce { true_n: 1.0, sensed_n: 1.0, sigma_n: 0.1 };
    let samples = NoiseSamples { taken: 100, answered: 50, sensed: vec![vec![exact; 50]; 2] };
    assert_eq!((samples.covered(0), samples.coverage(1)), (50, 0.5));
    let scene = scene("shape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = 1\nsteps = 1");
    let mut study = SceneStudy::run("refused", &prepared(&scene).with_fineness(COARSE), CAMERA_NOISE_MM, 1, &|| ())
        .expect("a study");
    study.steps[0].samples = Some(samples);
    let failed = study.shipped_checks().into_iter().filter(|check| !check.passes() && check.problem.contains("sigma"));
    assert_eq!(failed.count(), 4, "contacts and total, over all and where fewest");
}

/// On a path that begins without contact, only the steps with contact are checked.
#[test]
fn steps_without_contact_fail_no_check() {
    let scene = scene("shape = \"disc\"\nradius_mm = 10\npath_mm = [[75, 40], [75, 15]]\nsteps = 5");
    let study = SceneStudy::run("from afar", &prepared(&scene), 0.0, 0, &|| ()).expect("a study");
    assert!(study.steps[0].step.contacts.is_empty() && study.steps[0].step.total_n().is_sign_positive());
    assert_all_pass(&study.checks());
}

/// A free object requires a gripper: a report on its scene has no pressed object.
#[test]
fn a_free_object_is_not_studied() {
    let given = SceneWithOutline::from_toml(finray_fixtures::GRASPED_DISC_SCENE).expect("a scene");
    assert!(run_all(&[given], 0.0, 0, &|| ()).expect("nothing to study").is_empty());
}
