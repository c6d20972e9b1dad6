//! Times for the report's chart of time against error. `finray report` uses these times instead of its own measurements.
//!
//! One iteration computes one answer; successive iterations take the loads or frames in turn. Frames of one contact are consecutive, because a warm
//! start requires this order. Settling a lattice takes seconds, so only the report times it.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use finray_bench::paper;
use finray_model::Scene;
use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::sensor::{PreparedScene, SensorOptions};
use finray_model::statics::Statics;
use finray_studies::experiments::speed_error::criterion::group;
use finray_studies::experiments::speed_error::sensing::{
    FRAMES_A_PERIOD, FrameSensor, Stream, TimedEstimator, beam_estimators, neighbours, sensing_meshes, singles,
};
use finray_studies::experiments::speed_error::{self, ASKED_NODES, Beams, Start, Task};
use finray_studies::settings::{CAMERA_NOISE_MM, ReportForces, TWO_FORCES_N};
use finray_studies::truths::fine_mesh;
use std::hint::black_box;

/// Number of frames, the same as in the full report.
const FRAMES: usize = 2 * FRAMES_A_PERIOD;
/// Number of samples that Criterion takes for a lattice: the smallest allowed number, because one shape of a lattice takes milliseconds to compute.
const SAMPLES: usize = 10;

fn shapes(criterion: &mut Criterion) {
    let finger = paper();
    let loads = speed_error::solved_loads(&finger, ASKED_NODES, ReportForces::PAPER);
    let mut group = criterion.benchmark_group(group(Task::Solve));
    for Beams { model, setting, kinematics, mesh } in speed_error::beams(&finger) {
        let loads: Vec<_> = loads.iter().map(|load| mesh.frame_load(load).expect("free nodes")).collect();
        let mut statics = Statics::ladder(&mesh, kinematics);
        let mut turn = loads.iter().cycle();
        group.bench_function(BenchmarkId::new(model, setting), |bencher| {
            bencher.iter(|| {
                let load = turn.next().expect("a load");
                statics.equilibrium(black_box(&[*load])).map(|equilibrium| mesh.shape(&equilibrium.motion))
            });
        });
    }
    group.sample_size(SAMPLES);
    for (setting, lattice) in speed_error::lattices(&finger).expect("lattices of the paper's finger") {
        let mut turn = loads.iter().cycle();
        group.bench_function(BenchmarkId::new(speed_error::LATTICE, setting), |bencher| {
            bencher.iter(|| lattice.equilibrium(black_box(&[*turn.next().expect("a load")])));
        });
    }
    group.finish();
}

fn forces(criterion: &mut Criterion) {
    let finger = paper();
    let truth = fine_mesh(&finger).expect("a mesh of many nodes");
    let shipped = Networks::read(&finray_fixtures::NETWORKS).expect("networks that ship");
    let options = SensorOptions { networks: shipped, ..SensorOptions::of(EstimatorId::Network) };
    let network = TimedEstimator { options, setting: "shipped networks".to_owned(), start: Start::None };
    let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
    let meshes = sensing_meshes(&finger);
    let estimators: Vec<TimedEstimator> = beam_estimators(&meshes).into_iter().chain([network]).collect();
    let tasks = [(Task::SenseOne, singles(&finger, ASKED_NODES)), (Task::SenseNeighbours, neighbours(&finger))];
    for (task, sets) in tasks {
        let take = |(stream, set): (usize, &Vec<_>)| {
            Stream::take(&truth, set, CAMERA_NOISE_MM, TWO_FORCES_N, FRAMES, stream as u64)
        };
        let streams: Vec<Stream> = sets.iter().enumerate().map(take).collect();
        let mut group = criterion.benchmark_group(group(task));
        for timed in &estimators {
            let prepare = |stream: &Stream| FrameSensor::new(&scene, timed, &stream.contacts).expect("contacts");
            let mut prepared: Vec<_> = streams.iter().map(prepare).collect();
            let frames =
                streams.iter().enumerate().flat_map(|(set, of)| of.frames.iter().map(move |frame| (set, frame)));
            let frames: Vec<_> = frames.collect();
            let mut turn = frames.iter().cycle();
            group.bench_function(BenchmarkId::new(timed.options.estimator.name(), timed.in_words()), |bencher| {
                bencher.iter(|| {
                    let (set, frame) = turn.next().expect("a frame");
                    prepared[*set].sense(black_box(&frame.seen), CAMERA_NOISE_MM).is_ok()
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, shapes, forces);
criterion_main!(benches);
