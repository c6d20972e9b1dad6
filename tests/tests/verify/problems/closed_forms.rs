//! Reference problems of the report: every one holds its tolerance.

use finray_tests::{assert_all_pass, finger_of, paper};
use finray_verify::check::{Check, Kind};
use finray_verify::problems::grid_convergence::GridConvergence;
use finray_verify::problems::{
    elastica, energy_balance, full_circle, grid_convergence, lee_frame, opensees, refinement, rigid_rotation, tangent,
    toggle,
};

#[test]
fn elastica_rows() {
    let checks = elastica::checks().expect("every load has an equilibrium");
    // Eleven loads, three quantities each.
    assert_eq!(checks.len(), 33);
    assert_all_pass(&checks);
}

#[test]
fn end_moment_bends_into_a_circle() {
    assert_all_pass(&full_circle::checks().expect("the moment is carried"));
}

#[test]
fn lee_frame_limit_loads() {
    let checks = lee_frame::checks().expect("the path is followed");
    // Limits in number, the first by the literature, both by shooting; stability.
    assert_eq!(checks.len(), 5);
    assert_all_pass(&checks);
}

#[test]
fn toggle_limit_loads() {
    let checks = toggle::checks().expect("the path is followed");
    assert_eq!(checks.len(), 3);
    assert_all_pass(&checks);
}

#[test]
fn rigid_rotation_leaves_no_forces() {
    for scene in [
        finray_fixtures::PAPER_SCENE,
        finray_fixtures::SPRING_STEEL_SCENE,
        finray_fixtures::ARMS_SCENE,
        finray_fixtures::ASYMMETRIC_SCENE,
        finray_fixtures::HINGED_SCENE,
    ] {
        assert_all_pass(&rigid_rotation::checks(&finger_of(scene)));
    }
}

#[test]
fn derivatives_are_those_of_the_energy() {
    assert_all_pass(&tangent::checks(&paper()).expect("the loads are on the finger"));
}

#[test]
fn energy_is_the_work_of_the_load() {
    assert_all_pass(&energy_balance::checks(&paper()).expect("3 N are carried"));
}

#[test]
fn order_of_convergence() {
    assert_all_pass(&grid_convergence::checks(&paper()).expect("3 N are carried"));
}

/// The first example of the procedure's authors (Celik et al. 2008, table 1), printed to two to four digits, and a made-up
/// solution 1 + h^3 on meshes of unequal ratio.
#[test]
fn grid_convergence_index_of_known_cases() {
    let cells = [4500, 8000, 18000];
    let example = GridConvergence::of(cells, cells.map(|n| (n as f64).powf(-0.5)), [5.863, 5.972, 6.063]);
    assert!((example.order - 1.53).abs() < 0.01, "{example:?}");
    assert!((example.extrapolated - 6.1685).abs() < 1e-3, "{example:?}");
    assert!((example.index - 0.022).abs() < 5e-4, "{example:?}");
    let sizes = [0.4, 0.25, 0.1];
    let made_up = GridConvergence::of([0; 3], sizes, sizes.map(|h: f64| 1.0 + h.powi(3)));
    assert!((made_up.order - 3.0).abs() < 1e-9 && (made_up.extrapolated - 1.0).abs() < 1e-12, "{made_up:?}");
}

#[test]
fn opensees_rows() {
    assert_all_pass(&opensees::paper_checks(&paper()).expect("every case is solved"));
}

#[test]
fn meshes_of_25_and_684_nodes() {
    assert_all_pass(&refinement::checks(&paper()).expect("both meshes are solved"));
}

/// A check whose figure is not a number fails; one outside its tolerance fails.
#[test]
fn checks_can_fail() {
    assert!(Check::new(Kind::Internal, "", "", "", 1.0, 1.1, 0.1 + 1e-12).passes());
    assert!(!Check::new(Kind::Internal, "", "", "", 1.0, 1.2, 0.1).passes());
    assert!(!Check::new(Kind::Internal, "", "", "", 1.0, f64::NAN, 0.1).passes());
    assert!(!Check::new(Kind::Internal, "", "", "", 1.0, f64::INFINITY, f64::MAX).passes());
}
