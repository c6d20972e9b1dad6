//! Positions and forces from images alone. Errors of positions are compared with the Cramer-Rao bound; with a fitted lens and pose, they must stay
//! below a limit. Errors of forces must stay below a limit.

use crate::kit::{DISTURBED, camera_of, rms, scene, tilted};
use finray_imaging::grid::{find_grid, lens_of_grids};
use finray_imaging::locate::{LocateError, Located, Locator, Rest};
use finray_imaging::render::{Disturbances, GridPlate, RenderRequest, render, render_grid};
use finray_model::camera::{Camera, Pose};
use finray_model::measurement::{Marker, Measurement};
use finray_model::mesh::FingerShape;
use finray_model::scene::Markers;
use finray_model::sensing::{Contact, NonlinearEstimator};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, statics};
use finray_tests::{CAMERA_NOISE_MM, random_stream, repetitions};
use image::RgbImage;
use nalgebra::{Matrix2, Rotation3, Vector2, Vector3};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Scale of the image of the fixture's camera, px/mm.
const PX_A_MM: f64 = 8.0;

fn image_of(
    camera: &Camera,
    finger: &Finger,
    shape: &FingerShape,
    markers: &Markers,
    disturbances: Disturbances,
) -> RgbImage {
    let request = RenderRequest { disturbances, ..RenderRequest::of(camera, finger, shape, markers) };
    render(&request).expect("a finger in sight")
}

fn bent_by(finger: &Finger, node: usize, force_n: f64) -> FingerShape {
    let load = Load::at_node(NodeId(node), finger.direction(0.0) * force_n);
    statics::solve(&Mesh::key_nodes(finger), &[load], Kinematics::Corotational).expect("carried")
}

/// Smallest possible standard deviation of a coordinate of a disc's centre, px. `s` is the standard deviation of the noise of every colour channel,
/// and `b` is the blur of the edge, px. The contrast is read from `sharp`, an image without noise and blur.
fn bound_px(sharp: &RgbImage, centre: Vector2<f64>, radius_px: f64, s: f64, b: f64) -> f64 {
    const DIRECTIONS: usize = 720;
    let light = |at: Vector2<f64>| {
        let pixel = sharp.get_pixel(at.x.round() as u32, at.y.round() as u32);
        Vector3::from(pixel.0.map(f64::from))
    };
    let inside = light(centre);
    // The Fisher information of 1 px of an edge with contrast A is the integral of (A phi(d / b) / b)^2 / s^2 over the distance d: A^2 / (2 sqrt(pi)
    // b s^2).
    let information: Matrix2<f64> = (0..DIRECTIONS)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / DIRECTIONS as f64).sin_cos();
            let normal = Vector2::new(cos, sin);
            let contrast2 = (light(centre + normal * (radius_px + 1.5)) - inside).norm_squared();
            let length_px = radius_px * std::f64::consts::TAU / DIRECTIONS as f64;
            normal * normal.transpose() * (contrast2 * length_px / (2.0 * std::f64::consts::PI.sqrt() * b * s * s))
        })
        .sum();
    (information.try_inverse().expect("an edge").trace() / 2.0).sqrt()
}

/// For a disc on a uniform background, the bound has the closed form s sqrt(2 sqrt(pi) b / (pi R A^2)).
#[test]
fn the_bound_is_the_closed_form() {
    let (radius, s, b, contrast) = (12.0, 2.0, 0.8, 100.0);
    let disc = RgbImage::from_fn(61, 61, |u, v| {
        let inside = (f64::from(u) - 30.0).hypot(f64::from(v) - 30.0) < radius;
        image::Rgb([if inside { 50 } else { 150 }, 70, 70])
    });
    let pi = std::f64::consts::PI;
    let closed = s * (2.0 * pi.sqrt() * b / (pi * radius * contrast * contrast)).sqrt();
    let found = bound_px(&disc, Vector2::new(30.0, 30.0), radius, s, b);
    assert!((found / closed - 1.0).abs() < 1e-9, "{found} {closed}");
}

