//! Tests of settling: the lattice comes to rest at the minimum of its energy, and close to the equilibrium of beams.

use finray_lattice::settling::Settling;
use finray_lattice::{Lattice, LatticeError, settling};
use finray_model::mesh::Load;
use finray_model::{Kinematics, Mesh, NodeId, Vector, statics};
use finray_tests::{contact_node, finger_of, paper, paper_scene_with, shapes_apart};

/// Tolerance between the settled lattice and its equilibrium, as a share of the largest displacement.
const SETTLING_TOLERANCE: f64 = 5e-4;

fn with_shear(scene: &str) -> String {
    scene.replacen("[finger]\n", "[finger]\nshear_correction = 0.8\n", 1)
}

/// Ribs with shorter arms, and longer arms at the clamp.
fn with_other_arms(scene: &str) -> String {
    scene.replacen("[finger]\n", "[finger]\nrib_arm_mm = 0.3\nclamp_arm_mm = 3.0\n", 1)
}

/// Lattices with arms, zones, hinges, undeformable ribs or shear deformation settle at the minimum of their energy, which agrees with beams.
#[test]
fn other_fingers_settle_where_beams_are() {
    for (text, force_n, tolerance) in [
        (finray_fixtures::SPRING_STEEL_SCENE, 1.0, 2e-4),
        (finray_fixtures::ARMS_SCENE, 1.0, 1e-3),
        (finray_fixtures::ASYMMETRIC_SCENE, 0.3, 3e-3),
        (finray_fixtures::HINGED_SCENE, 1.0, 1e-3),
        (finray_fixtures::HINGED_RIGID_SCENE, 1.0, 1e-3),
        (finray_fixtures::RIGID_RIBS_SCENE, 0.5, 2e-3),
        (&with_other_arms(finray_fixtures::ARMS_SCENE), 1.0, 1e-3),
        (&with_shear(finray_fixtures::ARMS_SCENE), 1.0, 1e-3),
        (&with_shear(finray_fixtures::HINGED_SCENE), 1.0, 1e-3),
    ] {
        let finger = finger_of(text);
        let lattice = Lattice::new(&finger, 2).expect("a lattice");
        let load = Load::at_node(contact_node(&finger, 0.5), finger.direction(20.0) * force_n);
        let settled = lattice.settle(&[load]).expect("it settles");
        let equilibrium = lattice.equilibrium(&[load]).expect("an equilibrium");
        assert!(settled.residual <= settling::AT_REST);
        assert!(shapes_apart(&settled.shape, &equilibrium) < SETTLING_TOLERANCE);
        let beams = Mesh::with_elements_per_member(&finger, 16);
        let beams = statics::solve(&beams, &[load], Kinematics::Corotational).expect("an equilibrium");
        let error = shapes_apart(&settled.shape, &beams);
        assert!(error < tolerance, "{error}: {text}");
    }
}

/// The key nodes of ribs that share a junction form one body, even if the junction is in a corner of the base.
#[test]
fn a_zigzag_of_ribs_settles_where_beams_are() {
    let zigzag =
        "positions_mm = [[30.0, 0.0], [30.0, 50.0], [70.0, 50.0], [70.0, 90.0], [110.0, 90.0], [110.0, 130.0]]";
    let finger = paper_scene_with(&[("count = 11", zigzag)]).finger;
    let lattice = Lattice::new(&finger, 4).expect("a lattice");
    let beams = Mesh::with_elements_per_member(&finger, 16);
    for load in [
        Load::at_node(finger.rib_nodes(4)[0], finger.direction(20.0)),
        Load::at_position(90.0, finger.direction(0.0) * 0.5),
    ] {
        let settled = lattice.settle(&[load]).expect("it settles").shape;
        let beams = statics::solve(&beams, &[load], Kinematics::Corotational).expect("an equilibrium");
        let error = shapes_apart(&settled, &beams);
        assert!(error < 2e-3, "{error}");
    }
}

/// Tapered plates: the lattice uses the thickness at the middle of each segment, and beams use mean compliances.
#[test]
fn lattices_of_tapered_plates_rest_where_beams_do() {
    let tapered = [("[finger.front]", 0.75), ("[finger.back]", 2.0)]
        .map(|(plate, tip_mm)| (plate, format!("{plate}\ntip_thickness_mm = {tip_mm:?}")));
    let finger = paper_scene_with(&tapered.each_ref().map(|(plate, taper)| (*plate, taper.as_str()))).finger;
    let load = Load::at_position(90.0, finger.direction(10.0));
    let beams = Mesh::with_elements_per_member(&finger, 16);
    let beams = statics::solve(&beams, &[load], Kinematics::Corotational).expect("an equilibrium");
    let lattice =
        |fineness| Lattice::new(&finger, fineness).expect("a lattice").equilibrium(&[load]).expect("it rests");
    let errors = [1, 4].map(|fineness| shapes_apart(&lattice(fineness), &beams));
    assert!(errors[0] < 2e-2 && errors[1] < 0.15 * errors[0], "{errors:?}");
}

/// Different loads at once: a force at a node, a force between nodes, and a moment.
#[test]
fn several_loads_settle_together() {
    let finger = paper();
    let lattice = Lattice::new(&finger, 2).expect("a lattice");
    let loads = [
        Load::at_node(NodeId(16), finger.direction(-20.0) * 1.5),
        Load::at_position(55.0, finger.direction(30.0) * 1.0),
        Load::Node { node: NodeId(6), force: Vector::zeros(), moment_nmm: 12.0 },
    ];
    let settled = lattice.settle(&loads).expect("it settles").shape;
    let beams = statics::solve(&Mesh::with_elements_per_member(&finger, 16), &loads, Kinematics::Corotational);
    let error = shapes_apart(&settled, &beams.expect("an equilibrium"));
    assert!(error < 3e-3, "{error}");
}

#[test]
fn what_does_not_settle_is_an_error() {
    let lattice = Lattice::new(&paper(), 2).expect("a lattice");
    let load = Load::at_node(NodeId(19), Vector::new(0.0, -2.0));
    let within = |most_steps| Settling { most_steps, ..Settling::default() };
    match lattice.settle_as(&[load], within(900)) {
        Err(LatticeError::NotSettled { steps, residual }) => {
            assert!(steps <= 900 && residual > settling::AT_REST && residual.is_finite());
        }
        other => panic!("{other:?}"),
    }
    // Three steps do not even reach the first peak of the kinetic energy.
    assert!(matches!(
        lattice.settle_as(&[load], within(3)),
        Err(LatticeError::NotSettled { residual, .. }) if residual.is_infinite()
    ));
}

/// Without loads, the lattice rests at once in its undeformed shape.
#[test]
fn an_unloaded_finger_stays() {
    let settled = Lattice::new(&paper(), 2).expect("a lattice").settle(&[]).expect("it rests");
    assert!(settled.shape.largest_displacement_mm() < 1e-9 && settled.steps < 100);
}

/// Coarser and finer lattices also settle at their equilibrium, even under a small force.
#[test]
fn every_fineness_settles_where_its_energy_is_least() {
    let finger = paper();
    for (fineness, force_n) in [(1, 4.0), (3, 0.02)] {
        let lattice = Lattice::new(&finger, fineness).expect("a lattice");
        let load = Load::at_node(NodeId(17), finger.direction(-60.0) * force_n);
        let settled = lattice.settle(&[load]).expect("it settles").shape;
        let error = shapes_apart(&settled, &lattice.equilibrium(&[load]).expect("an equilibrium"));
        assert!(error < SETTLING_TOLERANCE, "{error}");
    }
}
