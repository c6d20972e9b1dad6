//! Young's modulus from noisy shapes.

use finray_model::calibration::{CalibrationCase, youngs_modulus};
use finray_model::measurement::Measurement;
use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, Vector, statics};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Repetitions of the experiment.
const COUNT: usize = 1000;

/// The stated standard deviation is that of the factor over many noisy experiments, with the paper's weights on its
/// three nodes.
#[test]
fn sigma_is_the_scatter_of_the_factor() {
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("paper scene").finger;
    let mesh = Mesh::key_nodes(&finger);
    let clean: Vec<CalibrationCase> = [(17, 0.5), (19, 1.0), (21, 2.0)]
        .into_iter()
        .map(|(node, force)| {
            let load = Load::at_node(NodeId(node), Vector::new(0.0, -force));
            let shape = statics::solve(&mesh, &[load], Kinematics::Linear).expect("a linear solution");
            CalibrationCase { load, measurement: Measurement::of_shape(&finger, &shape) }
        })
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (mut squares, mut sigmas) = (0.0, 0.0);
    for _ in 0..COUNT {
        let mut cases = clean.clone();
        for case in &mut cases {
            case.measurement.add_noise(0.2, || StandardNormal.sample(&mut rng));
        }
        let found = youngs_modulus(&finger, &cases).expect("the nodes move with the loads");
        squares += (found.factor - 1.0).powi(2);
        sigmas += found.sigma;
    }
    let scatter = (squares / COUNT as f64).sqrt();
    let stated = sigmas / COUNT as f64;
    // Four standard errors of a standard deviation from 1000 samples are 9 %; the estimate is itself good to first order.
    assert!((stated / scatter - 1.0).abs() < 0.1, "stated {stated}, found {scatter}");
}
