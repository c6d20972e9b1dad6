//! Tests of the locator of grey markers on a finger with brackets; the finger's base is anywhere in the image.

use crate::kit::rms;
use finray_fixtures::BRACKETED_SCENE;
use finray_imaging::locate::{LocateError, NamingError, RimLocator, SeenFinger};
use finray_imaging::render::{Disturbances, RenderRequest, render};
use finray_model::camera::{Camera, Pose};
use finray_model::mesh::FingerShape;
use finray_model::scene::Base;
use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, Vector, statics};
use finray_tests::repetitions;
use image::RgbImage;
use nalgebra::{Isometry2, Point2, Rotation3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Number of test images; all markers are found in each image.
fn images() -> u64 {
    repetitions(6, 16)
}
/// Limits of the root mean square error and of the largest error of a marker's coordinate in the plane, mm. The limits apply to images with 4 px/mm,
/// noise of two grey levels and a blur of 0.8 px.
const RMS_MM: f64 = 0.003;
const LARGEST_MM: f64 = 0.01;
/// Limit of the error of a marker beside a plate, mm. The bracket between marker and plate is hardly wider than the blur.
const NEXT_TO_PLATE_MM: f64 = 0.1;
/// Limit of the root mean square of errors divided by stated standard deviations. Errors and standard deviations are in the finger frame; the
/// standard deviations include the uncertainty of the base.
const OVER_SIGMA: f64 = 1.2;

struct Image {
    camera: Camera,
    base: Isometry2<f64>,
    shape: FingerShape,
    image: RgbImage,
}

/// A bent finger with its base anywhere in the image, and clutter in the background. The camera is tilted by up to 3 degrees.
fn image(scene: &Scene, seed: u64, hidden: &[NodeId]) -> Image {
    let finger = &scene.finger;
    let mut chance = ChaCha8Rng::seed_from_u64(seed);
    let described = scene.camera.expect("a camera");
    let pose = described.pose.expect("with a pose");
    let tilt = Rotation3::from_euler_angles(chance.random_range(-0.05..0.05), chance.random_range(-0.05..0.05), 0.0);
    let camera = Camera { lens: described.lens, pose: Pose { rotation: pose.rotation * tilt, ..pose } };
    let base = Isometry2::new(
        Vector::new(chance.random_range(-90.0..90.0), chance.random_range(-80.0..-60.0)),
        chance.random_range(80.0_f64..100.0).to_radians(),
    );
    let force = finger.direction(chance.random_range(-25.0..25.0)) * chance.random_range(0.0..8.0);
    let load = Load::at_position(chance.random_range(50.0..100.0), force);
    let shape = statics::solve(&Mesh::key_nodes(finger), &[load], Kinematics::Corotational).expect("carried");
    let moved = Camera { pose: camera.pose.of_moved_base(&base), ..camera };
    let markers = scene.markers.expect("markers");
    let request = RenderRequest {
        references: &scene.base.as_ref().expect("a base").references,
        hidden,
        disturbances: Disturbances { light_falloff: 0.2, blur_px: 0.8, grey_noise: 2.0, clutter: 25, seed },
        ..RenderRequest::of(&moved, finger, &shape, &markers)
    };
    let image = render(&request).expect("in sight");
    Image { camera, base, shape, image }
}

fn located(scene: &Scene, seen: &Image, base: &Base) -> Result<SeenFinger, LocateError> {
    let markers = scene.markers.expect("markers");
    RimLocator::new(&scene.finger, &seen.camera, &markers, Some(base)).expect("a locator").locate(&seen.image)
}

fn true_position(scene: &Scene, shape: &FingerShape, node: NodeId) -> Vector {
    let motion = shape.motion(node);
    scene.finger.marker_position(motion.node) + motion.marker_displacement(&scene.finger)
}

/// Both reference marks and all eight markers are found and assigned; the stated standard deviations explain the errors.
#[test]
fn markers_and_base_are_found_wherever_they_are() {
    let scene = Scene::from_toml(BRACKETED_SCENE).expect("the fixture");
    let base = scene.base.clone().expect("a base");
    let (mut errors_mm, mut over_sigma) = (Vec::<f64>::new(), Vec::<f64>::new());
    for seed in 0..images() {
        let seen = image(&scene, seed, &[]);
        let found = located(&scene, &seen, &base).unwrap_or_else(|error| panic!("image {seed}: {error}"));
        assert!(found.base.is_known && found.radii.references_mm.iter().all(Option::is_some), "image {seed}");
        assert_eq!(found.located.len(), 2 * scene.finger.rib_count(), "image {seed}: {:?}", found.located);
        for marker in &found.located {
            let truth = true_position(&scene, &seen.shape, marker.node);
            let in_plane = found.base.pose * Point2::from(marker.position) - seen.base * Point2::from(truth);
            errors_mm.extend(in_plane.iter());
            over_sigma.extend((marker.position - truth).iter().map(|off| off / marker.sd_mm));
        }
    }
    let largest = errors_mm.iter().fold(0.0_f64, |largest, off| largest.max(off.abs()));
    assert!(largest < LARGEST_MM && rms(&errors_mm) < RMS_MM, "{largest} {}", rms(&errors_mm));
    assert!(rms(&over_sigma) < OVER_SIGMA, "{}", rms(&over_sigma));
}

/// A quarter of a rim's rays meet the edge of a plate that is 0.4 mm away. Rays that meet the edge of this plate do not shift the fitted circle.
#[test]
fn markers_next_to_a_plate_are_found() {
    let scene = BRACKETED_SCENE.replace("bracket_mm = 3.0", "bracket_mm = [2.43, 3.0]");
    let scene = Scene::from_toml(&scene).expect("the fixture with other brackets");
    let base = scene.base.clone().expect("a base");
    for seed in 0..images() {
        let seen = image(&scene, seed, &[]);
        let found = located(&scene, &seen, &base).unwrap_or_else(|error| panic!("image {seed}: {error}"));
        assert_eq!(found.located.len(), 2 * scene.finger.rib_count(), "image {seed}: {:?}", found.located);
        for marker in &found.located {
            let truth = seen.base * Point2::from(true_position(&scene, &seen.shape, marker.node));
            let off = (found.base.pose * Point2::from(marker.position) - truth).norm();
            assert!(off < NEXT_TO_PLATE_MM, "image {seed}, node {}: {off}", marker.node);
        }
    }
}

/// Without references, the markers are assigned to the same nodes; only the position of the base is unknown.
#[test]
fn markers_are_named_without_references() {
    let scene = Scene::from_toml(BRACKETED_SCENE).expect("the fixture");
    for seed in 0..images() {
        let seen = image(&scene, seed, &[]);
        let found = located(&scene, &seen, &Base::default()).unwrap_or_else(|error| panic!("image {seed}: {error}"));
        assert!(!found.base.is_known);
        assert_eq!(found.located.len(), 2 * scene.finger.rib_count(), "image {seed}");
        for marker in &found.located {
            let truth = seen.base * Point2::from(true_position(&scene, &seen.shape, marker.node));
            let off = (found.base.pose * Point2::from(marker.position) - truth).norm();
            assert!(off < LARGEST_MM, "image {seed}, node {}: {off}", marker.node);
        }
    }
}

/// A hidden marker is omitted, and nothing else in the image is assigned to its node.
#[test]
fn hidden_grey_markers_are_left_out() {
    let scene = Scene::from_toml(BRACKETED_SCENE).expect("the fixture");
    let base = scene.base.clone().expect("a base");
    let nodes: Vec<NodeId> = scene.finger.free_nodes().filter(|node| scene.finger.has_marker(*node)).collect();
    for (seed, &hidden) in nodes.iter().enumerate() {
        let seen = image(&scene, 100 + seed as u64, &[hidden]);
        let found = located(&scene, &seen, &base).unwrap_or_else(|error| panic!("node {hidden}: {error}"));
        for marker in &found.located {
            let truth = true_position(&scene, &seen.shape, marker.node);
            assert!(marker.node != hidden && (marker.position - truth).norm() < 0.3, "node {hidden}: {marker:?}");
        }
        assert!(found.located.len() + 2 >= nodes.len(), "node {hidden}: {:?}", found.located);
    }
}

#[test]
fn images_without_grey_markers_are_refused() {
    let scene = Scene::from_toml(BRACKETED_SCENE).expect("the fixture");
    let base = scene.base.clone().expect("a base");
    let mut seen = image(&scene, 1, &[]);
    seen.image = RgbImage::from_pixel(1920, 1080, image::Rgb([90, 90, 90]));
    let none = located(&scene, &seen, &base);
    assert!(matches!(none, Err(LocateError::Naming(NamingError::TooFew { found: 0, all: 8, .. }))), "{none:?}");
    // The image shows a board with holes as large as the markers, and no finger.
    seen.image = RgbImage::from_fn(1920, 1080, |u, v| {
        let away = (f64::from(u % 60) - 30.0).hypot(f64::from(v % 60) - 30.0);
        image::Rgb(if away < 8.5 { [250; 3] } else { [90; 3] })
    });
    assert!(located(&scene, &seen, &base).is_err());
}
