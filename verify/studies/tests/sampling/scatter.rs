//! Comparison of estimators on the same random cases.

use finray_model::estimators::EstimatorId::{self, LeastSquares, Network, Nonlinear, Ridge};
use finray_model::estimators::network::Networks;
use finray_model::sensor::SensorOptions;
use finray_model::{Kinematics, Mesh, NodeId, Scene};
use finray_studies::sampling::scatter::{Counts, Scatter, ScatterRequest, ScatterRow, scatter};
use finray_studies::settings::TWO_FORCES_N;
use finray_tests::{CAMERA_NOISE_MM, paper};

/// Number of cases for each set of contacts.
pub const CASES: usize = 100;
/// Relative allowance for sampling error in a mean error: three standard errors, which about one mean in four hundred exceeds. The relative errors
/// have a standard deviation of 1.1 times their mean, so the relative standard error over [`CASES`] cases is about a tenth.
pub const CHANCE: f64 = 0.33;
/// Tolerance for nonlinear sensing without noise on the mesh of the true finger. The iteration stops at some millionths.
const SAME_FINGER: f64 = 1e-5;

/// Rows for one set of contact nodes. The true finger has a mesh of 25 nodes.
fn rows(estimators: &[EstimatorId], kinematics: Kinematics, levels: &[f64], nodes: &[usize]) -> Vec<ScatterRow> {
    let sensors: Vec<_> = estimators.iter().map(|&estimator| SensorOptions::of(estimator)).collect();
    rows_of(&sensors, kinematics, levels, nodes, TWO_FORCES_N)
}

fn rows_of(
    sensors: &[SensorOptions],
    kinematics: Kinematics,
    levels: &[f64],
    nodes: &[usize],
    range_n: [f64; 2],
) -> Vec<ScatterRow> {
    let mesh = Mesh::key_nodes(&paper());
    let request = ScatterRequest {
        truth: &mesh,
        kinematics,
        model: &mesh,
        scene: &Scene::of_finger(paper()).into(),
        noise_levels_mm: levels,
        cases: CASES,
        seed: 5,
    };
    let set: Vec<NodeId> = nodes.iter().map(|&node| NodeId(node)).collect();
    scatter(&request, sensors, &[set], range_n, &|| {}).expect("contact nodes")
}

/// The results of an estimator do not depend on other estimators and noise levels in the same run.
#[test]
fn estimators_see_the_same_cases() {
    let nodes = [19, 20];
    for kinematics in [Kinematics::Linear, Kinematics::Corotational] {
        let together = rows(&[Ridge, LeastSquares], kinematics, &[0.0, CAMERA_NOISE_MM], &nodes);
        let alone = rows(&[LeastSquares], kinematics, &[CAMERA_NOISE_MM], &nodes);
        assert_eq!(together.len(), 4);
        assert_eq!(together[3], alone[0]);
        // The number of forces without equilibrium depends on the finger, and not on the estimator.
        assert_eq!(together[0].not_carried, together[3].not_carried);
    }
    // The nonlinear estimator reaches the bound on the co-rotational finger, and the bound is the same for all estimators.
    let found = rows(&[LeastSquares, Nonlinear], Kinematics::Corotational, &[CAMERA_NOISE_MM], &nodes);
    assert_eq!(found[0].mean_error_bound(), found[1].mean_error_bound());
    let reaches = |row: &ScatterRow| {
        let bound = row.mean_error_bound().expect("there is noise");
        assert!((row.mean_error().expect("sensed") / bound - 1.0).abs() < CHANCE, "{row:?}");
    };
    reaches(&found[1]);
    reaches(&rows(&[LeastSquares], Kinematics::Linear, &[CAMERA_NOISE_MM], &nodes)[0]);
}

/// Without noise, there is neither bound nor coverage. Undefined figures are `None`, because JSON has no NaN. A network refuses every force far above
/// those of its training.
#[test]
fn what_makes_no_sense_is_left_out() {
    let found = rows(&[LeastSquares], Kinematics::Linear, &[0.0, CAMERA_NOISE_MM], &[18, 20]);
    let [without, with] = &found[..] else { panic!("{found:?}") };
    assert_eq!((without.cases, without.refused), (CASES, 0));
    for scatter in without.forces.iter().chain(&without.sum) {
        assert!(scatter.bound.is_none() && scatter.coverage.is_none());
    }
    for scatter in with.forces.iter().chain(&with.sum) {
        assert!(scatter.bound.is_some_and(|bound| bound.over_bound > 0.5) && scatter.coverage.is_some());
    }
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that ship");
    let network = SensorOptions { networks, ..SensorOptions::of(Network) };
    let refused = &rows_of(&[network], Kinematics::Linear, &[CAMERA_NOISE_MM], &[18, 20], [50.0, 60.0])[0];
    assert_eq!((refused.cases, refused.refused, refused.mean_error()), (0, CASES, None));
    assert!(refused.forces.is_empty() && refused.sum.is_none());
}

/// The stated standard deviation of a sum has its nominal coverage, although errors of neighbouring forces are anticorrelated. A strong prior makes
/// the standard deviation smaller.
#[test]
fn the_sigma_of_a_sum_knows_of_the_correlation() {
    let found = rows(&[LeastSquares, Ridge], Kinematics::Linear, &[CAMERA_NOISE_MM], &[19, 20]);
    for row in &found {
        let covered = row.sum.and_then(|sum| sum.coverage).expect("stated");
        // The tolerances 0.19 and 0.09 are four standard errors of each share over a hundred cases.
        assert!((covered.one_sigma - 0.683).abs() < 0.19 && (covered.two_sigma - 0.95).abs() < 0.09, "{row:?}");
    }
}

/// Each sampled shape is the equilibrium under its own forces, whichever path led to it. A nonlinear estimator with the true finger's mesh therefore
/// has only the convergence errors of two Newton iterations: its own and that of the true shape.
#[test]
fn samples_are_those_of_the_forces() {
    let nonlinear = SensorOptions { mesh_nodes: Some(25), ..SensorOptions::of(Nonlinear) };
    for nodes in [&[24][..], &[19, 20], &[14, 23]] {
        let row = &rows_of(std::slice::from_ref(&nonlinear), Kinematics::Corotational, &[0.0], nodes, TWO_FORCES_N)[0];
        assert_eq!((row.cases, row.refused), (CASES, 0));
        assert!(row.mean_error().expect("sensed") < SAME_FINGER, "{row:?}");
    }
}

#[test]
fn a_refused_case_counts_as_an_error_of_the_whole_force() {
    let row = |cases: usize, refused: usize| ScatterRow {
        estimator: EstimatorId::Nonlinear,
        nodes: vec![19],
        noise_mm: 0.067,
        cases,
        not_carried: 0,
        refused,
        forces: vec![Scatter { mean_error: 0.01, ..Scatter::default() }],
        sum: None,
    };
    assert!(row(100, 0).is_within(0.10) && row(95, 5).is_within(0.10));
    assert!(!row(90, 10).is_within(0.10) && !row(1, 99).is_within(0.10));
    let counts = Counts::of(&[row(90, 10), row(100, 0)]);
    assert_eq!(counts.to_string(), "200 cases, 10 refused");
}
