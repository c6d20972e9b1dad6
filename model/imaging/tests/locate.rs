//! Tests of the locator on rendered images: centres of markers, their stated standard deviations, and their assignment to nodes.

mod covered;
mod elsewhere;
mod observer;
mod rim_locator;

use crate::kit::{DISTURBED, camera_of, rms, scene, tilted};
use finray_imaging::locate::{LocateError, Located, Locator, LocatorError, NamingError, Rest, RestError};
use finray_imaging::render::{Disturbances, RenderRequest, render};
use finray_model::camera::Camera;
use finray_model::finger::RibPositions;
use finray_model::mesh::FingerShape;
use finray_model::scene::MarkerLook;
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, statics};
use finray_tests::{random_stream, repetitions};
use image::RgbImage;
use jpeg_encoder::{ChromaSubsamplingMethod, ColorType, Encoder, SamplingFactor};
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Limits of the root mean square error and of the largest error of a node's coordinate in rendered images, mm.
const RMS_MM: f64 = 0.004;
const LARGEST_MM: f64 = 0.015;
/// Number of images in the statistics.
const IMAGES: u64 = 24;
/// Share of the visible markers that the locator may omit because their assignment to nodes is uncertain.
const LOST: f64 = 0.01;

/// Shape under a random force of up to 5 N on the front plate; `None` if the finger does not carry the force.
fn bent(finger: &Finger, chance: &mut ChaCha8Rng) -> Option<FingerShape> {
    let (angle_deg, force_n) = (chance.random_range(-40.0..40.0), chance.random_range(0.3..5.0));
    let load = Load::at_position(chance.random_range(15.0..150.0), finger.direction(angle_deg) * force_n);
    statics::solve(&Mesh::key_nodes(finger), &[load], Kinematics::Corotational).ok()
}

/// Errors in mm, errors divided by the stated standard deviations, number of missed markers, and number of visible markers.
struct Errors {
    mm: Vec<f64>,
    sigmas: Vec<f64>,
    lost: usize,
    seen: usize,
}

fn errors(shape: &FingerShape, hidden: &[NodeId], located: &[Located]) -> Errors {
    let mut errors = Errors { mm: Vec::new(), sigmas: Vec::new(), lost: 0, seen: 0 };
    for motion in shape.motions() {
        let found = located.iter().find(|marker| marker.node == motion.node);
        if hidden.contains(&motion.node) {
            assert!(found.is_none(), "node {} is hidden", motion.node);
            continue;
        }
        errors.seen += 1;
        let Some(found) = found else {
            errors.lost += 1;
            continue;
        };
        let error = found.position - (motion.position + motion.displacement);
        errors.mm.extend(error.iter());
        errors.sigmas.extend(error.iter().map(|error| error / found.sd_mm));
    }
    errors
}

#[test]
fn nodes_are_found_through_tilt_lens_light_noise_and_clutter() {
    let scene = scene();
    let (finger, markers) = (&scene.finger, scene.markers.expect("the fixture has markers"));
    let of_image = |number: u64| {
        let mut chance = random_stream(18, number);
        let camera = tilted(&mut chance);
        let shape = bent(finger, &mut chance)?;
        let hidden: Vec<NodeId> = (0..number % 4).map(|_| NodeId(chance.random_range(1.0..26.0) as usize)).collect();
        let disturbances = Disturbances { seed: number, ..DISTURBED };
        let request =
            RenderRequest { hidden: &hidden, disturbances, ..RenderRequest::of(&camera, finger, &shape, &markers) };
        let image = render(&request).expect("a finger in sight");
        let located = Locator::new(finger, &camera, &markers).expect("a locator").locate(&image).expect("a finger");
        Some(errors(&shape, &hidden, &located))
    };
    let all: Vec<Errors> = (0..IMAGES).into_par_iter().filter_map(of_image).collect();
    let mm: Vec<f64> = all.iter().flat_map(|errors| errors.mm.iter().copied()).collect();
    let sigmas: Vec<f64> = all.iter().flat_map(|errors| errors.sigmas.iter().copied()).collect();
    let (lost, seen) = all.iter().fold((0, 0), |sum, errors| (sum.0 + errors.lost, sum.1 + errors.seen));
    assert!(seen > 500, "{seen} markers");
    let largest = mm.iter().fold(0.0_f64, |largest, error| largest.max(error.abs()));
    assert!(rms(&mm) <= RMS_MM && largest <= LARGEST_MM, "{} rms, {largest} at most", rms(&mm));
    assert!(lost as f64 <= LOST * seen as f64, "{lost} of {seen} lost");
    // The stated standard deviations are too small by at most a tenth. The stated standard deviations have a lower bound that covers differences
    // between images, so they may be too large.
    assert!(rms(&sigmas) < 1.1, "{}", rms(&sigmas));
    assert!(rms(&sigmas) > 0.3, "{}: stated without need", rms(&sigmas));
}

