//! Checks of sensing under noise include every drawn case.

use finray_model::estimators::EstimatorId;
use finray_studies::check::Check;
use finray_studies::experiments::noise::{CHECKED_NODES, CHECKED_PAIRS, NoiseStudy};
use finray_studies::sampling::scatter::{AgainstBound, Controlled, Scatter, ScatterRow};
use finray_studies::settings::CAMERA_NOISE_MM;

fn row(nodes: &[usize], mean_error: f64, [cases, refused]: [usize; 2]) -> ScatterRow {
    let bound = AgainstBound {
        mean_error_bound: 0.01,
        over_bound: 1.0,
        bias_over_bound: 0.0,
        controlled: Some(Controlled { over_bound_controlled: 1.05, standard_error: 0.01 }),
    };
    let scatter = Scatter { mean_error, mean_error_n: 0.0, bound: Some(bound), coverage: None };
    ScatterRow {
        estimator: EstimatorId::Nonlinear,
        nodes: nodes.to_vec(),
        noise_mm: CAMERA_NOISE_MM,
        cases,
        not_carried: 0,
        refused,
        forces: vec![scatter; nodes.len()],
        sum: Some(scatter),
    }
}

fn study(counts: [usize; 2]) -> NoiseStudy {
    NoiseStudy {
        noise_mm: CAMERA_NOISE_MM,
        single: CHECKED_NODES.map(|node| row(&[node], 0.01, counts)).collect(),
        pairs: vec![row(&[14, 15], 0.01, counts)],
        linear_pairs: Vec::new(),
        condition_numbers: vec![1.0],
        checked: CHECKED_PAIRS.map(|(nodes, _)| row(&nodes, 0.01, counts)).into(),
    }
}

fn failed(study: &NoiseStudy) -> usize {
    study.checks().iter().filter(|check| !Check::passes(check)).count()
}

#[test]
fn refused_cases_neither_remove_a_check_nor_loosen_it() {
    let answered = study([2000, 0]);
    assert_eq!((answered.checks().len(), failed(&answered)), (11 + 1 + 8 + 2, 0));
    // The test runs with one refused case in two thousand, and with nearly all cases refused. For both numbers of refused cases, every check exists
    // with the same tolerance, and fails.
    for counts in [[1999, 1], [10, 1990]] {
        let refused = study(counts);
        assert_eq!(failed(&refused), answered.checks().len());
        for (ours, theirs) in refused.checks().iter().zip(answered.checks()) {
            assert_eq!(ours.tolerance, theirs.tolerance);
            assert!(ours.quantity.contains("2000 cases drawn") || ours.quantity.contains("22000 cases drawn"));
        }
    }
}

#[test]
fn a_node_whose_forces_are_not_carried_fails() {
    let mut study = study([2000, 0]);
    study.single[3] = ScatterRow { forces: Vec::new(), sum: None, ..row(&[17], 0.01, [0, 0]) };
    assert_eq!(failed(&study), 2);
    study.single.remove(3);
    assert_eq!(failed(&study), 2);
}

#[test]
fn every_pair_is_held_to_ten_per_cent_of_the_bound() {
    let mut study = study([2000, 0]);
    let bound = study.pairs[0].forces[1].bound.as_mut().expect("there is noise");
    bound.controlled = Some(Controlled { over_bound_controlled: 1.11, standard_error: 0.01 });
    assert_eq!(failed(&study), 1);
    let bound = study.pairs[0].forces[1].bound.as_mut().expect("there is noise");
    bound.controlled = Some(Controlled { over_bound_controlled: 1.0, standard_error: 0.03 });
    assert_eq!(failed(&study), 1);
    study.pairs[0].forces.pop();
    assert_eq!(failed(&study), 2);
}
