//! Times to estimate forces from shapes. Least squares is timed with preparation for each estimate, and with preparation only once.
//! Batches have thousands of samples.

use criterion::{Criterion, criterion_group, criterion_main};
use finray_bench::{paper, push};
use finray_model::frame::FrameLoad;
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPosition, ForcePrior, LinearEstimator, NonlinearEstimator};
use finray_model::statics::{Statics, equilibria};
use finray_model::{Kinematics, Mesh, NodeId, statics};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::hint::black_box;

fn sensing(criterion: &mut Criterion) {
    let finger = paper();
    let shape = statics::solve(&Mesh::key_nodes(&finger), &[push(&finger, 19, 2.0)], Kinematics::Linear)
        .expect("the linear finger is solved");
    let measurement = Measurement::of_shape(&finger, &shape);
    for nodes in [vec![19], vec![19, 20], (13..=24).collect()] {
        let contacts: Vec<Contact> = nodes
            .iter()
            .map(|&node| Contact { position: ContactPosition::Node(NodeId(node)), angle_deg: 0.0 })
            .collect();
        let count = contacts.len();
        let estimator = LinearEstimator::new(&finger, &contacts, &measurement).expect("well-posed");
        criterion.bench_function(&format!("least_squares/prepared/{count}"), |bencher| {
            bencher.iter(|| estimator.estimate(black_box(&measurement), Some(0.067), ForcePrior::None));
        });
        criterion.bench_function(&format!("least_squares/from_scratch/{count}"), |bencher| {
            bencher.iter(|| {
                LinearEstimator::new(&finger, &contacts, black_box(&measurement))
                    .map(|estimator| estimator.estimate(&measurement, Some(0.067), ForcePrior::None))
            });
        });
    }
}

/// Preparation of the nonlinear estimator for a contact. The bench `speed_error` times its answers.
fn nonlinear(criterion: &mut Criterion) {
    let finger = paper();
    for elements in [1, 4] {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        let contacts = [Contact::at_node(NodeId(19)).into()];
        criterion.bench_function(&format!("nonlinear/prepare/{}", mesh.node_count()), |bencher| {
            bencher.iter(|| NonlinearEstimator::new(&mesh, black_box(&contacts)).expect("a contact node"));
        });
    }
}

/// Times many samples on the co-rotational finger, as needed for training or a map. Shapes are computed under random normal forces at all contact
/// nodes, and pairs of forces are sensed from random shapes. Forces are 0 to 5 N per node and 0 to 10 N in total (Xu et al. 2021, sec. IV-A). Runs on
/// two threads.
fn samples(criterion: &mut Criterion) {
    const COUNT: usize = 2_000;
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let nodes: Vec<NodeId> = finger.contact_nodes().collect();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut draw = |nodes: &[NodeId]| -> Vec<FrameLoad> {
        let forces_n: Vec<f64> = nodes.iter().map(|_| rng.random_range(0.0..5.0)).collect();
        let total_n = rng.random_range(0.0..10.0);
        let share = f64::min(1.0, total_n / forces_n.iter().sum::<f64>());
        let load = |(node, force_n): (&NodeId, &f64)| push(&finger, node.0, force_n * share);
        nodes.iter().zip(&forces_n).filter_map(|each| mesh.frame_load(&load(each)).ok()).collect()
    };
    let cases: Vec<Vec<FrameLoad>> = (0..COUNT).map(|_| draw(&nodes)).collect();
    let pair = [NodeId(18), NodeId(20)];
    let pairs: Vec<Vec<FrameLoad>> = (0..COUNT).map(|_| draw(&pair)).collect();
    let solver = Statics::ladder(&mesh, Kinematics::Corotational);
    let shapes: Vec<Measurement> = pairs
        .iter()
        .filter_map(|loads| solver.clone().equilibrium(loads).ok())
        .map(|equilibrium| Measurement::of_shape(&finger, &mesh.shape(&equilibrium.motion)))
        .collect();
    let contacts = pair.map(|node| Contact { position: ContactPosition::Node(node), angle_deg: 0.0 }.into());
    let estimator = NonlinearEstimator::new(&mesh, &contacts).expect("contact nodes");
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads");
    let carried = cases.iter().filter(|loads| solver.clone().equilibrium(loads).is_ok()).count();
    let mut group = criterion.benchmark_group("samples");
    group.sample_size(10);
    group.bench_function(format!("forward/{COUNT}_of_which_{carried}_carried"), |bencher| {
        bencher.iter(|| {
            let solve = |solver: &mut Statics<_>, loads: &Vec<FrameLoad>| solver.equilibrium(loads).is_ok();
            let solved = cases.par_iter().map_init(|| solver.clone(), solve);
            threads.install(|| solved.filter(|solved| *solved).count())
        });
    });
    group.bench_function(format!("forward_at_once/{COUNT}_of_which_{carried}_carried"), |bencher| {
        bencher.iter(|| {
            let found = threads.install(|| equilibria(&mesh, Kinematics::Corotational, &cases));
            found.iter().filter(|found| found.is_ok()).count()
        });
    });
    group.bench_function(format!("sensing/{}", shapes.len()), |bencher| {
        bencher.iter(|| {
            let sense = |estimator: &mut NonlinearEstimator, shape: &Measurement| {
                estimator.reset();
                estimator.estimate(shape, Some(0.067)).is_ok()
            };
            let sensed = shapes.par_iter().map_init(|| estimator.clone(), sense);
            threads.install(|| sensed.filter(|sensed| *sensed).count())
        });
    });
    group.finish();
}

criterion_group!(benches, sensing, nonlinear, samples);
criterion_main!(benches);