/// The image after JPEG compression as in a camera; colour is stored at half the resolution along each side.
fn compressed(image: &RgbImage, quality: u8, colour: ChromaSubsamplingMethod) -> RgbImage {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality);
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    encoder.set_chroma_subsampling_method(colour);
    let [width, height] = [image.width(), image.height()].map(|px| u16::try_from(px).expect("a small image"));
    encoder.encode(image, width, height, ColorType::Rgb).expect("an image in memory");
    image::load_from_memory(&bytes).expect("a JPEG").into_rgb8()
}

/// Compression correlates the errors of neighbouring pixels, and degrades colour more than brightness. Some encoders store the colour of every other
/// pixel, which displaces colour by half a pixel.
#[test]
fn compressed_images_state_their_errors() {
    let scene = scene();
    let (finger, markers) = (&scene.finger, scene.markers.expect("the fixture has markers"));
    use ChromaSubsamplingMethod::{Average, Nearest};
    // Half a pixel is 0.06 mm. An encoder that stores the colour of only every other pixel does not blur the image, so the stated standard deviations
    // do not cover all errors of this encoder.
    for (quality, colour, allowed_mm, allowed_sigmas) in
        [(92, Average, 0.005, 1.25), (75, Average, 0.012, 1.25), (92, Nearest, 0.007, 1.5)]
    {
        let of_image = |number: u64| {
            let mut chance = random_stream(19, number);
            let camera = tilted(&mut chance);
            let shape = bent(finger, &mut chance)?;
            let disturbances = Disturbances { seed: number, ..DISTURBED };
            let request = RenderRequest { disturbances, ..RenderRequest::of(&camera, finger, &shape, &markers) };
            let image = compressed(&render(&request).expect("a finger in sight"), quality, colour);
            let located = Locator::new(finger, &camera, &markers).expect("a locator").locate(&image).expect("a finger");
            Some(errors(&shape, &[], &located))
        };
        let all: Vec<Errors> = (0..repetitions(6, 12)).into_par_iter().filter_map(of_image).collect();
        let mm: Vec<f64> = all.iter().flat_map(|errors| errors.mm.iter().copied()).collect();
        let sigmas: Vec<f64> = all.iter().flat_map(|errors| errors.sigmas.iter().copied()).collect();
        assert!(rms(&mm) <= allowed_mm, "quality {quality} {colour:?}: {} mm rms", rms(&mm));
        // There are at least 300 coordinates; errors of coordinates in one image are correlated.
        assert!((0.5..allowed_sigmas).contains(&rms(&sigmas)), "quality {quality} {colour:?}: {}", rms(&sigmas));
    }
}

/// In a stream, the search in each image starts from the previous image. The search from the previous image finds the same markers as a full search,
/// with equal accuracy.
#[test]
fn tracking_finds_what_a_full_search_finds() {
    let scene = scene();
    let (finger, markers, camera) = (&scene.finger, scene.markers.expect("markers"), camera_of(&scene));
    let mesh = Mesh::key_nodes(finger);
    let mut tracker = Locator::new(finger, &camera, &markers).expect("a locator");
    let (mut apart, mut errors_of) = (Vec::new(), [Vec::new(), Vec::new()]);
    for step in 0..6_u8 {
        // In the last image, the force jumps, and no marker is near its last position.
        let force_n = if step < 5 { 0.2 * f64::from(step) } else { 4.0 };
        let load = Load::at_position(80.0, finger.direction(0.0) * force_n);
        let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("carried");
        let disturbances = Disturbances { seed: step.into(), ..DISTURBED };
        let request = RenderRequest { disturbances, ..RenderRequest::of(&camera, finger, &shape, &markers) };
        let image = render(&request).expect("in sight");
        let tracked = tracker.track(&image).expect("a finger");
        let searched = Locator::new(finger, &camera, &markers).expect("a locator").locate(&image).expect("a finger");
        assert_eq!(tracked.len(), searched.len());
        for (all, found) in errors_of.iter_mut().zip([&tracked, &searched]) {
            all.extend(errors(&shape, &[], found).mm);
        }
        for (a, b) in tracked.iter().zip(&searched) {
            assert_eq!(a.node, b.node);
            apart.push((a.position - b.position).norm() / b.sd_mm);
        }
    }
    // Tracking and full search use the same pixels, so their errors are nearly equal. Their errors differ only if one of the two searches omits a
    // sector of a marker's edge.
    let largest = apart.iter().fold(0.0_f64, |largest, distance| largest.max(*distance));
    assert!(rms(&apart) < 0.5 && largest < 2.0, "{} rms, {largest} at most", rms(&apart));
    let [tracked, searched] = errors_of.map(|errors| rms(&errors));
    assert!(tracked < 1.1 * searched, "{tracked} mm where a search errs by {searched} mm");
}

