//! The checks of each reference problem of the report pass.

use crate::check::assert_all_pass;
use finray_model::Scene;
use finray_studies::check::{Check, Kind};
use finray_studies::problems::grid_convergence::GridConvergence;
use finray_studies::problems::{self, elastica, gripper_camera, lee_frame, linkage, rigid_rotation, toggle};
use finray_studies::settings::ReportForces;
use finray_tests::{finger_of, paper};

/// Every problem that applies to the paper's finger can be solved, and its checks pass.
#[test]
fn every_problem_passes_its_checks() {
    let finger = paper();
    let applying = problems::ALL.iter().filter(|problem| (problem.applies_to)(&finger));
    let mut solved = 0;
    for problem in applying {
        let checks = (problem.solve)(&finger, ReportForces::PAPER)
            .unwrap_or_else(|error| panic!("{}: {error}", problem.name))
            .checks;
        assert_all_pass(&checks);
        solved += 1;
    }
    assert_eq!(solved, problems::ALL.len());
}

#[test]
fn elastica_rows() {
    let checks = elastica::checks().expect("every load has an equilibrium");
    // One check for each quantity, over eleven loads.
    assert_eq!(checks.len(), 3);
    assert_all_pass(&checks);
}

#[test]
fn lee_frame_limit_loads() {
    let checks = lee_frame::checks().expect("the path is followed");
    // Five checks: number of limit loads, first limit load against literature, both limit loads against shooting, and stability.
    assert_eq!(checks.len(), 5);
    assert_all_pass(&checks);
}

#[test]
fn toggle_limit_loads() {
    let checks = toggle::checks().expect("the path is followed");
    assert_eq!(checks.len(), 3);
    assert_all_pass(&checks);
}

/// Uses another linkage than the report: the linkage of the wedge scene, whose fixed joint is farther from the screw's axis.
#[test]
fn gripper_rows() {
    let wedge = include_str!("../../../../fixtures/scenes/grasp/wedge.toml");
    let Scene { finger, gripper, .. } = Scene::from_toml(wedge).expect("the scene reads");
    let gripper = gripper.expect("it has a gripper");
    let (of_linkage, of_camera) = (linkage::checks(&finger, &gripper), gripper_camera::checks(&finger, &gripper));
    let of_camera = of_camera.expect("the lens is one");
    // Checks of the linkage: closed loop, frames of both fingers, derivative of the opening, and inverse of the opening. Checks of the camera: frames
    // of both fingers in the camera's frame, and undeformed nodes in the camera's images.
    assert_eq!([of_linkage.len(), of_camera.len()], [4, 2]);
    assert_all_pass(&of_linkage);
    assert_all_pass(&of_camera);
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

/// Tests two known cases: the first example of Celik et al. (2008, table 1), printed with two to four digits, and the invented solution `1 + h^3` on
/// meshes with unequal ratios.
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

/// A check fails if its figure is outside the tolerance or not a number.
#[test]
fn checks_can_fail() {
    assert!(Check::new(Kind::Internal, "", "", "", 1.0, 1.1, 0.1 + 1e-12).passes());
    assert!(!Check::new(Kind::Internal, "", "", "", 1.0, 1.2, 0.1).passes());
    assert!(!Check::new(Kind::Internal, "", "", "", 1.0, f64::NAN, 0.1).passes());
    assert!(!Check::new(Kind::Internal, "", "", "", 1.0, f64::INFINITY, f64::MAX).passes());
}
