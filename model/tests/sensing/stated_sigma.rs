//! The stated standard deviation covers the error of the model, or a warning states why it may not cover this error.

use finray_model::measurement::Measurement;
use finray_model::sensing::{
    Contact, Discretisation, Estimate, ForcePrior, LinearEstimator, Linearisation, NonlinearEstimator, ResidualTest,
    SIGNIFICANCE, SensingError, Warning,
};
use finray_model::{Finger, Kinematics, Mesh};
use finray_tests::{CAMERA_NOISE_MM, ELEMENTS, TWO_SIDED_95, at_node, noisy, paper, seen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn linear(
    finger: &Finger,
    contact: Contact,
    seen: &Measurement,
    noise_mm: Option<f64>,
) -> Result<Estimate, SensingError> {
    let mesh = Arc::new(Mesh::with_elements_per_member(finger, ELEMENTS));
    let mut linearisation = Linearisation::new(mesh, &[contact]);
    LinearEstimator::new(finger, &[contact], seen)?.estimate_on(&mut linearisation, seen, noise_mm, ForcePrior::None)
}

/// For 3 N at -60 deg on node 19, the linear model senses 3.97 N. Its stated standard deviation was once 0.008 N. The error of linearisation,
/// computed from the sensed 3.97 N alone, equals the true error.
#[test]
fn a_linear_force_a_newton_off_is_not_stated_to_8_millinewtons() {
    let finger = paper();
    let fine = Mesh::with_nodes(&finger, 684).expect("684 nodes");
    for (node, angle_deg) in [(19, -60.0), (19, 0.0), (14, 30.0), (24, -20.0), (21, 70.0)] {
        let contact = at_node(node, angle_deg);
        let clean = seen(&fine, &[contact], &[3.0], Kinematics::Corotational).expect("an equilibrium");
        for noise_mm in [Some(CAMERA_NOISE_MM), None] {
            let estimate = linear(&finger, contact, &clean, noise_mm).expect("an answer");
            let true_error_n = estimate.forces_n[0] - 3.0;
            // Four elements per member cause an error of 0.04 % of the shape, which is 1.2 mN for a force of 3 N.
            let off_n = estimate.method_error_n[0] - true_error_n;
            assert!(
                off_n.abs() <= 0.01 * true_error_n.abs() + 0.0012,
                "{node} at {angle_deg}: {off_n} of {true_error_n} N"
            );
            assert!(true_error_n.abs() <= TWO_SIDED_95 * estimate.sigmas_n[0], "{estimate:?}");
            assert!(estimate.warning.is_some(), "{node} at {angle_deg}: {estimate:?}");
        }
    }
}

/// A measurement that a linear finger explains causes no warning, however large the error of linearisation would be for a co-rotational finger.
#[test]
fn a_linear_finger_is_taken_as_it_is() {
    let finger = paper();
    let key_nodes = Mesh::key_nodes(&finger);
    let contact = at_node(19, -60.0);
    let clean = seen(&key_nodes, &[contact], &[3.0], Kinematics::Linear).expect("an equilibrium");
    let per_noise =
        LinearEstimator::new(&finger, &[contact], &clean).expect("well-posed").inverse().sigmas_per_noise[0];
    let estimate = linear(&finger, contact, &clean, Some(CAMERA_NOISE_MM)).expect("an answer");
    assert_eq!((estimate.warning, estimate.sigmas_n[0]), (None, per_noise * CAMERA_NOISE_MM));
    let estimate = linear(&finger, contact, &clean, None).expect("an answer");
    assert!(estimate.warning.is_none() && estimate.sigmas_n[0] < 1e-9, "{estimate:?}");
}

/// On a mesh of 25 nodes, forces at nodes 19 and 20 once had errors of three standard deviations.
#[test]
fn a_coarse_mesh_states_its_own_error() {
    let finger = paper();
    let fine = Mesh::with_nodes(&finger, 684).expect("684 nodes");
    let coarse = Mesh::key_nodes(&finger);
    let finer = Discretisation::finer(&coarse);
    let mut largest = 0.0_f64;
    for node in 14..=24 {
        let contact = at_node(node, 0.0);
        let clean = seen(&fine, &[contact], &[3.0], Kinematics::Corotational).expect("an equilibrium");
        let mut estimator = NonlinearEstimator::new(&coarse, &[contact.into()]).expect("well-posed");
        let mut estimate = estimator.estimate(&clean, Some(CAMERA_NOISE_MM)).expect("an answer");
        let noise_n = estimate.forces.sigmas_n[0];
        let true_error_n = estimate.forces.forces_n[0] - 3.0;
        Discretisation::new(&coarse, &finer).widen(&mut estimator, &clean, &mut estimate).expect("an error");
        let estimate = estimate.forces;
        // Compared with one element per member, four elements reduce the error to a twentieth. Extrapolation has about the same accuracy.
        let off_n = estimate.method_error_n[0] - true_error_n;
        assert!(off_n.abs() <= 0.2 * true_error_n.abs() + 1e-4, "node {node}: {off_n} of {true_error_n} N");
        assert!(true_error_n.abs() <= TWO_SIDED_95 * estimate.sigmas_n[0], "node {node}: {estimate:?}");
        let warned = matches!(estimate.warning, Some(Warning::Discretisation(_)));
        assert_eq!(warned, estimate.method_error_n[0].abs() > noise_n, "node {node}: {estimate:?}");
        largest = largest.max(true_error_n.abs() / noise_n);
    }
    assert!(largest > 2.5, "some node is well beyond its noise: {largest}");
}

/// If the model is correct and the noise is as stated, one measurement in a hundred causes a warning.
#[test]
fn the_residual_test_keeps_its_significance() {
    let finger = paper();
    let contact = at_node(20, 10.0);
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let clean = seen(&mesh, &[contact], &[2.0], Kinematics::Corotational).expect("an equilibrium");
    let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("well-posed");
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (mut warned, mut of_twice) = (0, 0);
    const SAMPLES: usize = 2000;
    for _ in 0..SAMPLES {
        let noisy = noisy(&clean, 0.1, &mut rng);
        let mut answer = |stated_mm| estimator.estimate(&noisy, Some(stated_mm)).expect("an answer").forces;
        let as_stated = answer(0.1);
        warned += usize::from(as_stated.warning.is_some());
        // The standard deviation follows from the stated noise, or from the residual if the residual contradicts the stated noise.
        let ratio = as_stated.trusted_noise_mm / 0.1;
        assert_eq!(ratio == 1.0, as_stated.warning.is_none(), "{as_stated:?}");
        of_twice += usize::from(answer(0.05).warning.is_some());
    }
    let expected = SIGNIFICANCE * SAMPLES as f64;
    // The limit is four standard deviations of a Poisson distribution. Markers beyond 4.5 sigma are down-weighted, but such markers are very rare.
    assert!((warned as f64 - expected).abs() <= 4.0 * expected.sqrt(), "{warned} of {SAMPLES}");
    assert_eq!(of_twice, SAMPLES, "twice the stated noise never passes");
}

/// Residual and noise are written with enough digits to show their difference.
#[test]
fn a_residual_is_told_apart_from_the_noise() {
    let said = |residual_sd_mm, marker_noise_mm| {
        let noise_degrees_of_freedom = f64::INFINITY;
        let test = ResidualTest { marker_noise_mm, residual_sd_mm, degrees_of_freedom: 45, noise_degrees_of_freedom };
        Warning::Residual(test).to_string()
    };
    for (residual_mm, noise_mm, expected) in [
        (0.00138, 0.001, "standard deviation of 0.00138 mm, where 0.00100 mm of noise"),
        (0.2, 0.067, "standard deviation of 0.200 mm, where 0.067 mm of noise"),
        (12.5, 0.067, "standard deviation of 12.500 mm, where 0.067 mm of noise"),
        (1.4e-7, 1e-7, "standard deviation of 0.000000140 mm, where 0.000000100 mm of noise"),
    ] {
        assert!(said(residual_mm, noise_mm).contains(expected), "{}", said(residual_mm, noise_mm));
    }
}
