//! Calibration of Young's modulus, for random fingers and from noisy shapes.

mod factors;
mod modulus;
mod views;

use finray_model::calibration::{CalibrationCase, youngs_modulus};
use finray_model::measurement::Measurement;
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector, statics};
use finray_tests::{at_node, cases, contact_node, finger_with_zones, paper, seen};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Repetitions of the experiment.
const COUNT: usize = 1000;

/// Rounding error between solutions of two fingers that differ only in modulus. Thin plates stretch up to 1e5 times less than they bend, and a chain
/// of plates multiplies the condition number of the stiffness by another 1e4.
const ROUNDING: f64 = 1e-6;
/// Noise of a coordinate, mm.
const NOISE_MM: f64 = 0.2;

proptest! {
    #![proptest_config(cases(128))]

    /// The calibrated modulus equals the true modulus for any modulus of the scene. One grossly wrong marker hardly changes the result.
    #[test]
    fn modulus_comes_back(finger in finger_with_zones(), factor in 0.2..5.0, at in [0.0..1.0, 0.0..1.0]) {
        let stiffer = finger.with_modulus_factor(factor).expect("a positive modulus");
        let cases: Vec<CalibrationCase> = at
            .iter()
            .map(|&fraction| {
                let contact = at_node(contact_node(&finger, fraction).0, 10.0);
                let measurement = seen(&Mesh::key_nodes(&stiffer), &[contact], &[1.5], Kinematics::Linear);
                CalibrationCase { load: contact.load(&finger, 1.5), measurement: measurement.expect("a solution") }
            })
            .collect();
        let estimate = youngs_modulus(&finger, &cases).expect("loads move the nodes");
        let mut spoiled = cases.clone();
        let mut markers = spoiled[0].measurement.markers().to_vec();
        markers[0].displacement *= 3.0;
        spoiled[0].measurement = Measurement::new(&finger, markers.clone()).expect("the same markers");
        let forgiven = youngs_modulus(&finger, &spoiled).expect("loads move the nodes");
        // Eq. (11) of the paper sums distances, so one bad node has no effect at all while the other nodes outweigh it.
        if markers.len() > 8 {
            prop_assert!((forgiven.factor / factor - 1.0).abs() <= ROUNDING, "{}", forgiven.factor);
        }
        prop_assert!((estimate.factor / factor - 1.0).abs() <= ROUNDING, "{} against {factor}: {estimate:?}", estimate.factor);
    }
}

/// The stated standard deviation equals the scatter of the factor over many noisy experiments, with the paper's weights on three nodes.
#[test]
fn sigma_is_the_scatter_of_the_factor() {
    let finger = paper();
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
            case.measurement.add_noise(NOISE_MM, || StandardNormal.sample(&mut rng));
        }
        let found = youngs_modulus(&finger, &cases).expect("the nodes move with the loads");
        squares += (found.factor - 1.0).powi(2);
        sigmas += found.sigma;
    }
    let scatter = (squares / COUNT as f64).sqrt();
    let stated = sigmas / COUNT as f64;
    // Four standard errors of a standard deviation from 1000 samples are 9 %. The stated standard deviation is itself accurate to first order only.
    assert!((stated / scatter - 1.0).abs() < 0.1, "stated {stated}, found {scatter}");
}
