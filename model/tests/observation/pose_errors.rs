//! Errors of the camera's pose in the displacements of located markers, and in the intervals of forces.

use finray_model::camera::{Camera, Pose};
use finray_model::observation::{Observation, ObservedMarker};
use finray_model::sensing::{ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions, TWO_SIDED_95};
use finray_model::{Kinematics, Load, Mesh, Scene, Vector, statics};
use finray_tests::{at_position, case_count, random_stream, share_error};
use nalgebra::Vector6;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const NOISE_MM: f64 = 0.005;
/// Standard deviations of a tilt, rad, and of the distance, mm, in units of which the errors of the test's pose are.
const TILT_RAD: f64 = 0.015;
const DEPTH_MM: f64 = 0.5;

fn scene() -> Scene {
    let tilt = |axis: usize| Vector6::from_fn(|i, _| if i == axis { TILT_RAD } else { 0.0 });
    let depth = Vector6::from_fn(|i, _| if i == 5 { DEPTH_MM } else { 0.0 });
    let scene = Scene::from_toml(finray_fixtures::CAMERA_SCENE).expect("a scene");
    Scene { pose_errors: vec![tilt(0), tilt(1), depth], ..scene }
}

fn camera(scene: &Scene, motion: &Vector6<f64>) -> Camera {
    let camera = scene.camera.expect("a camera");
    let pose: Pose = camera.pose.expect("a pose");
    Camera { lens: camera.lens, pose: pose.moved(motion) }
}

/// Markers under a load, as a camera whose pose differs by `motion` sees them, located with the scene's pose. Positions of the unloaded markers are those
/// that this pose finds in an image of the unloaded finger.
fn located(scene: &Scene, motion: &Vector6<f64>, load: Load, chance: &mut ChaCha8Rng) -> Observation {
    let mesh = Mesh::with_elements_per_member(&scene.finger, 8);
    let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium");
    let (stated, real) = (camera(scene, &Vector6::zeros()), camera(scene, motion));
    let marker = |node| {
        let at_rest = scene.finger.marker_position(node);
        let pixel = |at: Vector| real.project(&at.push(0.0)).expect("in view");
        let found = |at| stated.on_plane(&pixel(at), 0.0).expect("on the plane");
        let there = at_rest + shape.motion(node).marker_displacement(&scene.finger);
        let noise =
            Vector::from_fn(|_, _| NOISE_MM * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, chance));
        let displacement = found(there) - found(at_rest) + noise;
        let (sd_mm, position) = (Some(NOISE_MM), Some(at_rest + displacement));
        let displacement = Some(displacement);
        ObservedMarker { node, pixel: Some(pixel(there)), position, displacement, sd_mm, own_sd_mm: sd_mm }
    };
    Observation { markers: scene.finger.marked_nodes().map(marker).collect(), ..Observation::default() }
}

/// A camera that looks straight at the finger from a distance larger by dz than assumed sees displacements that are smaller by dz over the distance.
#[test]
fn a_wrong_distance_scales_displacements() {
    let scene = scene();
    let load = Load::at_position(80.0, scene.finger.direction(0.0) * 2.0);
    let seen = located(&scene, &Vector6::zeros(), load, &mut random_stream(6700, 0));
    let found = seen.for_sensing(&scene, true, None).expect("markers");
    let [_, _, depth] = found.measurement.shared_errors() else { panic!("{:?}", found.measurement.shared_errors()) };
    let distance_mm = scene.camera.and_then(|camera| camera.pose).expect("a pose").eye().z;
    for marker in &seen.markers {
        let expected = marker.displacement.expect("located") * (DEPTH_MM / distance_mm);
        let error = depth.pattern_mm[marker.node.0 - 1] - expected;
        assert!(error.norm() < 1e-9 + 1e-6 * expected.norm(), "{error:?} of {expected:?}");
    }
    // A base that moves has its own errors, and displacements of a simulation were not located.
    let simulated =
        Observation { markers: seen.markers.iter().map(|it| ObservedMarker { pixel: None, ..*it }).collect(), ..seen };
    let found = simulated.for_sensing(&scene, true, None).expect("markers");
    assert!(found.measurement.shared_errors().is_empty());
}

/// Intervals of unknown contacts hold for drawn poses. Without the key, the markers contradict every force, so that errors and intervals are larger.
#[test]
fn intervals_hold_for_a_pose_that_was_found_in_an_image() {
    let (scene, cases) = (scene(), case_count(40, 400));
    let exact = Scene { pose_errors: Vec::new(), ..scene.clone() };
    let (mut held, mut squares) = (0, [0.0; 2]);
    for case in 0..cases {
        let chance = &mut random_stream(6701, case as u64);
        let motion: Vector6<f64> = scene
            .pose_errors
            .iter()
            .map(|error| error * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, chance))
            .sum();
        let force_n: f64 = chance.random_range(1.0..3.0);
        let contact = at_position(chance.random_range(40.0..110.0), chance.random_range(-25.0..25.0));
        let seen = located(&scene, &motion, contact.load(&scene.finger, force_n), chance);
        for (scene, squares) in [&scene, &exact].into_iter().zip(&mut squares) {
            let contacts = SensorContacts::Asked(vec![ContactQuestion::new(None, Direction::Auto)]);
            let sensor = Sensor::new(scene.clone(), contacts, SensorOptions::default()).expect("a contact");
            let sensed = sensor.sense(&seen).expect("a force").forces[0];
            let share = sensed.force_n / force_n - 1.0;
            *squares += share * share;
            held += usize::from(!scene.pose_errors.is_empty() && share.abs() * force_n < TWO_SIDED_95 * sensed.sigma_n);
        }
    }
    let [with, without] = squares.map(|sum| (sum / cases as f64).sqrt());
    println!("held {held} of {cases}, rms error {with:.4}, without the key {without:.4}");
    let share = held as f64 / cases as f64;
    assert!((share - 0.95).abs() < 0.01 + 2.5 * share_error(0.95, cases), "{held} of {cases}");
    assert!(2.0 * with < without, "{with} {without}");
}
