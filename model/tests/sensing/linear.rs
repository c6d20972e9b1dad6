//! Linear sensing: forces are recovered from displacements of the linear finger.

use finray_model::compliance::{Compliance, NodalCompliance};
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::{
    Contact, ContactPosition, Estimate, ForcePrior, LinearEstimator, Linearisation, SensingError, Warning,
};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId};
use finray_tests::{
    CAMERA_NOISE_MM, at_node, at_position, built_finger_with_zones, cases, contact_node, noisy, paper, seen,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// Largest error of forces sensed from noise-free data of the same model, as a share of the largest force.
const EXACT: f64 = 1e-9;
/// Rounding error between two solutions of the same finger. Thin plates stretch up to 1e5 times less than they bend, and a chain of plates multiplies
/// the condition number of the stiffness by another 1e4.
const SOLUTION_ROUNDING: f64 = 1e-6;

fn measured(finger: &Finger, contacts: &[Contact], forces_n: &[f64]) -> Measurement {
    seen(&Mesh::key_nodes(finger), contacts, forces_n, Kinematics::Linear).expect("linear solution")
}

fn sense(
    finger: &Finger,
    contacts: &[Contact],
    m: &Measurement,
    noise_mm: Option<f64>,
) -> Result<Estimate, SensingError> {
    Ok(LinearEstimator::new(finger, contacts, m)?.estimate(m, noise_mm, ForcePrior::None))
}

proptest! {
    #![proptest_config(cases(128))]

    /// On any finger, a combination of forces and moments on key nodes has the same effect as a load at any position, on a node or on an arm.
    #[test]
    fn a_finger_solved_once_serves_every_load(
        finger in built_finger_with_zones(),
        at in prop::collection::vec((0.001..=1.0, -80.0..80.0), 1..=4),
    ) {
        let mut contacts: Vec<Contact> = at
            .iter()
            .map(|&(s, angle_deg)| at_position(s * finger.description().front_length_mm, angle_deg))
            .collect();
        contacts[0].position = ContactPosition::Node(contact_node(&finger, at[0].0));
        let loads: Vec<Load> = contacts.iter().map(|contact| contact.unit_load(&finger)).collect();
        let (ours, theirs) = (NodalCompliance::new(&finger).columns(&loads), Compliance::new(&finger, &loads));
        let (ours, theirs) = (ours.expect("a solution"), theirs.expect("a solution"));
        for load in 0..loads.len() {
            let largest = finger.free_nodes().map(|node| theirs.displacement(node, load).norm()).fold(0.0, f64::max);
            for node in finger.free_nodes() {
                let apart = (ours.displacement(node, load) - theirs.displacement(node, load)).norm();
                prop_assert!(apart <= SOLUTION_ROUNDING * largest, "{contacts:?}: {apart} of {largest} mm");
            }
        }
    }

    /// On any finger, up to three forces at nodes or between nodes, in any direction, are recovered. Markers may be hidden.
    #[test]
    fn applied_forces_come_back(
        finger in built_finger_with_zones(),
        at in prop::collection::vec((0.1..1.0, -80.0..80.0, -5.0..5.0), 1..=3),
        hidden in 0.0..1.0,
    ) {
        let mut contacts: Vec<Contact> = at
            .iter()
            .map(|&(s, angle_deg, _)| at_position(s * finger.description().front_length_mm, angle_deg))
            .collect();
        contacts[0].position = ContactPosition::Node(contact_node(&finger, at[0].0));
        let forces: Vec<f64> = at.iter().map(|c| c.2).collect();
        let all = measured(&finger, &contacts, &forces);
        let hide: Vec<NodeId> = finger.free_nodes().filter(|n| ((n.0 as f64 * 0.618).fract()) < 0.4 * hidden).collect();
        let seen = all.without(&hide);
        let largest = forces.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        match sense(&finger, &contacts, &seen, None) {
            Ok(estimate) => {
                // The ratio of the largest to the smallest singular value bounds the effect of rounding errors in the displacements.
                let values = &estimate.singular_values;
                let span = values[0] / values[values.len() - 1];
                for (sensed, applied) in estimate.forces_n.iter().zip(&forces) {
                    prop_assert!((sensed - applied).abs() <= EXACT * largest * (span / 1e4).max(1.0), "{sensed} against {applied}, span {span:e}");
                }
            }
            // Close contacts on a stiff rib are not identifiable from few markers, so they are refused.
            Err(error) => prop_assert!(
                matches!(error, SensingError::TooFewMarkers { .. } | SensingError::IllConditioned { .. }),
                "{error}"
            ),
        }
    }
}

/// For three contacts, the stated standard deviation of each force equals the scatter of its estimates from 4000 noise samples. The sample standard
/// deviation itself has an uncertainty of 1.1 % (one sigma).
#[test]
fn stated_sigma_is_the_scatter() {
    let finger = paper();
    let contacts = [at_node(16, -20.0), at_node(19, 0.0), at_node(24, 30.0)];
    let forces = [1.0, 2.0, 0.5];
    // Half of the markers are twice as accurate as the other half.
    let markers = measured(&finger, &contacts, &forces).markers().to_vec();
    let weighted = markers.into_iter().map(|m| Marker { weight: if m.node.0 % 2 == 0 { 2.0 } else { 1.0 }, ..m });
    let clean = Measurement::new(&finger, weighted).expect("the same markers");
    let (noise_mm, count) = (CAMERA_NOISE_MM, 4000);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut sums = [[0.0; 3]; 2];
    let mut estimated_noise = 0.0;
    let estimator = LinearEstimator::new(&finger, &contacts, &clean).expect("well-posed");
    let mut sigmas = Vec::new();
    for _ in 0..count {
        let noisy = noisy(&clean, noise_mm, &mut rng);
        let known = estimator.estimate(&noisy, Some(noise_mm), ForcePrior::None);
        for i in 0..3 {
            let error = known.forces_n[i] - forces[i];
            sums[0][i] += error;
            sums[1][i] += error * error;
        }
        sigmas = known.sigmas_n;
        estimated_noise += estimator.estimate(&noisy, None, ForcePrior::None).trusted_noise_mm.powi(2);
    }
    for i in 0..3 {
        let scatter = (sums[1][i] / f64::from(count)).sqrt();
        // The tolerance is four standard errors of a standard deviation from 4000 samples: 4 / sqrt(2 * 4000).
        assert!((scatter / sigmas[i] - 1.0).abs() < 0.045, "contact {i}: scatter {scatter}, stated {}", sigmas[i]);
        assert!(
            (sums[0][i] / f64::from(count)).abs() < 4.0 * sigmas[i] / f64::from(count).sqrt(),
            "contact {i} is biased"
        );
    }
    // Without a stated noise, Student's t widens the standard deviation by a factor of 2.0167 / 1.9600. This factor is for 43 degrees of freedom: 46
    // coordinates less three forces.
    let estimated = (estimated_noise / f64::from(count)).sqrt() * 1.959_96 / 2.0167;
    assert!((estimated / noise_mm - 1.0).abs() < 0.01, "noise from residuals: {estimated}");
}

/// Standard deviations that other programs computed for 0.067 mm noise on the paper's finger: 0.011 N at node 14, 0.004 N at node 19, 0.023 N at node
/// 24, and 0.035 N for each of two neighbouring contacts.
#[test]
fn sigmas_on_the_papers_finger() {
    let finger = paper();
    let sigma = |contacts: &[Contact]| {
        let m = measured(&finger, contacts, &vec![1.0; contacts.len()]);
        sense(&finger, contacts, &m, Some(CAMERA_NOISE_MM)).expect("well-posed").sigmas_n
    };
    for (node, known) in [(14, 0.011), (19, 0.004), (24, 0.023)] {
        let ours = sigma(&[at_node(node, 0.0)])[0];
        assert!((ours - known).abs() < 0.0005 + 0.01 * known, "node {node}: {ours} against {known}");
    }
    for ours in sigma(&[at_node(19, 0.0), at_node(20, 0.0)]) {
        assert!((ours - 0.035).abs() < 0.002, "neighbours: {ours}");
    }
}

/// For twelve simultaneous normal forces, the largest singular value is 363 times the smallest, as an independent study also found.
#[test]
fn twelve_normal_forces_span_363() {
    let finger = paper();
    let contacts: Vec<Contact> = (13..=24).map(|node| at_node(node, 0.0)).collect();
    let estimate = sense(&finger, &contacts, &measured(&finger, &contacts, &[0.5; 12]), None).expect("well-posed");
    let span = estimate.singular_values[0] / estimate.singular_values[11];
    assert!((span - 363.0).abs() < 0.5, "{span}");
}

/// Questions without a unique answer are refused with the reason.
#[test]
fn ill_posed_questions_are_refused() {
    let finger = paper();
    let m = measured(&finger, &[at_node(19, 0.0)], &[1.0]);
    let refused = |contacts: &[Contact], m: &Measurement| sense(&finger, contacts, m, None).expect_err("ill-posed");
    assert!(matches!(refused(&[], &m), SensingError::NoContact));
    assert!(matches!(refused(&[at_node(19, 5.0), at_node(19, 5.0)], &m), SensingError::SameContact { .. }));
    let same_position = at_position(76.5, 5.0);
    assert!(matches!(refused(&[at_node(19, 5.0), same_position], &m), SensingError::SameContact { .. }));
    assert!(matches!(refused(&[at_node(7, 0.0)], &m), SensingError::NotAContactNode { .. }));
    assert!(matches!(refused(&[at_node(25, 0.0)], &m), SensingError::Load(_)));
    assert!(matches!(refused(&[at_node(26, 0.0)], &m), SensingError::Load(_)));
    assert!(matches!(refused(&[at_node(19, f64::NAN)], &m), SensingError::AngleNotFinite { .. }));
    // Forces in three directions at one node are three unknowns, but their sum has only two components.
    let three = [at_node(19, 0.0), at_node(19, 40.0), at_node(19, 80.0)];
    assert!(matches!(refused(&three, &m), SensingError::IllConditioned { .. }));
    // Opposite directions are one unknown.
    assert!(matches!(refused(&[at_node(19, 0.0), at_node(19, 180.0)], &m), SensingError::IllConditioned { .. }));
    let one_marker = m.clone().without(&finger.free_nodes().filter(|n| n.0 != 18).collect::<Vec<_>>());
    let contacts = [at_node(16, 0.0), at_node(18, 0.0), at_node(20, 0.0)];
    assert!(matches!(refused(&contacts, &one_marker), SensingError::TooFewMarkers { unknowns: 3, coordinates: 2 }));
    // Two forces in different directions at one node are identifiable.
    assert!(sense(&finger, &[at_node(19, 0.0), at_node(19, 90.0)], &m, None).is_ok());
}

/// With noise s and prior standard deviation p, ridge regression returns the mean of the posterior, (C^T C + s^2 / p^2)^-1 C^T u, and its standard
/// deviation.
#[test]
fn ridge_is_the_posterior_of_its_prior() {
    let finger = paper();
    let contacts = [at_node(19, 0.0), at_node(20, 0.0)];
    let m = measured(&finger, &contacts, &[2.0, -1.0]);
    let (noise_mm, force_n) = (0.4, 1.5);
    let estimator = LinearEstimator::new(&finger, &contacts, &m).expect("well-posed");
    let ours = estimator.estimate(&m, Some(noise_mm), ForcePrior::Gaussian { force_n });
    let unit: Vec<Measurement> = [[1.0, 0.0], [0.0, 1.0]].iter().map(|f| measured(&finger, &contacts, f)).collect();
    let column =
        |m: &Measurement| m.markers().iter().flat_map(|m| [m.displacement.x, m.displacement.y]).collect::<Vec<_>>();
    let (c, u) = ([column(&unit[0]), column(&unit[1])], column(&m));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let ridge = (noise_mm / force_n).powi(2);
    let normal = nalgebra::Matrix2::from_fn(|i, j| dot(&c[i], &c[j]) + if i == j { ridge } else { 0.0 });
    let inverse = normal.try_inverse().expect("positive definite");
    let forces = inverse * nalgebra::Vector2::new(dot(&c[0], &u), dot(&c[1], &u));
    for i in 0..2 {
        assert!((ours.forces_n[i] - forces[i]).abs() < 1e-9, "{:?} against {forces}", ours.forces_n);
        assert!((ours.sigmas_n[i] - noise_mm * inverse[(i, i)].sqrt()).abs() < 1e-9);
    }
    // Ridge regression shrinks the combination of the two neighbouring forces that the markers hardly determine.
    assert!(ours.forces_n[0] < 2.0 && ours.forces_n[1] > -1.0);
}

/// A noise that is estimated from the residual is rounded within the ridge, but not within the standard deviation. The rounding changes the ridge, and
/// thus the shrinkage of a force in the ratio s^2 / p^2, by at most 4.4 %.
#[test]
fn a_ridge_of_estimated_noise_is_rounded() {
    let finger = paper();
    let contacts = [at_node(19, 0.0)];
    let clean = measured(&finger, &contacts, &[2.0]);
    let estimator = LinearEstimator::new(&finger, &contacts, &clean).expect("well-posed");
    let prior_n = 0.02;
    let mut ridges = std::collections::BTreeSet::new();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..50 {
        let m = noisy(&clean, CAMERA_NOISE_MM, &mut rng);
        let unbiased = estimator.estimate(&m, None, ForcePrior::None);
        let ridge = estimator.estimate(&m, None, ForcePrior::Gaussian { force_n: prior_n });
        let length = estimator.singular_values()[0];
        let shrinkage = unbiased.forces_n[0] / ridge.forces_n[0] - 1.0;
        let expected = (unbiased.trusted_noise_mm / prior_n / length).powi(2);
        assert!((shrinkage / expected - 1.0).abs() < 0.045, "{shrinkage} for {expected}");
        assert_eq!(ridge.trusted_noise_mm, unbiased.trusted_noise_mm);
        ridges.insert((shrinkage * 1e9).round() as i64);
    }
    // The estimates of the noise scatter by 10 %, so their ridges have some ten values.
    assert!((3..20).contains(&ridges.len()), "{} ridges", ridges.len());
}

/// A finger that bends linearly has an equilibrium under any force. If the linear finger explains the measurement but the co-rotational finger has no
/// equilibrium, the estimator returns forces with a warning. Shapes of the co-rotational finger that the linear finger does not explain are refused.
#[test]
fn exact_linear_data_are_not_refused_where_the_corotational_finger_is_lost() {
    let finger = paper();
    let reference = Arc::new(Mesh::with_elements_per_member(&finger, 4));
    let answer = |contacts: &[Contact], measurement: &Measurement, noise_mm: Option<f64>| {
        let estimator = LinearEstimator::new(&finger, contacts, measurement).expect("identifiable");
        estimator.estimate_on(
            &mut Linearisation::new(reference.clone(), contacts),
            measurement,
            noise_mm,
            ForcePrior::None,
        )
    };
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for (node, forces_n) in [(19, [20.0, -0.1]), (16, [29.0, 6.0]), (24, [60.0, 12.0]), (14, [-15.0, 3.0])] {
        let contacts = [at_node(node, 0.0), at_node(node, 90.0)];
        let exact = measured(&finger, &contacts, &forces_n);
        let noisy = noisy(&exact, CAMERA_NOISE_MM, &mut rng);
        for (measurement, noise_mm) in [(&exact, None), (&noisy, None), (&noisy, Some(CAMERA_NOISE_MM))] {
            let estimate = answer(&contacts, measurement, noise_mm).expect("an answer");
            assert_eq!(estimate.warning, Some(Warning::UnknownLinearisation), "{node}");
            for (k, truth_n) in forces_n.iter().enumerate() {
                let tolerance_n = EXACT * forces_n[0].abs() + 4.0 * estimate.sigmas_n[k];
                assert!((estimate.forces_n[k] - truth_n).abs() < tolerance_n, "{node}: {estimate:?}");
            }
        }
    }
    let contacts = [at_node(22, 0.0), at_node(22, 90.0)];
    let bent = seen(&reference, &contacts[..1], &[8.0], Kinematics::Corotational).expect("an equilibrium");
    assert_eq!(answer(&contacts, &bent, None).err(), Some(SensingError::NotLinearised));
    assert_eq!(answer(&contacts, &bent, Some(CAMERA_NOISE_MM)).err(), Some(SensingError::NotLinearised));
}

/// Far beyond the linear range, neither finger explains the measurement, although the co-rotational finger may fit better than the linear finger. If
/// neither the linear nor the co-rotational finger explains the measurement, the interval is as wide as for a wrong model.
#[test]
fn the_interval_holds_if_neither_finger_explains_the_measurement() {
    let finger = paper();
    let reference = Arc::new(Mesh::with_elements_per_member(&finger, 4));
    for (s_mm, force_n) in [(38.0, 20.0), (30.0, 25.0), (45.0, 18.0)] {
        let contacts = [at_position(s_mm, 0.0)];
        let bent = seen(&reference, &contacts, &[force_n], Kinematics::Corotational).expect("an equilibrium");
        let estimator = LinearEstimator::new(&finger, &contacts, &bent).expect("identifiable");
        for prior in [ForcePrior::None, ForcePrior::Gaussian { force_n: 2.0 }] {
            let mut linearisation = Linearisation::new(reference.clone(), &contacts);
            let estimate = estimator.estimate_on(&mut linearisation, &bent, Some(CAMERA_NOISE_MM), prior);
            let Estimate { forces_n, sigmas_n, warning, .. } = estimate.expect("an answer");
            let error_n = forces_n[0] - force_n;
            assert!(matches!(warning, Some(Warning::Residual(_))), "{s_mm} mm, {force_n} N: {warning:?}");
            assert!(error_n.abs() < 1.96 * sigmas_n[0], "{s_mm} mm: {force_n} N, error {error_n} +- {} N", sigmas_n[0]);
        }
    }
}
