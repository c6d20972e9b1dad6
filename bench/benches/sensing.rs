//! From shape to force: least squares, prepared each time and prepared once.

use criterion::{Criterion, criterion_group, criterion_main};
use finray_bench::{paper, push};
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPlace, LinearEstimator, Prior};
use finray_model::{Kinematics, Mesh, NodeId, statics};
use std::hint::black_box;

fn sensing(criterion: &mut Criterion) {
    let finger = paper();
    let shape = statics::solve(&Mesh::key_nodes(&finger), &[push(&finger, 19, 2.0)], Kinematics::Linear)
        .expect("the linear finger is solved");
    let measurement = Measurement::of_shape(&finger, &shape);
    for nodes in [vec![19], vec![19, 20], (13..=24).collect()] {
        let contacts: Vec<Contact> =
            nodes.iter().map(|&node| Contact { place: ContactPlace::Node(NodeId(node)), angle_deg: 0.0 }).collect();
        let count = contacts.len();
        let estimator = LinearEstimator::new(&finger, &contacts, &measurement).expect("well-posed");
        criterion.bench_function(&format!("least_squares/prepared/{count}"), |bencher| {
            bencher.iter(|| estimator.estimate(black_box(&measurement), Some(0.067), Prior::None));
        });
        criterion.bench_function(&format!("least_squares/from_scratch/{count}"), |bencher| {
            bencher.iter(|| {
                LinearEstimator::new(&finger, &contacts, black_box(&measurement))
                    .map(|estimator| estimator.estimate(&measurement, Some(0.067), Prior::None))
            });
        });
    }
}

criterion_group!(benches, sensing);
criterion_main!(benches);
