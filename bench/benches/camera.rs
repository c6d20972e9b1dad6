//! Times on one core: locating the nodes in an image (search of the whole image, or tracking in a stream), estimating the force from an image, and
//! detecting a calibration grid.

use criterion::{Criterion, criterion_group, criterion_main};
use finray_fixtures::CAMERA_SCENE;
use finray_imaging::grid::find_grid;
use finray_imaging::locate::{Located, Locator};
use finray_imaging::render::{Disturbances, GridPlate, RenderRequest, render, render_grid};
use finray_model::camera::Camera;
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::{Contact, ContactPosition, NonlinearEstimator};
use finray_model::{Kinematics, Load, Mesh, Scene, statics};
use image::RgbImage;
use std::hint::black_box;

/// Position of the force, mm from the front base, and forces in successive frames of a stream, N. Nodes move by up to 1 mm between frames.
const CONTACT_MM: f64 = 80.0;
const FORCES_N: [f64; 4] = [2.0, 2.1, 2.2, 2.1];

fn camera(criterion: &mut Criterion) {
    let scene = Scene::from_toml(CAMERA_SCENE).expect("the fixture");
    let (finger, markers) = (&scene.finger, scene.markers.expect("markers"));
    let described = scene.camera.expect("a camera");
    let camera = Camera { lens: described.lens, pose: described.pose.expect("a pose") };
    let mesh = Mesh::key_nodes(finger);
    let disturbances = Disturbances { blur_px: 0.8, grey_noise: 2.0, light_falloff: 0.3, clutter: 20, seed: 1 };
    let frame = |force_n: f64| -> RgbImage {
        let load = Load::at_position(CONTACT_MM, finger.direction(0.0) * force_n);
        let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("carried");
        let request = RenderRequest { disturbances, ..RenderRequest::of(&camera, finger, &shape, &markers) };
        render(&request).expect("in sight")
    };
    let frames = FORCES_N.map(frame);
    let mut locator = Locator::new(finger, &camera, &markers).expect("a locator");
    let mut group = criterion.benchmark_group("camera");
    group.bench_function("search", |bencher| {
        bencher.iter(|| locator.locate(black_box(&frames[0])).expect("a finger"));
    });
    let mut turn = frames.iter().cycle();
    group.bench_function("track", |bencher| {
        bencher.iter(|| locator.track(black_box(turn.next().expect("a frame"))).expect("a finger"));
    });
    let contact = Contact { position: ContactPosition::at(CONTACT_MM), angle_deg: 0.0 };
    let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("a contact");
    group.bench_function("image_to_force", |bencher| {
        bencher.iter(|| {
            let located = locator.track(black_box(turn.next().expect("a frame"))).expect("a finger");
            let noise_mm = located[0].sd_mm;
            let free = located.iter().filter(|marker| !finger.is_clamped(marker.node));
            let marker = |&Located { node, position, .. }: &Located| Marker {
                node,
                displacement: position - finger.position(node),
                weight: 1.0,
            };
            let measurement = Measurement::new(finger, free.map(marker)).expect("markers of the finger");
            estimator.estimate(&measurement, Some(noise_mm)).expect("a force").forces.forces_n[0]
        });
    });
    let plate = GridPlate { pitch_mm: 10.0, radius_mm: 2.5, counts: [17, 15], greys: [210, 50] };
    let grid = render_grid(&camera, &plate, |_| false, disturbances);
    group
        .sample_size(10)
        .bench_function("grid", |bencher| bencher.iter(|| find_grid(black_box(&grid)).expect("a grid")));
    group.finish();
}

criterion_group!(benches, camera);
criterion_main!(benches);
