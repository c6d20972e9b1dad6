//! The points of the report's chart of time against error, under their own names: `finray report` takes these times in the place of
//! its own where it finds them.
//!
//! An iteration is one answer, to each load or picture in turn, so the median is that of all. Lattices that settle take seconds and
//! are left to the report.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use finray_bench::paper;
use finray_model::statics::Statics;
use finray_verify::estimators::Estimator;
use finray_verify::networks::accuracy;
use finray_verify::networks::{NetworkSensing, Networks};
use finray_verify::speed_error::{self, Beams, Pictures, Task, criterion::group};
use finray_verify::study::CAMERA_NOISE_MM;
use finray_verify::truth::fine_mesh;
use std::hint::black_box;

/// As many as the full report's.
const NODES: usize = 11;
const PICTURES: usize = 40;
/// Lattices take milliseconds: the fewest samples that criterion allows are enough.
const SAMPLES: usize = 10;

fn shapes(criterion: &mut Criterion) {
    let finger = paper();
    let loads = speed_error::solved_loads(&finger, NODES);
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
    let shipped = Networks::shipped().expect("networks that ship");
    let network = NetworkSensing { name: accuracy::NAME, networks: &shipped, finger: &finger, refuses: true };
    let meshes = speed_error::sensing_meshes(&finger);
    let beams = speed_error::beam_estimators(&meshes);
    let beams = beams.iter().map(|(estimator, setting)| (estimator as &dyn Estimator, setting.as_str()));
    let estimators: Vec<(&dyn Estimator, &str)> =
        beams.chain([(&network as &dyn Estimator, "shipped networks")]).collect();
    let tasks = [
        (Task::SenseOne, speed_error::singles(&finger, NODES)),
        (Task::SenseNeighbours, speed_error::neighbours(&finger)),
    ];
    for (task, sets) in tasks {
        let take =
            |(stream, set): (usize, &Vec<_>)| Pictures::take(&truth, set, CAMERA_NOISE_MM, PICTURES, stream as u64);
        let pictures: Vec<Pictures> = sets.iter().enumerate().map(take).collect();
        let mut group = criterion.benchmark_group(group(task));
        for (estimator, setting) in &estimators {
            let prepare =
                |pictures: &Pictures| estimator.prepare(&pictures.contacts, &pictures.seen[0].1).expect("contacts");
            let mut prepared: Vec<_> = pictures.iter().map(prepare).collect();
            let shown =
                pictures.iter().enumerate().flat_map(|(set, of)| of.seen.iter().map(move |(_, seen)| (set, seen)));
            let shown: Vec<_> = shown.collect();
            let mut turn = shown.iter().cycle();
            group.bench_function(BenchmarkId::new(estimator.name(), setting), |bencher| {
                bencher.iter(|| {
                    let (set, picture) = turn.next().expect("a picture");
                    prepared[*set].estimate(black_box(picture), Some(CAMERA_NOISE_MM))
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, shapes, forces);
criterion_main!(benches);
