//! Equilibria of finger and object, compared with closed forms, beams and each other.

use super::{COARSE, last, prepared, scene, steps};
use finray_contact::TouchedPart;
use finray_contact::press::{ContactScene, SceneStep};
use finray_model::mesh::Load;
use finray_model::sensing::ContactPosition;
use finray_model::{Kinematics, Mesh, NodeId, Scene, Vector, statics};

/// A travel (mm) so small that the finger is linear: rotations and their relative effect are about 1e-3.
const TINY_TRAVEL_MM: f64 = 0.05;
const TINY_TOLERANCE: f64 = 5e-3;

/// Compliance of the linear finger along the plate's normal, mm/N: displacement of node `at` per newton at node `under`.
fn normal_compliance(scene: &Scene, under: NodeId, at: NodeId) -> f64 {
    let normal = scene.finger.direction(0.0);
    let mesh = Mesh::key_nodes(&scene.finger);
    let shape = statics::solve(&mesh, &[Load::at_node(under, normal)], Kinematics::Linear).expect("a linear solution");
    shape.motion(at).displacement.dot(&normal)
}

/// A disc pressed onto a rod meets the linear stiffness of the finger at this rod.
#[test]
fn a_small_push_on_a_rod_meets_the_linear_stiffness() {
    let object = format!("shape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = {TINY_TRAVEL_MM}\nsteps = 1");
    let step = last(&object, COARSE);
    let [seen] = step.contacts[..] else { panic!("one contact: {:?}", step.contacts) };
    assert_eq!(seen.contact.position, ContactPosition::Node(NodeId(19)));
    let expected = step.travel_mm / normal_compliance(&scene(&object), NodeId(19), NodeId(19));
    assert!((seen.normal_n / expected - 1.0).abs() < TINY_TOLERANCE, "{} N, {expected} N expected", seen.normal_n);
}

/// A flat box over three rods touches the rods under its ends. The displacement of each touched rod equals the travel, so compliance C and forces f
/// satisfy C f = (travel, travel).
#[test]
fn a_flat_box_shares_its_force_as_the_compliance_tells() {
    let turn_deg =
        scene("shape = \"disc\"\nradius_mm = 1\nat_mm = 1\ntravel_mm = 1").finger.front_tangent().y.asin().to_degrees();
    let object = format!(
        "shape = \"box\"\nwidth_mm = 30\nheight_mm = 10\nrotation_deg = {turn_deg}\nat_mm = 76.5\ntravel_mm = {TINY_TRAVEL_MM}\n\
         steps = 1"
    );
    let step = last(&object, COARSE);
    let nodes = [20, 18].map(NodeId);
    assert_eq!(
        step.contacts.iter().map(|seen| seen.contact.position).collect::<Vec<_>>(),
        nodes.map(ContactPosition::Node),
        "the rods under the ends"
    );
    let compliance = |under, at| normal_compliance(&scene(&object), nodes[under], nodes[at]);
    let compliance = nalgebra::Matrix2::from_fn(|at, under| compliance(under, at));
    let expected = compliance.try_inverse().expect("two rods") * nalgebra::Vector2::repeat(step.travel_mm);
    for (seen, expected) in step.contacts.iter().zip(expected.iter()) {
        assert!((seen.normal_n / expected - 1.0).abs() < TINY_TOLERANCE, "{} N, {expected} N expected", seen.normal_n);
    }
}

/// Without friction, the force between disc and rod acts along the line through their centres.
#[test]
fn a_frictionless_force_points_from_the_disc_to_the_rod() {
    let object = "shape = \"disc\"\nradius_mm = 20\nat_mm = 80\ntravel_mm = 8\nsteps = 1";
    let step = last(object, COARSE);
    let scene = scene(object);
    let [touch] = step.pressed.touches[..] else { panic!("one touch: {:?}", step.pressed.touches) };
    let TouchedPart::Rod(node) = touch.part else { panic!("a rod: {touch:?}") };
    let motion = step.pressed.shape.motion(node);
    let rod = motion.position + motion.displacement;
    let line = rod - step.pressed.object;
    assert!((line.norm() - 20.0 - scene.contact.rod_radius_mm).abs() < 1e-4, "{} mm apart", line.norm());
    assert!(touch.force.perp(&line).abs() < 1e-6 * touch.force.norm() * line.norm());
}