#[test]
fn centres_are_within_twice_the_bound() {
    const IMAGES: u64 = 16;
    let scene = scene();
    let (finger, markers, camera) = (&scene.finger, scene.markers.expect("markers"), camera_of(&scene));
    let shape = bent_by(finger, 19, 1.0);
    let noise = Disturbances { light_falloff: 0.0, clutter: 0, ..DISTURBED };
    let sharp = image_of(&camera, finger, &shape, &markers, Disturbances { grey_noise: 0.0, blur_px: 0.0, ..noise });
    let in_image = |seed: u64| {
        let image = image_of(&camera, finger, &shape, &markers, Disturbances { seed, ..noise });
        Locator::new(finger, &camera, &markers).expect("a locator").locate(&image).expect("a finger")
    };
    let all: Vec<Located> = (0..IMAGES).into_par_iter().flat_map_iter(in_image).collect();
    assert_eq!(all.len(), 25 * IMAGES as usize);
    // The width of a pixel adds to the blur.
    let blur_px = DISTURBED.blur_px.hypot(1.0 / 12.0_f64.sqrt());
    let ratio = |marker: &Located| {
        let motion = shape.motion(marker.node);
        let at = (motion.position + motion.displacement).push(markers.height_mm);
        let pixel = camera.project(&at).expect("in sight");
        let bound = bound_px(&sharp, pixel, PX_A_MM * markers.radius_mm, DISTURBED.grey_noise, blur_px);
        (marker.pixel - pixel).norm() / 2.0_f64.sqrt() / bound
    };
    let ratios: Vec<f64> = all.iter().map(ratio).collect();
    assert!(rms(&ratios) <= 2.0, "{} times the bound", rms(&ratios));
    // No estimator is better than the bound.
    assert!(rms(&ratios) > 0.9, "{} times the bound", rms(&ratios));
}

/// Markers with a radius of 3 px, and blurs of up to a third of the radius, cause larger errors; the stated standard deviations include these errors.
/// Images with a blur of half the radius or more are rejected.
#[test]
fn small_and_blurred_markers_state_their_errors() {
    let scene = scene();
    let (finger, camera) = (&scene.finger, camera_of(&scene));
    let shape = bent_by(finger, 19, 2.0);
    let cases: Vec<(f64, f64)> =
        [0.4, 0.6, 1.0, 1.5].iter().flat_map(|&r| [0.0, 0.8, 1.6, 3.2].map(|b| (r, b))).collect();
    let found = |&(radius_mm, blur_px): &(f64, f64)| {
        let markers = Markers { radius_mm, ..scene.markers.expect("markers") };
        let image = image_of(&camera, finger, &shape, &markers, Disturbances { blur_px, clutter: 0, ..DISTURBED });
        let located = Locator::new(finger, &camera, &markers).expect("a locator").locate(&image);
        let sigmas = |located: Vec<Located>| {
            let pull = |marker: &Located| {
                let motion = shape.motion(marker.node);
                (marker.position - (motion.position + motion.displacement)) / marker.sd_mm
            };
            let pulls: Vec<f64> = located.iter().map(pull).flat_map(|pull| [pull.x, pull.y]).collect();
            (located.len(), rms(&pulls))
        };
        (radius_mm, blur_px, located.map(sigmas))
    };
    for (radius_mm, blur_px, found) in cases.par_iter().map(found).collect::<Vec<_>>() {
        let blur = blur_px / (PX_A_MM * radius_mm);
        match found {
            Ok((markers, sigmas)) => {
                assert!(blur < 0.5, "{radius_mm} {blur_px}: out of focus");
                // Effects that the edge model neglects cause errors that all 50 coordinates share. The mean square therefore scatters more than for
                // 50 independent errors.
                assert!(markers == 25 && sigmas < 1.5, "{radius_mm} {blur_px}: {markers} {sigmas}");
            }
            Err(LocateError::Blurred { .. }) => assert!(blur > 0.3, "{radius_mm} {blur_px}: sharp"),
            // At a blur of more than 0.6 of the radius, no patch in the image is as wide as a marker.
            Err(error) => assert!(blur > 0.6, "{radius_mm} {blur_px}: {error}"),
        }
    }
}

