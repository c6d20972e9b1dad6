//! A grasp ends when the fingers touch each other or a table.

use super::world::{disc, steps_of};
use finray_contact::outline::ContactOutline;
use finray_contact::{Drive, World};
use finray_model::gripper::Placement;
use finray_model::{Mesh, Scene, Vector};
use finray_studies::experiments::grasp::{Eyes, GraspEnd, GraspError, GraspScene, GraspStep, Obstacle};

/// Radius of the rods, mm; one rod is at the tip.
const ROD_MM: f64 = 1.5;
/// Rotation of the motor in a step, degrees.
const STEP_DEG: f64 = 22.5;
/// Changes of the scene: the object is a grain of sand that no finger touches.
const GRAIN: [(&str, &str); 2] = [("radius_mm = 15.0", "radius_mm = 0.5"), ("[3.0, 110.0]", "[0.0, 40.0]")];
const NO_WAY: (&str, &str) = ("path_mm = [[0.0, -40.0], [60.0, -40.0], [60.0, 0.0]]\npath_steps = 12", "open = false");

fn scene(changes: &[(&str, &str)]) -> GraspScene {
    let text = disc(&[changes, &[NO_WAY]].concat());
    GraspScene::new(&Scene::from_toml(&text).unwrap(), &[]).unwrap().with_fineness(1)
}

/// Positions of both undeformed fingertips at a motor angle, mm.
fn tips(motor_deg: f64) -> [Vector; 2] {
    let Scene { finger, gripper, .. } = Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE).unwrap();
    let gripper = gripper.unwrap();
    let placements = gripper.fingers(&gripper.pose(motor_deg).unwrap());
    placements.map(|placement: Placement| placement.outwards(finger.position(finger.tip())))
}

/// The rods at the tips of undeformed fingers touch if the opening equals a rod's diameter. The last step of the grasp is the step before the rods
/// touch.
#[test]
fn fingers_that_touch_each_other_end_a_grasp() {
    let (steps, ended) = steps_of(&scene(&[&GRAIN[..], &[("-495.0", "-900.0")]].concat()), 0.0, 1);
    assert_eq!(ended, GraspEnd::Obstructed(Obstacle::EachOther));
    let last: &GraspStep = steps.last().unwrap();
    let apart = |motor_deg: f64| {
        let [left, right] = tips(motor_deg);
        right.x - left.x - 2.0 * ROD_MM
    };
    assert!(apart(last.motor_deg) > 0.0 && apart(last.motor_deg - STEP_DEG) <= 0.0, "{}", last.motor_deg);
    // A disc between the fingers keeps them apart.
    assert_eq!(steps_of(&scene(&[]), 0.0, 1).1, GraspEnd::Done);
}

/// While the gripper opens, the fingertips move down until they touch the table. With rails as support, the fingertips touch nothing.
#[test]
fn a_finger_that_touches_the_table_ends_a_grasp() {
    let on = |support: &str, table_mm: f64| {
        let centre = format!("centre_mm = [0.0, {}]", table_mm - 0.5);
        let support = format!("[grasp]\nsupport = {support}");
        let opening = ("motor_deg = [0.0, -495.0]", "motor_deg = [-405.0, 0.0]");
        scene(&[GRAIN[0], opening, ("centre_mm = [3.0, 110.0]", &centre), ("[grasp]", &support)])
    };
    let height = |table_mm: f64, motor_deg: f64| table_mm - tips(motor_deg)[0].y - ROD_MM;
    let table_mm = tips(-200.0)[0].y + ROD_MM;
    let (steps, ended) = steps_of(&on("\"table\"", table_mm), 0.0, 1);
    assert_eq!(ended, GraspEnd::Obstructed(Obstacle::Table { finger: 0 }));
    let last = steps.last().unwrap().motor_deg;
    assert!(height(table_mm, last) > 0.0 && height(table_mm, last + STEP_DEG) <= 0.0, "{last}");
    let ended = steps_of(&on("true", table_mm), 0.0, 1).1;
    assert_ne!(ended, GraspEnd::Obstructed(Obstacle::Table { finger: 0 }));
    // A grasp whose fingers start inside the table is refused.
    let in_table = on("\"table\"", tips(-405.0)[0].y).run(&Eyes::Noise(0.0), 1, |_| ());
    assert!(
        matches!(in_table, Err(GraspError::Obstructed { obstacle: Obstacle::Table { finger: 0 }, .. })),
        "{in_table:?}"
    );
}

/// Distances between two fingers, and from a finger to a plane, for several placements. The distance to the plane includes the back plate. Crossing
/// front plates have no positive distance.
#[test]
fn distances_are_those_of_the_nearest_parts() {
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).unwrap().finger;
    let mesh = Mesh::with_elements_per_member(&finger, 1);
    let distance = |apart_mm: f64, turned_rad: f64| {
        let left = Placement { origin: Vector::zeros(), angle_rad: 0.0, mirrored: false };
        let right = Placement { origin: Vector::new(0.0, apart_mm), angle_rad: turned_rad, mirrored: true };
        let drive = Drive { placements: vec![left, right], weight: Vector::zeros(), gripper: Vector::zeros() };
        let object = [1e4, 0.0, 0.0];
        let world = World::new(&[&mesh, &mesh], ROD_MM, (ContactOutline::disc(1.0), 0.0), object, drive, None).unwrap();
        (world.between_fingers_mm(), world.height_mm(0, (Vector::zeros(), Vector::y())))
    };
    // The front plates are along x and face each other.
    let base_mm = finger.position(finger.clamped_nodes()[1]).y;
    let tip = finger.position(finger.tip());
    let (between_mm, height_mm) = distance(200.0, 0.0);
    let gap_mm = 200.0 - 2.0 * base_mm.max(tip.y) - 2.0 * ROD_MM;
    assert!((between_mm - gap_mm).abs() < 1e-9, "{between_mm} and {gap_mm}");
    // The lowest point is the base of the back plate.
    let foot_mm = finger.position(finger.clamped_nodes()[0]).y - 0.5 * finger.description().back.thickness_mm;
    assert!((height_mm - foot_mm).abs() < 1e-9, "{height_mm} and {foot_mm}");
    let crossed = distance(2.0 * base_mm + 10.0, -0.6).0;
    assert!(crossed <= -2.0 * 0.5 * finger.description().front.thickness_mm + 1e-9, "{crossed}");
}
