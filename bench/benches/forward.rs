//! From force to shape on the paper's two meshes: the ladder beside the general sparse path, and the cost of finer
//! meshes.
//!
//! The linear stiffness never changes, so the mesh keeps its factor; `linear` factorises each time nevertheless, `linear_kept`
//! and `as_called` do not.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use finray_bench::{paper, push};
use finray_model::statics::{self, Statics};
use finray_model::{Kinematics, Mesh};
use std::hint::black_box;

/// Factor and solve under 3 N at node 19, from rest.
fn solve(criterion: &mut Criterion) {
    let finger = paper();
    for (kinematics, name, forget) in [
        (Kinematics::Linear, "linear", true),
        (Kinematics::Linear, "linear_kept", false),
        (Kinematics::Corotational, "corotational", false),
    ] {
        let mut group = criterion.benchmark_group(name);
        for nodes in [25, 684] {
            let mesh = Mesh::with_nodes(&finger, nodes).expect("mesh sizes of the paper");
            let load = mesh.frame_load(&push(&finger, 19, 3.0)).expect("node 19 is free");
            let mut ladder = Statics::ladder(&mesh, kinematics);
            group.bench_function(BenchmarkId::new("ladder", nodes), |bencher| {
                bencher.iter(|| {
                    if forget {
                        ladder.forget_factor();
                    }
                    ladder.equilibrium(black_box(&[load]))
                });
            });
            let mut sparse = Statics::sparse(mesh.frame(), kinematics);
            group.bench_function(BenchmarkId::new("sparse", nodes), |bencher| {
                bencher.iter(|| {
                    if forget {
                        sparse.forget_factor();
                    }
                    sparse.equilibrium(black_box(&[load]))
                });
            });
        }
        group.finish();
    }
}

/// The simple function, which makes its solver each time: what its caller pays beyond the solution.
fn as_called(criterion: &mut Criterion) {
    let finger = paper();
    let mut group = criterion.benchmark_group("as_called");
    for nodes in [25, 684] {
        let mesh = Mesh::with_nodes(&finger, nodes).expect("mesh sizes of the paper");
        let load = push(&finger, 19, 3.0);
        for (kinematics, name) in [(Kinematics::Linear, "linear"), (Kinematics::Corotational, "corotational")] {
            group.bench_function(BenchmarkId::new(name, nodes), |bencher| {
                bencher.iter(|| statics::solve(&mesh, black_box(&[load]), kinematics));
            });
        }
    }
    group.finish();
}

/// Cost by mesh size, read off as nodes a second: it should grow with the number of nodes and no faster.
fn mesh_size(criterion: &mut Criterion) {
    let finger = paper();
    let mut group = criterion.benchmark_group("mesh_size");
    group.sample_size(10);
    for nodes in [1_000, 10_000, 100_000] {
        let mesh = Mesh::with_nodes(&finger, nodes).expect("mesh sizes");
        let load = mesh.frame_load(&push(&finger, 19, 3.0)).expect("node 19 is free");
        group.throughput(Throughput::Elements(nodes as u64));
        for (kinematics, name) in [(Kinematics::Linear, "linear"), (Kinematics::Corotational, "corotational")] {
            let mut ladder = Statics::ladder(&mesh, kinematics);
            group.bench_function(BenchmarkId::new(name, nodes), |bencher| {
                bencher.iter(|| {
                    ladder.forget_factor();
                    ladder.equilibrium(black_box(&[load]))
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, solve, as_called, mesh_size);
criterion_main!(benches);
