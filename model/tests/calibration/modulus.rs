//! Calibration of one modulus with the co-rotational finger. The calibrated modulus is unbiased under large deflection, its intervals cover the
//! truth, and outlying markers have little effect.

use finray_model::calibration::{CalibrationCase, corotational_modulus, youngs_modulus};
use finray_model::finger::Finger;
use finray_model::measurement::Measurement;
use finray_model::{Kinematics, Load, Mesh, Scene, statics};
use finray_tests::{CAMERA_NOISE_MM, paper};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Elements per member of the estimate. The true finger has a finer mesh.
const ELEMENTS: usize = 8;
const FINE: usize = 16;
const TRUE_FACTOR: f64 = 0.9;
/// Number of noisy repetitions on each finger.
const REPEATS: usize = 40;

fn scene(text: &str) -> Finger {
    Scene::from_toml(text).expect("a scene").finger
}

/// Shapes of a finger with 0.9 times the modulus of `finger`, under weights at contact nodes.
fn weighed(finger: &Finger, weights: &[(usize, f64)]) -> Vec<CalibrationCase> {
    let softer = finger.with_modulus_factor(TRUE_FACTOR).expect("a positive modulus");
    let mesh = Mesh::with_elements_per_member(&softer, FINE);
    let case = |&(contact, force_n): &(usize, f64)| {
        let node = finger.contact_nodes().nth(contact).expect("a contact node");
        let load = Load::at_node(node, finger.direction(0.0) * force_n);
        let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium");
        CalibrationCase { load, measurement: Measurement::of_shape(finger, &shape) }
    };
    weights.iter().map(case).collect()
}

fn noisy(cases: &[CalibrationCase], rng: &mut ChaCha8Rng) -> Vec<CalibrationCase> {
    let mut cases = cases.to_vec();
    cases.iter_mut().for_each(|case| case.measurement.add_noise(CAMERA_NOISE_MM, || StandardNormal.sample(rng)));
    cases
}

/// Weights of 0.2 to 3 N bend the paper's finger by 1 to 20 mm. The modulus from eq. (11) of the paper would have an error of 4 to 8 of its standard
/// deviations.
#[test]
fn weights_that_bend_far_lead_to_the_true_modulus() {
    let cases = weighed(&paper(), &[(4, 3.0), (6, 3.0), (8, 3.0)]);
    let noisy = noisy(&cases, &mut ChaCha8Rng::seed_from_u64(1));
    let linear = youngs_modulus(&paper(), &noisy).expect("a factor");
    let found = corotational_modulus(&paper(), &noisy, ELEMENTS, None).expect("a factor");
    assert!((linear.factor - TRUE_FACTOR).abs() > 3.0 * linear.sigma, "{linear:?}");
    assert!((found.factor - TRUE_FACTOR).abs() < 3.0 * found.sigma, "{found:?}");
    // The difference between the meshes is far below the noise.
    assert!(found.sigma < 0.01 && found.outliers.is_empty() && found.contradiction.is_none(), "{found:?}");
    let exact = corotational_modulus(&paper(), &cases, ELEMENTS, None).expect("a factor");
    assert!((exact.factor / TRUE_FACTOR - 1.0).abs() < 1.5e-4, "{exact:?}");
    // Without noise, only the difference between the meshes contributes to sigma.
    assert!((exact.factor - TRUE_FACTOR).abs() < 3.0 * exact.sigma && exact.sigma < 1e-3, "{exact:?}");
}

/// Errors divided by stated standard deviations follow a normal distribution: mean 0, mean square 1, and two of three within one standard deviation.
#[test]
fn sigmas_cover_on_three_fingers() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let fingers = [
        (paper(), vec![(4, 0.2), (6, 1.0), (8, 3.0)]),
        (scene(finray_fixtures::BRACKETS_SCENE), vec![(2, 0.2), (3, 0.5), (4, 1.0)]),
        (scene(finray_fixtures::TWIN_SCENE), vec![(5, 0.3), (7, 0.6), (9, 1.0)]),
    ];
    for (finger, weights) in fingers {
        let cases = weighed(&finger, &weights);
        for noise_mm in [None, Some(CAMERA_NOISE_MM)] {
            let z: Vec<f64> = (0..REPEATS)
                .map(|_| {
                    let found =
                        corotational_modulus(&finger, &noisy(&cases, &mut rng), ELEMENTS, noise_mm).expect("a factor");
                    (found.factor - TRUE_FACTOR) / found.sigma
                })
                .collect();
            let mean = z.iter().sum::<f64>() / REPEATS as f64;
            let square = z.iter().map(|z| z * z).sum::<f64>() / REPEATS as f64;
            let within = z.iter().filter(|z| z.abs() < 1.0).count() as f64 / REPEATS as f64;
            let worst = z.iter().fold(0.0, |worst: f64, z| worst.max(z.abs()));
            println!("{weights:?}: mean {mean:.2}, mean square {square:.2}, within one {within:.2}, worst {worst:.1}");
            // Three standard errors of forty samples are 0.47 for the mean, 0.67 for the mean square, and 0.22 for the share.
            assert!(mean.abs() < 0.47 && (square - 1.0).abs() < 0.67 && (within - 0.683).abs() < 0.22 && worst < 4.0);
        }
    }
}

/// Two markers with swapped node numbers change the factor by less than half of its standard deviation, and both are reported.
#[test]
fn single_bad_markers_are_forgiven_and_named() {
    let mut cases = noisy(&weighed(&paper(), &[(4, 1.0), (8, 1.5)]), &mut ChaCha8Rng::seed_from_u64(3));
    let clean = corotational_modulus(&paper(), &cases, ELEMENTS, None).expect("a factor");
    let mut markers = cases[1].measurement.markers().to_vec();
    let (one, other) = (markers[3].displacement, markers[15].displacement);
    (markers[3].displacement, markers[15].displacement) = (other, one);
    cases[1].measurement = Measurement::new(&paper(), markers.clone()).expect("the same markers");
    let found = corotational_modulus(&paper(), &cases, ELEMENTS, None).expect("a factor");
    assert!((found.factor - clean.factor).abs() < 0.5 * clean.sigma, "{found:?}, {clean:?}");
    let named: Vec<_> = found.outliers.iter().map(|outlier| (outlier.case, outlier.node)).collect();
    assert_eq!(named, [(1, markers[3].node), (1, markers[15].node)]);
    // A stated noise that does not explain the residual is not used.
    let stated = corotational_modulus(&paper(), &cases, ELEMENTS, Some(0.1 * CAMERA_NOISE_MM)).expect("a factor");
    assert!(stated.contradiction.is_some() && stated.sigma > 0.8 * clean.sigma, "{stated:?}");
}
