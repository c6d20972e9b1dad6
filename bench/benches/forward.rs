//! From force to shape: linear and large-rotation solutions on the paper's two meshes, general sparse path.

use criterion::{Criterion, criterion_group, criterion_main};
use finray_bench::{paper, push};
use finray_model::statics::Statics;
use finray_model::{Kinematics, Mesh};
use std::hint::black_box;

fn forward(criterion: &mut Criterion) {
    let finger = paper();
    for nodes in [25, 684] {
        let mesh = Mesh::with_nodes(&finger, nodes).expect("mesh sizes of the paper");
        let load = mesh.frame_load(&push(&finger, 19, 3.0)).expect("node 19 is free");
        for (kinematics, name) in [(Kinematics::Linear, "linear"), (Kinematics::Corotational, "corotational")] {
            let mut statics = Statics::new(mesh.frame(), kinematics);
            criterion.bench_function(&format!("sparse/{name}/{nodes}"), |bencher| {
                bencher.iter(|| statics.equilibrium(black_box(&[load])));
            });
        }
    }
}

criterion_group!(benches, forward);
criterion_main!(benches);
