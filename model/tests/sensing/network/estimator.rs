//! Estimates of a network: standard deviations, the residual test, and refused shapes.

use super::{estimator, measured, random_network, random_shape};
use finray_model::estimators::network::Networks;
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::network::{ContactSet, Instructions, NetworkError, NetworkEstimator, TestError};
use finray_model::sensing::{SensingError, Warning};
use finray_model::{Kinematics, Mesh, statics};
use finray_tests::{CAMERA_NOISE_MM, at_node, at_nodes, noisy, paper};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Rounding error of least squares in f64 for a shape within the network's range.
const ROUNDING: f64 = 1e-9;
/// Largest relative error of a derivative computed in f64, compared with a difference of f32 forces over a step of 1e-2 mm.
const DERIVATIVE: f64 = 2e-3;

#[test]
fn sigmas_are_noise_through_the_derivatives_and_the_networks_own_error() {
    for contact_set in [ContactSet::Fixed, ContactSet::AnyOf] {
        let mut network = random_network(5, &[17, 20], contact_set, &[20, 10], 30);
        // The noise and the network's own error both contribute noticeably to the variance.
        let (noise_mm, clean_rms_n) = (0.1, 0.3);
        network.card.test_errors = vec![TestError { rms_n: 0.3, clean_rms_n }; 2];
        let mut estimator = estimator(&network, &[17, 20], Instructions::Detected);
        let shape = random_shape(&network, 6);
        let estimate = estimator
            .estimate(&measured(&network.card.markers, &shape), Some(noise_mm))
            .expect("a shape as in training");
        let step_mm = 1e-2;
        let mut squares = [0.0; 2];
        for k in 0..shape.len() {
            let mut forces_n = [[0.0; 2]; 2];
            for (forces_n, sign) in forces_n.iter_mut().zip([-0.5, 0.5]) {
                let mut shifted = shape.clone();
                shifted[k] += sign * step_mm;
                estimator.forces(&shifted, forces_n).expect("a frame");
            }
            for (i, square) in squares.iter_mut().enumerate() {
                *square += ((forces_n[1][i] - forces_n[0][i]) / step_mm * noise_mm).powi(2);
            }
        }
        for ((sigma_n, square), method_error_n) in estimate.sigmas_n.iter().zip(squares).zip(&estimate.method_error_n) {
            // The network's own error, and the error of the mesh of its training, to which random weights may be sensitive.
            assert!(*method_error_n >= clean_rms_n, "{method_error_n}");
            let expected_n = f64::hypot(square.sqrt(), *method_error_n);
            assert!((sigma_n / expected_n - 1.0).abs() <= DERIVATIVE, "{sigma_n} against {expected_n}");
        }
        assert!(estimate.residual_rms_mm <= ROUNDING, "{}", estimate.residual_rms_mm);
    }
}

#[test]
fn noise_that_the_residual_contradicts_is_not_believed() {
    let network = random_network(5, &[17, 20], ContactSet::Fixed, &[20], 10);
    let mut estimator = estimator(&network, &[17, 20], Instructions::Detected);
    let shape = random_shape(&network, 6);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let noisy: Vec<f64> = shape.iter().map(|x| x + rng.random_range(-0.5..0.5)).collect();
    let measurement = measured(&network.card.markers, &noisy);
    let unknown = estimator.estimate(&measurement, None).expect("noise alone");
    // 36 coordinates have uniform noise between -0.5 and 0.5, with a standard deviation of 0.29.
    assert!((0.2..0.4).contains(&unknown.trusted_noise_mm), "{}", unknown.trusted_noise_mm);
    let contradicted = estimator.estimate(&measurement, Some(CAMERA_NOISE_MM)).expect("noise alone");
    assert!(matches!(contradicted.warning, Some(Warning::Residual(_))));
    assert_eq!((&contradicted.forces_n, contradicted.residual_rms_mm), (&unknown.forces_n, unknown.residual_rms_mm));
    // Without a stated noise, only the residual determines the noise. For 36 degrees of freedom, Student's t widens the standard deviation by a
    // factor of 2.0281 / 1.9600.
    let wider = unknown.trusted_noise_mm / contradicted.trusted_noise_mm;
    assert!((wider - 2.0281 / 1.959_96).abs() < 1e-4, "{wider}");
    let believed = estimator.estimate(&measurement, Some(0.25)).expect("noise alone");
    assert_eq!((believed.trusted_noise_mm, believed.warning), (0.25, None));
}

/// A network for any subset of its contacts refuses contacts at which the forces do not act, and names the contact of the true force. Forces and noise
/// are those of the training. Right contacts are accepted.
#[test]
fn wrong_contacts_of_a_network_for_any_subset_are_refused() {
    let (finger, networks) = (paper(), Networks::read(&finray_fixtures::NETWORKS).expect("shipped networks"));
    let mesh = Mesh::with_elements_per_member(&finger, 8);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for (true_node, wrong) in [(15, 13), (22, 23), (17, 24), (18, 21), (21, 14)] {
        let load = at_node(true_node, 0.0).load(&finger, 1.5);
        let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("carried");
        let seen = noisy(&Measurement::of_shape(&finger, &shape), CAMERA_NOISE_MM, &mut rng);
        // No shipped network is trained for exactly these two contacts.
        let other = if true_node == 20 { 19 } else { 20 };
        let sense = |nodes: &[usize]| {
            let contacts = at_nodes(nodes);
            let network = networks.choose(&finger, &contacts).expect("a network for any subset");
            assert_eq!(network.card.contact_set, ContactSet::AnyOf);
            let mut estimator = NetworkEstimator::new(network, &finger, &contacts, &seen).expect("prepared");
            estimator.estimate(&seen, Some(CAMERA_NOISE_MM))
        };
        let right = sense(&[true_node, other, 16]).expect("right contacts");
        assert!((right.forces_n[0] - 1.5).abs() < 4.0 * right.sigmas_n[0], "{true_node}: {right:?}");
        match sense(&[wrong, 16, 19]) {
            Err(NetworkError::FurtherForce { contact, .. }) => assert_eq!(contact, format!("{true_node}@0")),
            Err(NetworkError::ForceOutsideTraining { .. }) => {}
            accepted => panic!("{true_node} as {wrong}: {accepted:?}"),
        }
    }
}

#[test]
fn strange_shapes_are_refused() {
    let network = random_network(5, &[17, 20], ContactSet::Fixed, &[20], 10);
    let mut estimator = estimator(&network, &[17, 20], Instructions::Detected);
    let shape = random_shape(&network, 6);
    let far: Vec<f64> = shape.iter().zip(&network.inputs.mean).map(|(x, mean)| mean + 10.0 * (x - mean)).collect();
    let refused = estimator.estimate(&measured(&network.card.markers, &far), Some(CAMERA_NOISE_MM));
    assert!(matches!(refused, Err(NetworkError::OutsideTraining { .. })), "{refused:?}");
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let noisy: Vec<f64> = shape.iter().map(|x| x + rng.random_range(-9.0..9.0)).collect();
    let refused = estimator.estimate(&measured(&network.card.markers, &noisy), Some(CAMERA_NOISE_MM));
    assert!(matches!(refused, Err(NetworkError::Sensing(SensingError::Unexplained { .. }))), "{refused:?}");
    let mut weighted: Vec<Marker> = measured(&network.card.markers, &shape).markers().to_vec();
    weighted[3].weight = 0.5;
    let refused = estimator.estimate(&Measurement::new(&paper(), weighted).expect("markers"), Some(CAMERA_NOISE_MM));
    assert!(matches!(refused, Err(NetworkError::Weighted { .. })), "{refused:?}");
}
