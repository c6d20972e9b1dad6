//! Conventions of signs, angles and node numbers, tested on an asymmetric finger.

mod one_piece;

use finray_model::finger::{BracketLengths, Plate};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, statics};

/// Rounding error of coordinates of a finger of some hundred mm.
const ROUNDING: f64 = 1e-12;

/// Three ribs that end at different positions on front and back plate. The triangle has no symmetry.
const LOPSIDED: &str = r#"
name = "lopsided"
[finger]
base_width_mm = 60.0
front_length_mm = 120.0
back_length_mm = 150.0
depth_mm = 20.0
[finger.front]
thickness_mm = 1.0
youngs_modulus_mpa = 50.0
[finger.back]
thickness_mm = 1.0
youngs_modulus_mpa = 50.0
[finger.ribs]
positions_mm = [[20.0, 60.0], [50.0, 90.0], [80.0, 120.0]]
joints = "rigid"
thickness_mm = 1.25
youngs_modulus_mpa = 50.0
"#;

fn lopsided(zones: &str) -> Finger {
    Scene::from_toml(&format!("{LOPSIDED}{zones}")).expect("a sound scene").finger
}

/// Stiffness of each rib divided by the stiffness without the zone.
fn rib_factors(zones: &str) -> Vec<f64> {
    let rigidities = |finger: &Finger| -> Vec<f64> {
        let mesh = Mesh::key_nodes(finger);
        let ribs = mesh.lines()[2 * (finger.rib_count() + 1)..].iter();
        ribs.map(|rib| mesh.frame().members()[rib.members.start].beam.bending_rigidity_nmm2).collect()
    };
    let plain = rigidities(&lopsided(""));
    rigidities(&lopsided(zones)).iter().zip(&plain).map(|(a, b)| a / b).collect()
}

/// A zone of the ribs covers the ribs with a front end in the zone, wherever the back ends are.
#[test]
fn zones_of_ribs_go_by_their_front_ends() {
    let zone = |from: f64, to: f64| {
        rib_factors(&format!(
            "[[finger.zone]]\nplate = \"ribs\"\nfrom_mm = {from}\nto_mm = {to}\nmodulus_factor = 0.25\n"
        ))
    };
    assert_eq!(zone(40.0, 55.0), [1.0, 0.25, 1.0]);
    // If zones covered ribs by their back ends, this zone would cover the first rib.
    assert_eq!(zone(55.0, 85.0), [1.0, 1.0, 0.25]);
}

/// A rib k times as thick has k times the axial and k^3 times the bending stiffness; the other ribs do not change. A hinged rib does not bend, so it
/// behaves like a rib with k times the modulus.
#[test]
fn each_rib_may_have_its_own_thickness() {
    let with = |thickness_mm: &str, joints: &str, zones: &str| {
        let scene = LOPSIDED.replace("thickness_mm = 1.25", &format!("thickness_mm = {thickness_mm}"));
        Scene::from_toml(&(scene.replace("rigid", joints) + zones)).expect("a sound scene").finger
    };
    let (alike, each) = (with("1.25", "rigid", ""), with("[1.25, 2.5, 0.625]", "rigid", ""));
    for (rib, factor) in [1.0_f64, 2.0, 0.5].into_iter().enumerate() {
        let [alike, each] = [&alike, &each].map(|finger| finger.rib_section(rib).expect("it deforms"));
        assert!((each.axial_rigidity_n / alike.axial_rigidity_n / factor - 1.0).abs() < ROUNDING);
        assert!((each.bending_rigidity_nmm2 / alike.bending_rigidity_nmm2 / factor.powi(3) - 1.0).abs() < ROUNDING);
    }
    let zone = "[[finger.zone]]\nplate = \"ribs\"\nfrom_mm = 45.0\nto_mm = 55.0\nmodulus_factor = 2.0\n";
    let tip_mm = |finger: &Finger| {
        let load = Load::at_node(NodeId(7), finger.direction(10.0));
        let mesh = Mesh::with_elements_per_member(finger, 4);
        statics::solve(&mesh, &[load], Kinematics::Corotational)
            .expect("it is carried")
            .motion(finger.tip())
            .displacement
    };
    let (thick, stiff) = (tip_mm(&with("[1.25, 2.5, 1.25]", "hinged", "")), tip_mm(&with("1.25", "hinged", zone)));
    let off_mm = (thick - stiff).norm();
    assert!(off_mm < 1e-9 && (thick - tip_mm(&with("1.25", "hinged", ""))).norm() > 1e-4, "{off_mm}");
}

/// Angle 0 points from the front plate into the finger, at a right angle; positive angles lean towards the tip.
#[test]
fn angles_are_counted_from_the_inward_normal_towards_the_tip() {
    let finger = lopsided("");
    let tip = finger.position(finger.tip());
    let front_base = finger.base(Plate::Front);
    let along = (tip - front_base).normalize();
    let inward = finger.base(Plate::Back) - front_base;
    let normal = finger.direction(0.0);
    assert!(normal.dot(&along).abs() < ROUNDING && normal.dot(&inward) > 0.0);
    assert!((finger.direction(90.0) - along).norm() < ROUNDING);
    assert!((finger.direction(30.0).dot(&along) - 0.5).abs() < ROUNDING);
    assert!((finger.direction(30.0).dot(&normal) - 0.75_f64.sqrt()).abs() < ROUNDING);
}

/// A bracket is perpendicular to its plate, on the side of the other plate. The tip and the clamped nodes have no brackets.
#[test]
fn brackets_stand_off_the_plates_into_the_finger() {
    let mut description = lopsided("").description().clone();
    description.ribs.bracket_mm = BracketLengths::Alike([2.0, 3.0]);
    let finger = Finger::new(description).expect("room for the brackets");
    for rib in 0..finger.rib_count() {
        for ((node, plate), length_mm) in
            finger.rib_nodes(rib).into_iter().zip([Plate::Front, Plate::Back]).zip([2.0, 3.0])
        {
            let bracket = finger.hinge(node) - finger.position(node);
            let along = (finger.position(finger.tip()) - finger.base(plate)).normalize();
            let other = if plate == Plate::Front { Plate::Back } else { Plate::Front };
            assert!((bracket.norm() - length_mm).abs() < ROUNDING && bracket.dot(&along).abs() < ROUNDING);
            assert!(bracket.dot(&(finger.base(other) - finger.base(plate))) > 0.0);
        }
    }
    for node in finger.clamped_nodes().into_iter().chain([finger.tip()]) {
        assert_eq!(finger.hinge(node), finger.position(node));
    }
}

/// The front plate has positive y. Node numbers run from the back base over the tip to the front base.
#[test]
fn numbering_goes_over_the_tip() {
    let finger = lopsided("");
    assert_eq!(finger.tip(), NodeId(5));
    assert!((finger.position(NodeId(1)).y + 30.0).abs() < ROUNDING);
    assert!((finger.position(NodeId(9)).y - 30.0).abs() < ROUNDING);
    // Ribs meet the front plate in the order 3, 2, 1 from the tip, and the back plate in the order 1, 2, 3 from the base.
    let from_base = |node: usize, base: usize| (finger.position(NodeId(node)) - finger.position(NodeId(base))).norm();
    for (node, position) in [(6, 80.0), (7, 50.0), (8, 20.0)] {
        assert!((from_base(node, 9) - position).abs() < 1e3 * ROUNDING, "node {node}");
    }
    for (node, position) in [(2, 60.0), (3, 90.0), (4, 120.0)] {
        assert!((from_base(node, 1) - position).abs() < 1e3 * ROUNDING, "node {node}");
    }
}
