//! Speed of sweeps, in estimates per second: least squares, ridge and the nonlinear estimator on linear and co-rotational true fingers. One estimate is for one
//! position, direction, force, noise level and noise sample.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use finray_bench::paper;
use finray_model::estimators::EstimatorId::{self, LeastSquares, Nonlinear, Ridge};
use finray_model::estimators::network::Networks;
use finray_model::sensor::PreparedScene;
use finray_model::{Kinematics, Mesh, Scene};
use finray_studies::sampling::sampled::SampledSensor;
use finray_studies::sampling::sweep::{Grid, Sweep, Table};
use finray_studies::truths::TruthId;
use finray_studies::truths::{MeshTruth, Truth, fine_mesh};
use std::hint::black_box;

/// Name, true finger, estimator, forces (N), angle between directions (degrees) and number of noise samples.
type Case<'c> = (&'c str, &'c dyn Truth, EstimatorId, &'c [f64], f64, usize);

fn sweep(criterion: &mut Criterion) {
    let finger = paper();
    let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
    let coarse = Mesh::key_nodes(&finger);
    let fine = fine_mesh(&finger).expect("a mesh of many nodes");
    let linear = MeshTruth::new(TruthId::Linear, &coarse, Kinematics::Linear).expect("the finger at rest");
    let corotational =
        MeshTruth::new(TruthId::Corotational, &fine, Kinematics::Corotational).expect("the finger at rest");
    let four = [0.5, 1.0, 2.0, 3.0];
    let cases: [Case; 6] = [
        ("linear/least_squares/200_samples", &linear, LeastSquares, &four, 20.0, 200),
        ("linear/least_squares/1_sample", &linear, LeastSquares, &four, 2.0, 1),
        ("linear/least_squares/1_sample/1_force", &linear, LeastSquares, &four[1..2], 2.0, 1),
        ("corotational/least_squares/200_samples", &corotational, LeastSquares, &four, 20.0, 200),
        ("corotational/ridge/200_samples", &corotational, Ridge, &four, 20.0, 200),
        ("corotational/nonlinear/4_samples", &corotational, Nonlinear, &four, 80.0, 4),
    ];
    let mut group = criterion.benchmark_group("sweep");
    group.sample_size(10);
    for (name, truth, estimator, forces_n, step_deg, noise_samples) in cases {
        let (positions_mm, angles_deg) = Grid::grid(&finger, 12, step_deg);
        let grid = Grid {
            positions_mm,
            angles_deg,
            is_leaning: false,
            forces_n: forces_n.to_vec(),
            noise_levels_mm: vec![0.067],
            noise_samples,
            seed: 1,
        };
        let sensor = SampledSensor::new(estimator, Networks::none());
        let sweep = Sweep::new(scene.clone(), vec![truth], vec![sensor], &grid);
        let blocks = sweep.block_count();
        group.throughput(Throughput::Elements((blocks * sweep.cells_in_block() * noise_samples) as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let mut bytes = 0;
                let write = |_: usize, rows: &str| -> Result<(), csv::Error> {
                    bytes += black_box(rows).len();
                    Ok(())
                };
                sweep.stream(Table::Sweep, 0..blocks, write).map(|()| bytes)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, sweep);
criterion_main!(benches);
