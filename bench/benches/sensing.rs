//! From shape to force: least squares, prepared each time and prepared once; Gauss-Newton on the large-rotation finger,
//! from a cold start and as a stream of frames.

use criterion::{Criterion, criterion_group, criterion_main};
use finray_bench::{paper, push};
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPlace, LinearEstimator, NonlinearEstimator, Prior};
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

/// One contact on 25 nodes, 3 N and 2.95 N by turns, as a camera would see a force that changes.
fn nonlinear(criterion: &mut Criterion) {
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let contact = Contact { place: ContactPlace::Node(NodeId(19)), angle_deg: 0.0 };
    let frames = [3.0, 2.95].map(|force_n| {
        let shape =
            statics::solve(&mesh, &[push(&finger, 19, force_n)], Kinematics::Corotational).expect("3 N are carried");
        Measurement::of_shape(&finger, &shape)
    });
    let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("node 19 is a contact node");
    criterion.bench_function("nonlinear/cold/1", |bencher| {
        bencher.iter(|| {
            estimator.reset();
            estimator.estimate(black_box(&frames[0]), Some(0.067))
        });
    });
    let mut frame = 0;
    criterion.bench_function("nonlinear/warm/1", |bencher| {
        bencher.iter(|| {
            frame = 1 - frame;
            estimator.estimate(black_box(&frames[frame]), Some(0.067))
        });
    });
}

criterion_group!(benches, sensing, nonlinear);
criterion_main!(benches);