/// The lens is fitted to four images of a grid, and the pose to an image of the finger at rest.
#[test]
fn a_lens_and_a_pose_that_are_found_serve_as_well() {
    let cameras = repetitions(1, 4);
    let scene = scene();
    let (finger, markers) = (&scene.finger, scene.markers.expect("markers"));
    let plate = GridPlate { pitch_mm: 10.0, radius_mm: 2.5, counts: [21, 19], greys: [205, 45] };
    let of_camera = |number: u64| {
        let mut chance = random_stream(24, number);
        let camera = tilted(&mut chance);
        let grid = |view: u64| {
            let mut tilt = || chance.random_range(-0.4..0.4);
            let rotation = Rotation3::from_euler_angles(std::f64::consts::PI + tilt(), tilt(), 2.0 * tilt());
            let translation_mm = Vector3::new(0.0, 0.0, 210.0 + 20.0 * tilt());
            let camera = Camera { lens: camera.lens, pose: Pose { rotation, translation_mm } };
            let disturbances = Disturbances { seed: view, clutter: 0, ..DISTURBED };
            find_grid(&render_grid(&camera, &plate, |_| false, disturbances)).expect("a grid")
        };
        let grids: Vec<_> = (0..4).map(grid).collect();
        let (fit, _) = lens_of_grids(camera.lens.size_px(), plate.pitch_mm, &grids).expect("a lens");
        let at_rest = FingerShape::new(finger, false, |_| Default::default());
        let image = image_of(&camera, finger, &at_rest, &markers, Disturbances { seed: number, ..DISTURBED });
        let rest = Rest::of((finger, &[]), &fit.lens, None, &markers, &image).expect("a finger at rest");
        let mut errors = Vec::new();
        for (seed, (node, force_n)) in [(15, 1.0), (19, 4.0), (24, 3.0)].into_iter().enumerate() {
            let shape = bent_by(finger, node, force_n);
            let disturbances = Disturbances { seed: 10 + seed as u64, ..DISTURBED };
            let image = image_of(&camera, finger, &shape, &markers, disturbances);
            let located =
                Locator::new(finger, &rest.camera, &markers).expect("a locator").locate(&image).expect("a finger");
            for marker in located {
                let motion = shape.motion(marker.node);
                errors.extend((marker.position - (motion.position + motion.displacement)).iter().copied());
            }
        }
        errors
    };
    let errors: Vec<f64> = (0..cameras).into_par_iter().flat_map_iter(of_camera).collect();
    // Each camera sees three shapes with 25 markers. The error of a coordinate may be three times as large as with the true lens and pose.
    assert!(
        errors.len() as f64 > 0.99 * 2.0 * 75.0 * cameras as f64 && rms(&errors) <= 0.012,
        "{} errors, {} mm rms",
        errors.len(),
        rms(&errors)
    );
}

/// Forces from images have at most a tenth of the error that the noise of the paper's camera causes.
#[test]
fn forces_from_images_err_by_a_tenth_of_the_papers() {
    let scene = scene();
    let (finger, markers, camera) = (&scene.finger, scene.markers.expect("markers"), camera_of(&scene));
    let mesh = Mesh::key_nodes(finger);
    for node in [15, 19, 24] {
        let contact = Contact::at_node(NodeId(node));
        let force_n = |step: u64| 0.5 + 0.25 * step as f64;
        let error = |step: u64, markers: Vec<Marker>| {
            let measurement = Measurement::new(finger, markers).expect("a measurement");
            let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("a contact");
            let estimate = estimator.estimate(&measurement, None).expect("a force");
            (estimate.forces.forces_n[0] / force_n(step) - 1.0).abs()
        };
        let of_image = |step: u64| {
            let shape = bent_by(finger, node, force_n(step));
            let image = image_of(&camera, finger, &shape, &markers, Disturbances { seed: step, ..DISTURBED });
            let located = Locator::new(finger, &camera, &markers).expect("a locator").locate(&image).expect("a finger");
            let free = located.iter().filter(|marker| !finger.clamped_nodes().contains(&marker.node));
            let marker = |marker: &Located| Marker {
                node: marker.node,
                displacement: marker.position - finger.position(marker.node),
                weight: 1.0,
            };
            error(step, free.map(marker).collect())
        };
        let of_noise = |step: u64| {
            let (shape, mut noise) = (bent_by(finger, node, force_n(step)), random_stream(67, step));
            let marker = |node| {
                let noise = Vector2::from_fn(|_, _| StandardNormal.sample(&mut noise)) * CAMERA_NOISE_MM;
                Marker { node, displacement: shape.motion(node).displacement + noise, weight: 1.0 }
            };
            error(step, finger.free_nodes().map(marker).collect())
        };
        let mean = |errors: Vec<f64>| errors.iter().sum::<f64>() / errors.len() as f64;
        // Images take most of the time, so every third force has one.
        let of_images = mean((0..4).into_par_iter().map(|i| of_image(3 * i)).collect());
        let of_papers = mean((0..=10).map(of_noise).collect());
        assert!(of_images <= 0.1 * of_papers, "node {node}: {of_images} against {of_papers}");
    }
}
