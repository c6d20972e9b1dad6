//! Streams of frames, and the error that a mesh adds to the noise.

use finray_model::sensor::PreparedScene;
use finray_model::{Mesh, NodeId, Scene};
use finray_studies::experiments::speed_error::sensing::{
    FRAMES_A_PERIOD, Frame, FrameSensor, Stream, beam_estimators, largest_bias, sensed, sensing_meshes,
};
use finray_studies::experiments::speed_error::{Start, Task};
use finray_studies::settings::TWO_FORCES_N;
use finray_studies::truths::fine_mesh;
use finray_tests::{CAMERA_NOISE_MM, paper};
use std::f64::consts::TAU;

fn scene() -> PreparedScene {
    Scene::of_finger(paper()).into()
}

fn stream_at(node: usize) -> (Mesh, Stream) {
    let truth = fine_mesh(&paper()).expect("a mesh");
    let stream = Stream::take(&truth, &[NodeId(node)], CAMERA_NOISE_MM, TWO_FORCES_N, FRAMES_A_PERIOD, 0);
    (truth, stream)
}

/// Frames show the fine finger with noise, and the force changes in realistic steps over the whole range.
#[test]
fn frames_are_those_of_a_moving_force() {
    let (truth, stream) = stream_at(19);
    assert_eq!(truth.node_count(), 684);
    assert_eq!(stream.frames.len(), FRAMES_A_PERIOD);
    let forces: Vec<f64> = stream.frames.iter().map(|frame| frame.forces_n[0]).collect();
    let largest_step = forces.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    // The largest step of the sinusoid is 2 x 1.35 N x sin(pi / 25).
    assert!((largest_step - 2.0 * 1.35 * (TAU / 50.0).sin()).abs() < 0.01, "{largest_step}");
    let [low, high] = [f64::min, f64::max].map(|of| forces.iter().copied().reduce(of).expect("frames"));
    assert!(low < 0.32 && high > 2.98 && low >= 0.3 && high <= 3.0, "{low} to {high}");
    let noise: Vec<f64> = stream
        .frames
        .iter()
        .flat_map(|frame| {
            let pairs = frame.seen.markers().iter().zip(frame.exact.markers());
            pairs.map(|(seen, exact)| (seen.displacement - exact.displacement).norm_squared()).collect::<Vec<_>>()
        })
        .collect();
    let rms = (noise.iter().sum::<f64>() / (2 * noise.len()) as f64).sqrt();
    // A standard deviation estimated from 2 x 23 x 25 draws has a relative standard error of 2 %.
    assert!((rms / CAMERA_NOISE_MM - 1.0).abs() < 0.1, "{rms}");
}

/// Cold and warm starts give the same forces for the same frames; the start changes only the time.
#[test]
fn cold_and_warm_starts_answer_alike() {
    let (truth, stream) = stream_at(22);
    let meshes = sensing_meshes(truth.finger());
    let estimators = beam_estimators(&meshes);
    let answers = |start| {
        let timed = estimators.iter().find(|timed| timed.start == start).expect("a nonlinear estimator");
        let mut sensor = FrameSensor::new(&scene(), timed, &stream.contacts).expect("a contact node");
        let answer = |frame: &Frame| sensor.sense(&frame.seen, CAMERA_NOISE_MM).expect("an answer").forces[0].force_n;
        stream.frames.iter().map(answer).collect::<Vec<f64>>()
    };
    for (cold, warm) in answers(Start::Cold).into_iter().zip(answers(Start::Warm)) {
        // Both searches end if a step changes the force by less than 1e-7 of its scale.
        assert!((cold - warm).abs() < 1e-4, "{cold} and {warm}");
    }
}

/// At node 20, the model error on the mesh of key nodes exceeds two standard deviations of the noise; with eight elements per member, it is below
/// 0.4.
#[test]
fn the_bias_of_a_coarse_mesh_is_seen() {
    let (truth, stream) = stream_at(20);
    let meshes = sensing_meshes(truth.finger());
    let streams = [stream];
    let biases: Vec<f64> = beam_estimators(&meshes)
        .iter()
        .filter(|timed| timed.start == Start::Cold)
        .map(|timed| {
            let point = sensed(&scene(), Task::SenseOne, timed, CAMERA_NOISE_MM, &streams).expect("an answer");
            assert_eq!((point.failed, point.asked), (0, FRAMES_A_PERIOD));
            assert!(point.seconds_95 >= Some(point.seconds) && point.preparation_seconds > Some(0.0));
            let bias_sigmas = largest_bias(&scene(), timed, CAMERA_NOISE_MM, &streams).expect("an answer");
            bias_sigmas.expect("stated standard deviations")
        })
        .collect();
    assert!(biases[0] > 2.0 && biases[3] < 0.4, "{biases:?}");
    // The error of least squares at 3 N is 45 standard deviations of the noise. An earlier version divided the error by the wider stated standard
    // deviation, which gave only 7.5.
    let estimators = beam_estimators(&meshes);
    let linear = estimators.iter().find(|timed| timed.start == Start::None).expect("least squares");
    let bias_sigmas = largest_bias(&scene(), linear, CAMERA_NOISE_MM, &streams).expect("an answer");
    assert!(bias_sigmas > Some(30.0), "{bias_sigmas:?}");
}