/// A disc is pressed into the finger and dragged along it and back. While the disc slides, friction is the coefficient times the normal force, and
/// acts in the direction of sliding.
#[test]
fn sliding_friction_is_coulombs() {
    const FRICTION: f64 = 0.2;
    const TOLERANCE: f64 = 1e-6;
    let object = format!(
        "shape = \"disc\"\nradius_mm = 12\nfriction = {FRICTION}\npath_mm = [[50, 38], [50, 20], [62, 17.5], [50, 20]]\nsteps = 12"
    );
    let steps = steps(&prepared(&scene(&object)).with_fineness(COARSE));
    let slides = |step: &SceneStep| {
        let normal_n: f64 = step.contacts.iter().map(|seen| seen.normal_n).sum();
        step.contacts.iter().map(|seen| seen.friction_n).sum::<f64>() / (FRICTION * normal_n)
    };
    // In the middle of each stroke along the plate, the disc slides; at the ends of a stroke, its motion reverses.
    let (there, back) = (slides(&steps[7]), slides(&steps[10]));
    assert!((there - 1.0).abs() < TOLERANCE && (back + 1.0).abs() < TOLERANCE, "{there} and {back}");
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    let object = "shape = \"box\"\nwidth_mm = 20\nheight_mm = 20\nrotation_deg = 20\nfriction = 0.3\nat_mm = 70\nforce_n = 1\nsteps = 2";
    let prepared = prepared(&scene(object)).with_fineness(COARSE);
    assert_eq!(steps(&prepared), steps(&prepared));
}

/// Pressing with a force, and moving to the position that this press reached, lead to the same equilibrium.
#[test]
fn force_and_travel_are_two_sides_of_one_equilibrium() {
    let press = |until: &str| {
        last(&format!("shape = \"disc\"\nradius_mm = 20\nat_mm = 70\ndirection_deg = 10\n{until}\nsteps = 1"), COARSE)
    };
    let by_force = press("force_n = 2");
    const TOLERANCE: f64 = 1e-4;
    assert!((by_force.total_n() - 2.0).abs() < TOLERANCE);
    let by_travel = press(&format!("travel_mm = {}", by_force.travel_mm));
    assert!((by_travel.total_n() / 2.0 - 1.0).abs() < 2.0 * TOLERANCE, "{} N", by_travel.total_n());
}

/// The hand moves in short increments, however few steps are requested, so the object cannot jump through the finger.
#[test]
fn the_rest_position_does_not_depend_on_the_steps() {
    for (object, tolerance) in [
        ("shape = \"disc\"\nradius_mm = 1\npath_mm = [[75, 40], [75, -17]]", 1e-3),
        ("shape = \"disc\"\nradius_mm = 10\nat_mm = 140\ntravel_mm = 60", 1e-3),
    ] {
        let force_n = |steps: usize| last(&format!("{object}\nsteps = {steps}"), COARSE).pressed.contact_force().norm();
        let (once, often) = (force_n(1), force_n(4));
        assert!(once > 0.5 && (once / often - 1.0).abs() < tolerance, "{once} N in one step, {often} N in four");
    }
}

/// A polygon moves with the origin of its corners. The object does not rotate, so the position of the origin of its corners has no effect.
#[test]
fn the_origin_of_an_outline_does_not_matter() {
    let press = |origin: Vector| {
        let scene = scene("shape = \"polygon\"\npoints_csv = \"x.csv\"\nat_mm = 70\ntravel_mm = 5\nsteps = 1");
        let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]].map(|corner| Vector::from(corner) + origin);
        let object = scene.object.as_ref().expect("an object");
        let prepared = ContactScene::new(&scene, object, &corners).expect("an outline").with_fineness(COARSE);
        (steps(&prepared).pop().expect("a step"), scene.finger.direction(0.0))
    };
    // The origin is displaced along the object's motion, so that the object meets the finger at the same position.
    let (near, normal) = press(Vector::zeros());
    let (far, _) = press(normal * 100.0);
    let (near, far) = (near.pressed.contact_force().norm(), far.pressed.contact_force().norm());
    assert!(near > 0.1 && (far / near - 1.0).abs() < 1e-6, "{near} N, {far} N");
}

/// On a path with corners, the travel is the length of the path, and the total force is the component along the last segment.
#[test]
fn corners_of_a_path_are_passed() {
    let prepared =
        prepared(&scene("shape = \"disc\"\nradius_mm = 10\npath_mm = [[75, 40], [60, 40], [60, 20]]\nsteps = 1"));
    let step = steps(&prepared.with_fineness(COARSE)).pop().expect("a step");
    assert!((step.travel_mm - 35.0).abs() < 1e-9, "{} mm", step.travel_mm);
    assert_eq!(step.along, Vector::new(0.0, -1.0));
    assert!((step.total_n() - step.pressed.contact_force().dot(&step.along)).abs() < 1e-12);
}

/// A finger with 1/10 000 of the stiffness exerts 1/10 000 of the force.
#[test]
fn soft_fingers_are_pressed_alike() {
    let object = "\n[object]\nshape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = 8\nsteps = 1";
    let soft = finray_fixtures::PAPER_SCENE.replace("47.976", "0.0047976");
    let force_n = |text: String| {
        let scene = Scene::from_toml(&text).expect("a good scene");
        steps(&prepared(&scene).with_fineness(COARSE)).pop().expect("a step").pressed.contact_force().norm()
    };
    let (usual, soft) = (force_n(finray_fixtures::PAPER_SCENE.to_owned() + object), force_n(soft + object));
    assert!((soft / usual * 1e4 - 1.0).abs() < 1e-3, "{usual} N, {soft} N");
}
