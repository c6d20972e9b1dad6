//! Errors of tiny networks, compared with the Cramer-Rao bound, the linear finger and the values on their cards.

use super::{Squares, fresh, noisy_shapes, sensed, squares, tiny, trained};
use finray_model::compliance::Compliance;
use finray_model::mesh::FingerShape;
use finray_model::sensing::Contact;
use finray_model::sensing::network::{ContactSet, Network, Scaling};
use finray_model::{Load, Mesh, NodeId, Vector, statics};
use finray_tests::{CAMERA_NOISE_MM, STANDARD_ERRORS, at_nodes, paper};
use finray_train::TrainingRecipe;
use finray_train::samples::{SampleRecipe, Samples};
use nalgebra::{DMatrix, DVector};

/// Limit of the error of a tiny network, as a multiple of the Cramer-Rao bound. Measured: 1.2 to 1.6. The margin covers other machines' rounding,
/// which training magnifies.
const OVER_BOUND: f64 = 2.0;
/// Limit of the error of a tiny network, as a share of the error of the linear finger. Measured: a twentieth or less for all contacts of these tests.
const OF_LINEAR: f64 = 0.1;

/// Forces, N, that fit the displacements by least squares, with the compliance of the linear finger. A positive `ridge` adds a prior. The value is
/// the ratio of noise to prior force, mm/N.
fn linear_forces(recipe: &SampleRecipe, samples: &Samples, displacements: &DMatrix<f64>, ridge: f64) -> DMatrix<f64> {
    let finger = paper();
    let loads: Vec<Load> = recipe.contacts.iter().map(|contact| contact.unit_load(&finger)).collect();
    let compliance = Compliance::new(&finger, &loads).expect("contact nodes");
    let matrix = DMatrix::from_fn(displacements.nrows(), loads.len(), |row, load| {
        compliance.displacement(samples.markers[row / 2], load)[row % 2]
    });
    let mut forces_n = DMatrix::zeros(loads.len(), samples.count());
    for case in 0..samples.count() {
        let touching: Vec<usize> = (0..loads.len()).filter(|&i| samples.touching[case][i]).collect();
        let c = matrix.select_columns(&touching);
        let normal = c.transpose() * &c + DMatrix::identity(touching.len(), touching.len()) * ridge * ridge;
        let found_n = normal.cholesky().expect("contacts apart").solve(&(c.transpose() * displacements.column(case)));
        touching.iter().zip(found_n.iter()).for_each(|(&i, force_n)| forces_n[(i, case)] = *force_n);
    }
    forces_n
}

