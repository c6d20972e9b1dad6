//! Errors of the camera's pose in the displacements of located markers, and in the intervals of forces.

use finray_model::camera::{Camera, Pose};
use finray_model::observation::{Observation, ObservedMarker, nodes_of_markers};
use finray_model::sensing::{ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions, TWO_SIDED_95};
use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, Vector, statics};
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

/// Centres of markers on the nodes, mm, as a camera whose pose differs by `motion` sees them and the scene's pose locates them.
fn found(scene: &Scene, motion: &Vector6<f64>, at: Vector) -> Vector {
    let pixel = camera(scene, motion).project(&at.push(0.0)).expect("in view");
    camera(scene, &Vector6::zeros()).on_plane(&pixel, 0.0).expect("on the plane")
}

/// The scene with the offsets of the markers that its pose finds in an image of the unloaded finger, which a camera of another pose has taken.
fn set_up(scene: &Scene, motion: &Vector6<f64>) -> Scene {
    let offset = |node| {
        let node = NodeId(node);
        found(scene, motion, scene.finger.marker_position(node)) - scene.finger.marker_position(node)
    };
    let marker_offsets = (1..=scene.finger.key_node_count()).map(offset).collect();
    Scene { marker_offsets, ..scene.clone() }
}

/// Markers under a load in an image of a camera whose pose differs by `motion`, located with the scene's pose and offsets.
fn located(scene: &Scene, motion: &Vector6<f64>, load: Load, chance: &mut ChaCha8Rng) -> Observation {
    let finger = &scene.finger;
    let mesh = Mesh::with_elements_per_member(finger, 8);
    let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium");
    let real = |node| finger.marker_position(node) + shape.motion(node).marker_displacement(finger);
    let mut noise = |_, _| NOISE_MM * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, chance);
    let seen = finger.marked_nodes().map(|node| (node, found(scene, motion, real(node)) + Vector::from_fn(&mut noise)));
    let seen: Vec<_> = seen.collect();
    let marker = |(&(node, _), (at, _)): (&(NodeId, Vector), (Vector, f64))| {
        let displacement = Some(at - finger.marker_position(node));
        let pixel = camera(scene, motion).project(&real(node).push(0.0)).ok();
        ObservedMarker {
            node,
            pixel,
            position: Some(at),
            displacement,
            sd_mm: Some(NOISE_MM),
            own_sd_mm: Some(NOISE_MM),
        }
    };
    let markers = seen.iter().zip(nodes_of_markers(finger, &scene.marker_offsets, &seen)).map(marker).collect();
    Observation { markers, ..Observation::default() }
}

/// A camera that looks straight at the finger from a distance larger by dz than assumed sees displacements that are smaller by dz over the distance.
#[test]
fn a_wrong_distance_scales_displacements() {
    let scene = scene();
    let load = Load::at_position(80.0, scene.finger.direction(0.0) * 2.0);
    // Markers that are centred on their nodes.
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
        let seen = located(&set_up(&scene, &motion), &motion, contact.load(&scene.finger, force_n), chance);
        for (scene, squares) in [&scene, &exact].into_iter().zip(&mut squares) {
            let scene = &set_up(scene, &motion);
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

/// With another pose, an image of the unloaded finger shows the markers beside their nodes, and the bent finger turns these offsets. Without them, the
/// errors of the pose did not explain what a wrong pose does to the markers.
#[test]
fn offsets_that_a_wrong_pose_finds_turn_with_the_plates() {
    let bare = scene();
    let load = Load::at_position(80.0, bare.finger.direction(0.0) * 3.0);
    let found = |motion: &Vector6<f64>| located(&set_up(&bare, motion), motion, load, &mut random_stream(6702, 0));
    let exact = found(&Vector6::zeros());
    for (k, error) in bare.pose_errors.iter().enumerate() {
        // The stated pose locates what the camera of another pose sees, so that the error has the other sign.
        let erroneous = found(&-error);
        let missed_mm = |scene: &Scene| {
            let sensed = exact.for_sensing(scene, true, None).expect("markers");
            let pattern_mm = &sensed.measurement.shared_errors()[k].pattern_mm;
            let missed = |(erroneous, exact): (&ObservedMarker, &ObservedMarker)| {
                let by = erroneous.displacement.expect("located") - exact.displacement.expect("located");
                (by - pattern_mm[exact.node.0 - 1]).norm_squared()
            };
            erroneous.markers.iter().zip(&exact.markers).map(missed).sum::<f64>().sqrt()
        };
        let [with_mm, without_mm] = [set_up(&bare, &Vector6::zeros()), bare.clone()].map(|scene| missed_mm(&scene));
        println!("error {k}: {with_mm:.4} mm of the markers' motion are left, {without_mm:.4} mm without offsets");
        assert!(4.0 * with_mm < without_mm, "{with_mm} {without_mm}");
    }
}

/// A marker that is missing in the image of the unloaded finger may be anywhere near its node. A calibration from a photograph in which it was missing,
/// too, stated errors of micrometres, and the frames that showed it contradicted every force.
#[test]
fn a_marker_without_offset_counts_nowhere() {
    let complete = set_up(&scene(), &Vector6::zeros());
    let scene = Scene { missing_markers: vec![NodeId(5)], ..complete.clone() };
    let force = scene.finger.direction(0.0) * 2.0;
    let seen = located(&scene, &Vector6::zeros(), Load::at_position(70.0, force), &mut random_stream(6703, 0));
    let markers = |scene: &Scene| {
        let sensed = seen.for_sensing(scene, true, None).expect("markers").measurement;
        let calibrated = seen.for_calibration(scene).expect("markers").0.measurement;
        [sensed, calibrated].map(|measurement| measurement.markers().iter().map(|it| it.node).collect::<Vec<_>>())
    };
    for (without, with) in markers(&scene).into_iter().zip(markers(&complete)) {
        assert_eq!(without, with.into_iter().filter(|node| *node != NodeId(5)).collect::<Vec<_>>());
    }
}
