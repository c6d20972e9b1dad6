//! Refused contact scenes, and scenes without equilibrium.

use super::{COARSE, prepared, scene, steps};
use finray_contact::ContactError;
use finray_contact::outline::{ContactOutline, OutlineError};
use finray_contact::path::PressError;
use finray_contact::press::ContactScene;
use finray_model::Vector;
use finray_model::finger::Plate;

#[test]
fn what_is_no_outline_is_refused() {
    let given = scene("shape = \"polygon\"\npoints_csv = \"x.csv\"\nat_mm = 70\ntravel_mm = 1");
    let object = given.object.expect("an object");
    let outline = |corners: &[[f64; 2]]| {
        let corners: Vec<Vector> = corners.iter().map(|&corner| corner.into()).collect();
        ContactOutline::of_object(&object, &corners)
    };
    let crossed = [[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]];
    assert_eq!(outline(&crossed), Err(OutlineError::Crossed));
    assert_eq!(outline(&[[0.0, 0.0], [5.0, 5.0], [10.0, 10.0]]), Err(OutlineError::Crossed));
    assert_eq!(outline(&crossed[..2]), Err(OutlineError::TooFewCorners { corners: 2 }));
    assert_eq!(outline(&[[0.0, 0.0], [1e9, 0.0], [0.0, 1.0]]), Err(OutlineError::TooFar { corner: 2 }));
    assert!(outline(&[[0.0, 0.0], [0.0, 10.0], [10.0, 10.0], [10.0, 0.0]]).is_ok(), "clockwise");
}

/// Share of the reported force at which the finger must still hold the object. An object that the finger loses takes some increments to leave, during
/// which the force grows.
const HELD: f64 = 0.8;

/// The error states the force at which the object was lost, at the tip and in the middle of the finger. In the middle, reaching the requested force
/// would take hours, so the run must end when the finger loses the object.
#[test]
fn an_object_that_the_finger_lets_go_is_said_so() {
    let at_tip = ("radius_mm = 5\nat_mm = 153\ndirection_deg = 80", 5.0);
    let in_middle = ("radius_mm = 20\nat_mm = 74", 1e4);
    for (object, too_much_n) in [at_tip, in_middle] {
        let pressed = |force_n: f64| {
            let scene = scene(&format!("shape = \"disc\"\n{object}\nforce_n = {force_n:?}\nsteps = 1"));
            prepared(&scene).with_fineness(COARSE).run(|_| ()).map(|_| ())
        };
        let outcome = pressed(too_much_n);
        let Err(ContactError::LetGo { touched_n: Some(touched_n) }) = outcome else { panic!("{object}: {outcome:?}") };
        assert_eq!(pressed(HELD * touched_n), Ok(()), "{object}, {touched_n} N");
        let lost = pressed(touched_n);
        assert!(matches!(lost, Err(ContactError::LetGo { .. })), "{object}, {touched_n} N: {lost:?}");
    }
}

#[test]
fn an_object_must_start_outside_the_finger() {
    let inside = scene("shape = \"disc\"\nradius_mm = 10\npath_mm = [[50, 20], [50, 10]]");
    let outcome = prepared(&inside).with_fineness(COARSE).run(|_| ());
    assert!(matches!(outcome, Err(ContactError::Overlap { .. })), "{outcome:?}");
    // The first touch of a press is not an overlap, at any position and in any direction.
    for (at_mm, direction_deg) in [(0.0, 0.0), (70.0, 60.0), (70.0, -60.0), (153.0, 20.0)] {
        let object = format!(
            "shape = \"disc\"\nradius_mm = 10\nat_mm = {at_mm}\ndirection_deg = {direction_deg}\ntravel_mm = 0.01\nsteps = 1"
        );
        let scene = scene(&object);
        steps(&prepared(&scene).with_fineness(COARSE));
        let along = scene.finger.direction(direction_deg);
        let start = prepared(&scene).object().start;
        let line = scene.finger.plate_point(Plate::Front, at_mm) - start;
        assert!(line.perp(&along).abs() < 1e-9, "the line meets the position");
    }
}

/// A free object requires a gripper, so a press is refused.
#[test]
fn a_free_object_is_not_pressed() {
    let scene = finray_model::Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE).expect("a scene");
    let object = scene.object.clone().expect("an object");
    assert_eq!(ContactScene::new(&scene, &object, &[]).err(), Some(PressError::Free));
}