/// Cramer-Rao bound of each force, root mean square over the cases, N. The covariance is noise^2 (J^T J)^-1. J holds the derivatives of the
/// co-rotational finger's displacements with respect to the forces, computed from differences.
fn bounds_n(recipe: &SampleRecipe, samples: &Samples, noise_mm: f64) -> Vec<f64> {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, recipe.elements);
    let step_n = 1e-3;
    let shape = |forces_n: &DVector<f64>| -> FingerShape {
        let load = |(contact, force_n): (&Contact, &f64)| contact.load(&finger, *force_n);
        let loads: Vec<Load> = recipe.contacts.iter().zip(forces_n.iter()).map(load).collect();
        statics::solve(&mesh, &loads, recipe.kinematics).expect("carried")
    };
    let mut variances = vec![0.0; recipe.contacts.len()];
    for forces in samples.forces.column_iter() {
        let columns: Vec<DVector<f64>> = (0..forces.len())
            .map(|i| {
                let step = DVector::from_fn(forces.len(), |j, _| if i == j { step_n } else { 0.0 });
                let (more, less) = (shape(&(forces + &step)), shape(&(forces - &step)));
                let rate = |node: &NodeId| -> Vector {
                    (more.motion(*node).displacement - less.motion(*node).displacement) / (2.0 * step_n)
                };
                let rates = samples.markers.iter().map(rate).flat_map(|rate| [rate.x, rate.y]);
                DVector::from_iterator(2 * samples.markers.len(), rates)
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let covariance = (jacobian.transpose() * jacobian).try_inverse().expect("identifiable forces");
        (0..forces.len()).for_each(|i| variances[i] += covariance[(i, i)] * noise_mm * noise_mm);
    }
    variances.iter().map(|sum| (sum / samples.count() as f64).sqrt()).collect()
}

/// After a second of training, a network's errors on the noisy co-rotational finger are near the Cramer-Rao bound, and far below the errors of the
/// linear finger.
#[test]
fn tiny_networks_sense_the_nonlinear_finger() {
    for nodes in [&[19][..], &[16, 20], &[19, 20]] {
        let recipe = tiny(nodes, 2000, 16, 60);
        let network = trained(&recipe);
        let samples = fresh(&recipe.samples, 500);
        let displacements = noisy_shapes(&samples, CAMERA_NOISE_MM);
        let found = squares(&samples, &sensed(&network, &samples, &displacements));
        let linear = squares(&samples, &linear_forces(&recipe.samples, &samples, &displacements, 0.0));
        let bounds = bounds_n(&recipe.samples, &samples, CAMERA_NOISE_MM);
        for ((found, linear), bound) in found.iter().zip(&linear).zip(bounds) {
            let (found, linear) = (found.rms(), linear.rms());
            assert!(found <= OVER_BOUND * bound, "{nodes:?}: {found} N, bound {bound} N");
            assert!(found <= OF_LINEAR * linear, "{nodes:?}: {found} N, linear {linear} N");
        }
    }
}

/// The paper's recipe with fewer cases and smaller layers. The inputs are scaled coordinates, there is no linear branch, and the samples are
/// noise-free shapes of the linear finger.
#[test]
fn coordinates_serve_as_inputs() {
    let recipe = TrainingRecipe {
        count: 1000,
        hidden_layers: vec![16, 16],
        epochs: 60,
        batch: 64,
        learning_rate: 1e-2,
        ..TrainingRecipe::paper(at_nodes(&[19]))
    };
    let network = trained(&recipe);
    let samples = fresh(&recipe.samples, 500);
    let found = squares(&samples, &sensed(&network, &samples, &samples.displacements))[0].rms();
    // The measured error is 0.024 N for forces of 0 to 5 N.
    assert!(found <= 0.06, "{found} N");
}

/// A network for any subset of three contacts improves on the ridge forces of the loaded contacts, with and without noise.
#[test]
fn any_contacts_may_touch() {
    let mut recipe = tiny(&[16, 18, 20], 2000, 16, 60);
    recipe.samples.any_of = true;
    let network = trained(&recipe);
    assert_eq!(network.card.contact_set, ContactSet::AnyOf);
    let samples = fresh(&recipe.samples, 1000);
    let ridge = CAMERA_NOISE_MM / network.card.prior_n;
    for noise_mm in [0.0, CAMERA_NOISE_MM] {
        let displacements = noisy_shapes(&samples, noise_mm);
        let found = squares(&samples, &sensed(&network, &samples, &displacements));
        let start = squares(&samples, &linear_forces(&recipe.samples, &samples, &displacements, ridge));
        for (found, start) in found.iter().zip(&start) {
            let (found, start) = (found.rms(), start.rms());
            assert!(found <= OF_LINEAR * start, "{found} N, ridge {start} N");
        }
        assert_stated(&network, &found, noise_mm);
    }
}

/// Checks that errors on fresh samples agree with the errors that the network states, within the random scatter of both.
fn assert_stated(network: &Network, found: &[Squares], noise_mm: f64) {
    for (found, stated) in found.iter().zip(&network.card.test_errors) {
        let stated_n = if noise_mm == 0.0 { stated.clean_rms_n } else { stated.rms_n };
        let cases = 1.0 / found.0.len() as f64 + 1.0 / network.card.test_samples as f64;
        let chance = STANDARD_ERRORS * found.scatter() * cases.sqrt();
        assert!((stated_n.powi(2) - found.mean()).abs() <= chance, "{stated_n} N stated, {} N found", found.rms());
    }
}

/// The error on a network's card agrees with the estimator's error on samples of another seed.
#[test]
fn stated_errors_are_those_of_fresh_samples() {
    for (nodes, scaling) in [(&[19][..], Scaling::Principal), (&[16, 20], Scaling::Largest)] {
        let recipe = TrainingRecipe { scaling, ..tiny(nodes, 3000, 8, 10) };
        let network = trained(&recipe);
        let samples = fresh(&recipe.samples, 3000);
        for noise_mm in [0.0, CAMERA_NOISE_MM] {
            let displacements = noisy_shapes(&samples, noise_mm);
            assert_stated(&network, &squares(&samples, &sensed(&network, &samples, &displacements)), noise_mm);
        }
    }
}
