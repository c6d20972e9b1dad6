//! Times of the parts of `finray live` on one core: converting a video frame, locating the markers in a tracked frame, and sensing the force in a
//! frame from the result of the frame before.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use finray_files::frames::{FrameReader, FrameWriter, VideoFrame};
use finray_fixtures::CAMERA_SCENE;
use finray_imaging::RgbRows;
use finray_imaging::locate::Observer;
use finray_imaging::render::{Disturbances, RenderRequest, render};
use finray_model::camera::Camera;
use finray_model::observation::Observation;
use finray_model::sensing::{ContactQuestion, Direction};
use finray_model::sensor::{FingerTracker, SensorContacts, SensorOptions};
use finray_model::{Kinematics, Load, Mesh, Scene, statics};
use image::RgbImage;
use std::hint::black_box;

/// Position of the force, mm from the front base, and forces in successive frames of a stream, N. Nodes move by up to 0.5 mm between frames.
const CONTACT_MM: f64 = 80.0;
const FORCES_N: [f64; 4] = [2.0, 2.05, 2.1, 2.05];

/// Images of the finger under each of the forces `FORCES_N`.
fn images(scene: &Scene) -> Vec<RgbImage> {
    let described = scene.camera.expect("a camera");
    let camera = Camera { lens: described.lens, pose: described.pose.expect("a pose") };
    let (finger, mesh) = (&scene.finger, Mesh::with_elements_per_member(&scene.finger, 16));
    let image = |(seed, force_n): (u64, f64)| {
        let load = Load::at_position(CONTACT_MM, finger.direction(0.0) * force_n);
        let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("carried");
        let markers = scene.markers.expect("markers");
        let request = RenderRequest {
            disturbances: Disturbances { blur_px: 0.8, grey_noise: 2.0, seed, ..Disturbances::default() },
            ..RenderRequest::of(&camera, finger, &shape, &markers)
        };
        render(&request).expect("in sight")
    };
    (0..).zip(FORCES_N).map(image).collect()
}

/// Images as a YUV4MPEG2 stream with chroma for each pixel (444) or for each square of four pixels (420).
fn stream(images: &[RgbImage], form: &str) -> Vec<u8> {
    let mut stream = Vec::new();
    let (width, height) = images[0].dimensions();
    let mut writer = FrameWriter::yuv4mpeg2(&mut stream, [width, height], None).expect("a header");
    images.iter().for_each(|image| writer.write(image).expect("a frame"));
    if form == "444" {
        return stream;
    }
    // Chroma is the mean of each square of four pixels, as cameras compute it.
    let plane = (width * height) as usize;
    let frames = stream[stream.len() - images.len() * (6 + 3 * plane)..].to_vec();
    let mut halved = format!("YUV4MPEG2 W{width} H{height} F0:1 C{form} XCOLORRANGE=FULL\n").into_bytes();
    for frame in frames.chunks_exact(6 + 3 * plane) {
        halved.extend(&frame[..6 + plane]);
        for chroma in frame[6 + plane..].chunks_exact(plane) {
            for rows in chroma.chunks_exact(2 * width as usize) {
                let (upper, lower) = rows.split_at(width as usize);
                let squares = upper.chunks_exact(2).zip(lower.chunks_exact(2));
                halved.extend(squares.map(|(upper, lower)| {
                    let sum: u16 = upper.iter().chain(lower).map(|&sample| u16::from(sample)).sum();
                    ((sum + 2) / 4) as u8
                }));
            }
        }
    }
    halved
}

/// The frames of a stream.
fn frames(stream: &[u8]) -> Vec<VideoFrame> {
    let mut reader = FrameReader::yuv4mpeg2(stream).expect("a stream");
    let mut frames = Vec::new();
    let mut frame = VideoFrame::new(reader.layout());
    while reader.read(&mut frame).expect("frames") {
        frames.push(frame.clone());
    }
    frames
}

fn live(criterion: &mut Criterion) {
    let scene = Scene::from_toml(CAMERA_SCENE).expect("the fixture");
    let images = images(&scene);
    let mut group = criterion.benchmark_group("live");
    let mut observations: Vec<Observation> = Vec::new();
    for form in ["444", "420"] {
        let frames = frames(&stream(&images, form));
        let [width, height] = frames[0].size_px().map(|px| px as usize);
        let mut buffer = Vec::new();
        group.bench_function(format!("convert_whole/{form}"), |bencher| {
            bencher.iter(|| {
                for row in 0..height {
                    black_box(black_box(&frames[0]).row(row, 0..width, &mut buffer));
                }
            });
        });
        let mut observer = Observer::new(&scene, None).expect("an observer");
        let mut turn = frames.iter().cycle();
        group.bench_function(format!("track/{form}"), |bencher| {
            bencher.iter(|| observer.observe(black_box(turn.next().expect("a frame"))).expect("a finger"));
        });
        observations = frames.iter().map(|frame| observer.observe(frame).expect("a finger")).collect();
    }
    let asked = [("position", Direction::Angle(0.0)), ("position_and_direction", Direction::Auto)];
    for (unknown, direction) in asked {
        let contacts = SensorContacts::Asked(vec![ContactQuestion::new(None, direction)]);
        let mut finger =
            FingerTracker::new("", scene.clone(), contacts, SensorOptions::default(), 0).expect("a question");
        let mut turn = observations.iter().cycle();
        group.bench_function(format!("sense/{unknown}"), |bencher| {
            bencher.iter_batched(
                || turn.next().expect("a frame").clone(),
                |seen| {
                    let result = finger.evaluate(Ok(seen));
                    assert!(result.sensed.is_some(), "{:?}", result.refused);
                },
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, live);
criterion_main!(benches);
