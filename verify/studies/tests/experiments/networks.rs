//! Tests the study of the shipped networks, which covers fifteen sets of contacts, including the sets of Table II.

use finray_model::Mesh;
use finray_model::estimators::network::Networks;
use finray_studies::check::Check;
use finray_studies::experiments::networks::accuracy::{CHECKED_SETS, NetworkStudy};
use finray_studies::sampling::scatter::{AgainstBound, Scatter, ScatterRow};
use finray_studies::settings::ENOUGH_CASES;
use finray_tests::{CAMERA_NOISE_MM, paper};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The study has checks only for the camera's noise, and each check can fail.
#[test]
fn networks_are_held_to_their_tolerances() {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that ship");
    let steps = AtomicUsize::new(0);
    let count = || {
        steps.fetch_add(1, Ordering::Relaxed);
    };
    let study = NetworkStudy::run(&mesh, &networks, CAMERA_NOISE_MM, 40, &count).expect("networks for all");
    assert_eq!((steps.into_inner(), study.rows.len()), (CHECKED_SETS.len(), CHECKED_SETS.len()));
    for (row, set) in study.rows.iter().zip(CHECKED_SETS) {
        assert_eq!((&row.nodes[..], row.cases), (set.nodes, 40));
    }
    let checks = study.checks();
    assert_eq!(checks.len(), 11 + 2 * 4);
    assert!(checks.iter().all(Check::passes), "{checks:?}");

    let other_noise = NetworkStudy { noise_mm: 0.1, ..study.clone() };
    assert!(other_noise.checks().is_empty());
    // With many cases, the tolerance has no allowance for sampling error; with few cases, it has one. The tolerance is the smaller of two values: the
    // set's fixed tolerance, and 1.1 times the error at the Cramer-Rao bound.
    let single = |cases: usize, mean_error: f64, bound: Option<f64>| {
        let bound = bound.map(|bound| AgainstBound { mean_error_bound: bound, ..AgainstBound::default() });
        let forces = vec![Scatter { mean_error, bound, ..Scatter::default() }];
        let row = ScatterRow { cases, forces, ..study.rows[0].clone() };
        study.checks_of(&row)[0].passes()
    };
    let (loose, tight) = (Some(0.1), Some(0.01));
    assert!(single(ENOUGH_CASES, 0.0159, loose) && !single(ENOUGH_CASES, 0.0161, loose));
    assert!(single(ENOUGH_CASES, 0.0109, tight) && !single(ENOUGH_CASES, 0.0111, tight));
    assert!(single(40, 0.024, loose) && !single(40, 0.025, loose));
    assert!(!single(ENOUGH_CASES, f64::NAN, loose) && !single(ENOUGH_CASES, 0.001, None));
}