/// Markers that were hidden temporarily are found again: immediately if they are near their last positions, otherwise at the next full search.
#[test]
fn hidden_markers_come_back() {
    const IMAGES: usize = 15;
    let scene = scene();
    let (finger, markers, camera) = (&scene.finger, scene.markers.expect("markers"), camera_of(&scene));
    let mesh = Mesh::key_nodes(finger);
    let mut tracker = Locator::new(finger, &camera, &markers).expect("a locator");
    let mut seen = |force_n: f64, hidden: &[NodeId]| {
        let load = Load::at_position(80.0, finger.direction(0.0) * force_n);
        let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("carried");
        let request =
            RenderRequest { hidden, disturbances: DISTURBED, ..RenderRequest::of(&camera, finger, &shape, &markers) };
        let located = tracker.track(&render(&request).expect("in sight")).expect("a finger");
        let errors = errors(&shape, hidden, &located);
        assert!(errors.mm.iter().all(|error| error.abs() < LARGEST_MM), "{:?}", errors.mm);
        errors.lost
    };
    let nodes = [NodeId(6), NodeId(18), NodeId(19)];
    assert_eq!(seen(0.5, &nodes[..1]), 0);
    // The marker of node 6 has never been visible, so only the next full search finds it.
    assert_eq!(seen(0.5, &nodes[1..]), 1);
    assert_eq!(seen(0.5, &[]), 1);
    let images_without = (0..IMAGES).take_while(|_| seen(0.5, &[]) > 0).count();
    assert!(images_without < 10, "{images_without}");
    // All markers have been found. The finger then moves by more than a marker's width while the markers of nodes 18 and 19 are hidden.
    for step in 0..4 {
        assert_eq!(seen(0.5 + 0.25 * f64::from(step), &nodes[1..]), 0);
    }
    let images_without = (0..IMAGES).take_while(|_| seen(1.25, &[]) > 0).count();
    assert!(images_without < 10, "{images_without}");
}

/// The locator assigns markers by ribs that share no junctions. A finger with zigzag ribs can be rendered but not located.
#[test]
fn fingers_whose_ribs_share_junctions_are_refused() {
    let scene = scene();
    let (markers, camera) = (scene.markers.expect("markers"), camera_of(&scene));
    let mut description = scene.finger.description().clone();
    description.ribs.positions = RibPositions::Positions(vec![[40.0, 0.0], [40.0, 70.0], [100.0, 70.0]]);
    let finger = Finger::new(description).expect("a zigzag");
    assert!(matches!(Locator::new(&finger, &camera, &markers), Err(LocatorError::SharedJunctions)));
    let image = RgbImage::new(1600, 1400);
    let at_rest = Rest::of((&finger, &[]), &camera.lens, Some(camera.pose), &markers, &image);
    assert!(matches!(at_rest, Err(RestError::Locator(LocatorError::SharedJunctions))));
}

#[test]
fn images_without_the_finger_are_refused() {
    let scene = scene();
    let (finger, markers, camera) = (&scene.finger, scene.markers.expect("markers"), camera_of(&scene));
    let mut locator = Locator::new(finger, &camera, &markers).expect("a locator");
    let black = RgbImage::new(1600, 1400);
    assert!(matches!(locator.locate(&black), Err(LocateError::Naming(NamingError::TooFew { found: 0, .. }))));
    let MarkerLook::Coloured { front_rgb, back_rgb } = markers.look else { panic!("coloured markers") };
    let colour = RgbImage::from_pixel(1600, 1400, image::Rgb(front_rgb));
    assert!(matches!(locator.locate(&colour), Err(LocateError::Naming(NamingError::TooFew { .. }))));
    let small = RgbImage::new(800, 700);
    assert_eq!(locator.locate(&small), Err(LocateError::Size { expected: [1600, 1400], found: [800, 700] }));
    let everywhere = RgbImage::from_fn(1600, 1400, |u, v| {
        let is_marker = (u % 40 < 24) && (v % 40 < 24);
        image::Rgb(if is_marker { back_rgb } else { [60, 60, 60] })
    });
    assert!(matches!(locator.locate(&everywhere), Err(LocateError::Naming(_))));
}

/// The image of the unloaded finger determines the pose, with or without a pose in the scene, because the pattern of markers is found without a pose.
#[test]
fn the_pose_comes_from_the_finger_at_rest() {
    let scene = scene();
    let (finger, markers, camera) = (&scene.finger, scene.markers.expect("markers"), camera_of(&scene));
    let shape = FingerShape::new(finger, false, |_| Default::default());
    let request = RenderRequest { disturbances: DISTURBED, ..RenderRequest::of(&camera, finger, &shape, &markers) };
    let image = render(&request).expect("in sight");
    let mut off = camera;
    off.pose.translation_mm += Vector3::new(0.6, -0.5, 1.5);
    off.pose.rotation = Rotation3::from_scaled_axis(Vector3::new(0.01, -0.015, 0.01)) * off.pose.rotation;
    for start in [Some(off.pose), None] {
        let rest = Rest::of((finger, &[]), &camera.lens, start, &markers, &image).expect("a finger at rest");
        for marker in &rest.located {
            let error = marker.position - finger.position(marker.node);
            assert!(error.norm() < LARGEST_MM, "node {}: {error}", marker.node);
        }
        assert!((rest.camera.pose.translation_mm - camera.pose.translation_mm).norm() < 0.5, "{:?}", rest.camera.pose);
        assert!(rest.residual_sd_px < 0.1, "{}", rest.residual_sd_px);
    }
}
