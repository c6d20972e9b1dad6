//! Effect of camera properties: markers too small for a condition are refused.

use finray_model::Scene;
use finray_model::camera::Camera;
use finray_studies::experiments::camera::CameraStudy;
use finray_studies::settings::{Effort, Progress};

struct Unwatched;

impl Progress for Unwatched {
    fn part(&self, _name: &str, _steps: usize) {}
    fn step(&self) {}
}

/// A condition under which the markers cannot be located gives a refused row; the other rows are unaffected.
#[test]
fn markers_that_are_too_small_for_a_condition_are_refused() {
    let scene = finray_fixtures::CAMERA_SCENE.replace("radius_mm = 1.5", "radius_mm = 0.7");
    let scene = Scene::from_toml(&scene).expect("a scene");
    let (described, markers) = (scene.camera.expect("a camera"), scene.markers.expect("markers"));
    let camera = Camera { lens: described.lens, pose: described.pose.expect("a pose") };
    let study = CameraStudy::of(&scene.finger, 1.5, Effort::Quick, &Unwatched, (&camera, &markers)).expect("a study");
    let quarter = study.rows.iter().find(|row| row.setting == "1/4 along each side").expect("a row");
    assert_eq!((quarter.found, quarter.refused), (0, quarter.forces));
    let as_it_is = study.as_it_is().expect("a row");
    assert_eq!((as_it_is.found, as_it_is.refused), (as_it_is.markers, 0));
}
