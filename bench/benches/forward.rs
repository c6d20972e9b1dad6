//! Times to compute shapes from forces, on the paper's two meshes and finer ones. Compares the ladder solver with the sparse solver, and compares
//! solving many loads one by one with solving them in a batch.
//!
//! The linear stiffness is constant, so its factors are stored after the first solution. The benchmarks `linear` and `mesh_size` include the
//! factorisation, because each iteration starts from a new mesh or solver. `linear_kept` and `as_called` reuse the factors.

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use finray_bench::{paper, push};
use finray_model::frame::FrameLoad;
use finray_model::statics::{self, Statics, equilibria};
use finray_model::{Kinematics, Load, Mesh, NodeId};
use std::hint::black_box;

/// Equilibrium under 3 N at node 19, solved from rest.
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
            let new_mesh = || Mesh::with_nodes(&finger, nodes).expect("mesh sizes of the paper");
            group.bench_function(BenchmarkId::new("ladder", nodes), |bencher| match forget {
                true => bencher.iter_batched_ref(
                    new_mesh,
                    |mesh| Statics::ladder(mesh, kinematics).equilibrium(black_box(&[load])),
                    BatchSize::LargeInput,
                ),
                false => bencher.iter(|| ladder.equilibrium(black_box(&[load]))),
            });
            let mut sparse = Statics::sparse(mesh.frame(), kinematics);
            group.bench_function(BenchmarkId::new("sparse", nodes), |bencher| match forget {
                true => bencher.iter_batched_ref(
                    || Statics::sparse(mesh.frame(), kinematics),
                    |sparse| sparse.equilibrium(black_box(&[load])),
                    BatchSize::LargeInput,
                ),
                false => bencher.iter(|| sparse.equilibrium(black_box(&[load]))),
            });
        }
        group.finish();
    }
}

/// Times the function `statics::solve`, which creates its solver on each call.
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

/// Times many loads of 3 N at nodes 18 to 20 in many directions, solved one by one and in a batch, on one thread.
fn many_at_once(criterion: &mut Criterion) {
    let finger = paper();
    let thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let mut group = criterion.benchmark_group("many_at_once");
    group.sample_size(20);
    for (nodes, count) in [(25, 256), (684, 16)] {
        let mesh = Mesh::with_nodes(&finger, nodes).expect("mesh sizes of the paper");
        let load = |i: usize| {
            let force = finger.direction(-30.0 + 60.0 * i as f64 / count as f64) * 3.0;
            mesh.frame_load(&Load::at_node(NodeId(18 + i % 3), force)).expect("the nodes are free")
        };
        let loads: Vec<[FrameLoad; 1]> = (0..count).map(|i| [load(i)]).collect();
        group.throughput(Throughput::Elements(count as u64));
        let mut single = Statics::ladder(&mesh, Kinematics::Corotational);
        group.bench_function(BenchmarkId::new("single", nodes), |bencher| {
            bencher.iter(|| black_box(&loads).iter().filter(|loads| single.equilibrium(*loads).is_ok()).count());
        });
        group.bench_function(BenchmarkId::new("batch", nodes), |bencher| {
            bencher.iter(|| thread.install(|| equilibria(&mesh, Kinematics::Corotational, black_box(&loads))));
        });
    }
    group.finish();
}

/// Time by mesh size, reported as nodes per second. The time should be proportional to the number of nodes.
fn mesh_size(criterion: &mut Criterion) {
    let finger = paper();
    let mut group = criterion.benchmark_group("mesh_size");
    group.sample_size(10);
    for nodes in [1_000, 10_000, 100_000] {
        let mesh = Mesh::with_nodes(&finger, nodes).expect("mesh sizes");
        let load = mesh.frame_load(&push(&finger, 19, 3.0)).expect("node 19 is free");
        group.throughput(Throughput::Elements(nodes as u64));
        for (kinematics, name) in [(Kinematics::Linear, "linear"), (Kinematics::Corotational, "corotational")] {
            group.bench_function(BenchmarkId::new(name, nodes), |bencher| {
                bencher.iter_batched_ref(
                    || Mesh::with_nodes(&finger, nodes).expect("mesh sizes"),
                    |mesh| Statics::ladder(mesh, kinematics).equilibrium(black_box(&[load])),
                    BatchSize::LargeInput,
                );
            });
        }
    }
    group.finish();
}

criterion_group!(benches, solve, as_called, many_at_once, mesh_size);
criterion_main!(benches);
