//! Objects pressed onto the lattice: contact forces against closed forms and beams, friction, and what sensing makes of them.

use finray_model::finger::Plate;
use finray_model::mesh::Load;
use finray_model::scene::{ObjectDescription, ObjectMotion, Until};
use finray_model::sensing::ContactPlace;
use finray_model::{Kinematics, Mesh, NodeId, Scene, Vector, statics};
use finray_verify::check::Check;
use finray_verify::experiments::contact_scene::samples::NoiseSamples;
use finray_verify::experiments::contact_scene::study::{SAMPLES, SceneStudy, shipped};
use finray_verify::experiments::contact_scene::{
    ContactScene, OutlineError, SceneStep, SensedForce, TurnedOutline, read_contact, seen_contacts, standard_normal,
};
use finray_verify::lattice::skin::{Touch, TouchedPart};
use finray_verify::lattice::{Lattice, LatticeError};

/// Segments in a stretch of plate where nothing but the order of magnitude of the bending matters.
const COARSE: usize = 1;
/// A travel (mm) so small that the finger is linear: rotations are near 1e-3, and so is their effect.
const TINY_TRAVEL_MM: f64 = 0.05;
const TINY_TOLERANCE: f64 = 5e-3;

/// A scene with the paper's finger and an object.
fn scene(object: &str) -> Scene {
    Scene::from_toml(&format!("{}\n[object]\n{object}", finray_fixtures::PAPER_SCENE)).expect("a good scene")
}

fn prepared(scene: &Scene) -> ContactScene {
    let object: &ObjectDescription = scene.object.as_ref().expect("an object");
    ContactScene::new(scene, object, &[]).expect("an outline")
}

fn steps(scene: &ContactScene) -> Vec<SceneStep> {
    let mut steps = Vec::new();
    scene.run(|step| steps.push(step)).expect("everything comes to rest");
    steps
}

fn last(object: &str, fineness: usize) -> SceneStep {
    steps(&prepared(&scene(object)).with_fineness(fineness)).pop().expect("a step")
}

fn all_pass(checks: &[Check]) {
    assert!(!checks.is_empty());
    for check in checks {
        assert!(check.passes(), "{check:?}");
    }
}

/// Compliance of the linear finger along its normal: displacement of node `at` per newton at node `under`, mm/N.
fn normal_compliance(scene: &Scene, under: NodeId, at: NodeId) -> f64 {
    let normal = scene.finger.direction(0.0);
    let mesh = Mesh::key_nodes(&scene.finger);
    let shape = statics::solve(&mesh, &[Load::at_node(under, normal)], Kinematics::Linear).expect("a linear solution");
    shape.motion(at).displacement.dot(&normal)
}

/// All that the report promises of its first scene, in fewer steps.
#[test]
fn a_disc_pressed_to_5_n_keeps_every_promise() {
    let (mut given, fineness) = shipped().expect("scenes that ship").swap_remove(0);
    let object = given.scene.object.as_mut().expect("an object");
    assert!(matches!(object.motion, ObjectMotion::Press { until: Until::Force(5.0), .. }));
    object.steps = 2;
    let prepared = prepared(&given.scene).with_fineness(fineness);
    let study = SceneStudy::run("disc", &prepared, 0.067, SAMPLES, &|| ()).expect("beams carry the forces");
    all_pass(&study.shipped_checks());
    let end = &study.steps[1].step;
    let nodes: Vec<_> = end.contacts.iter().map(|seen| seen.contact.place).collect();
    assert_eq!(nodes, [19, 18].map(|node| ContactPlace::Node(NodeId(node))), "two neighbours share the force");
    assert_eq!(study.steps[1].samples.as_ref().expect("noise").sensed.len(), 3);
}

/// Friction within its known bound is in the stated intervals, and these are of use; sensing that takes forces for normal states intervals
/// that miss them, and the checks say so.
#[test]
fn friction_is_within_the_stated_intervals() {
    // With one segment between rods the lattice differs from beams by more than noise.
    let (given, fineness) = shipped().expect("scenes that ship").swap_remove(3);
    let known = prepared(&given.scene).with_fineness(fineness);
    let run = |scene: &ContactScene| SceneStudy::run("friction", scene, 0.067, 50, &|| ()).expect("a study");
    let study = run(&known);
    all_pass(&study.shipped_checks());
    assert!(
        study.shipped_checks().iter().filter(|check| check.problem.contains("within 1.96 stated sigma")).count() == 4
    );
    for studied in &study.steps {
        let samples = studied.samples.as_ref().expect("noise");
        for (which, seen) in studied.step.contacts.iter().enumerate() {
            let sigma_n = samples.rms_sigma_n(which);
            assert!(sigma_n < 0.5 * seen.normal_n, "{sigma_n} N says little of {} N", seen.normal_n);
        }
    }
    let unknown = run(&known.with_assumed_friction(0.0));
    let broken: Vec<_> = unknown.shipped_checks().into_iter().filter(|check| !check.passes()).collect();
    assert!(broken.iter().any(|check| check.problem.contains("every contact's force")), "{broken:?}");
    let frictionless = SceneStudy { friction: 0.0, ..study };
    assert!(frictionless.checks().iter().any(|check| !check.passes() && check.source == "Coulomb"));
}

/// The camera does not see how hard an object pushes where: other forces at the same touches are the same contacts.
#[test]
fn contacts_are_seen_alike_whatever_they_carry() {
    let finger = scene("shape = \"disc\"\nradius_mm = 1\nat_mm = 1\ntravel_mm = 1").finger;
    let lattice = Lattice::new(&finger, COARSE).expect("a lattice");
    let touch = |s_mm: f64, angle_deg: f64, force_n: f64| {
        let normal = finger.direction(angle_deg);
        let point = finger.plate_point(Plate::Front, s_mm);
        let (part, force) = (TouchedPart::Plate(s_mm), normal * force_n);
        Touch { body: 0, part, clamped: false, point, arm: Vector::zeros(), normal, force, overlap_mm: 0.0 }
    };
    let seen = |forces_n: [f64; 2]| {
        let touches = [touch(80.0, -4.0, forces_n[0]), touch(82.0, 6.0, forces_n[1])];
        let seen = seen_contacts(&lattice, &touches, |_| 10.0);
        assert_eq!(seen.len(), 1);
        seen[0]
    };
    let (one, other) = (seen([3.0, 1.0]), seen([1.0, 3.0]));
    assert_eq!((one.contact, one.point), (other.contact, other.point));
    assert!((one.contact.angle_deg - 1.0).abs() < 1e-9, "the middle: {:?}", one.contact);
    assert!(matches!(one.contact.place, ContactPlace::Place(s_mm) if (s_mm - 81.0).abs() < 1e-9));
}

/// Positions and directions that the camera reads scatter as it says, about the true ones.
#[test]
fn read_contacts_scatter_as_stated() {
    const NOISE_MM: f64 = 0.067;
    const READINGS: usize = 4000;
    let object = "shape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = 1\nsteps = 1";
    let (step, finger) = (last(object, COARSE), scene(object).finger);
    let seen = step.contacts[0];
    assert_eq!(seen.baseline_mm, 21.5, "from the middle of the disc to that of the rod");
    let plate = finray_verify::experiments::contact_scene::SeenContact {
        contact: finray_model::sensing::Contact { place: ContactPlace::Place(70.0), ..seen.contact },
        ..seen
    };
    let mut normal = standard_normal(7);
    let (mut turns, mut shifts) = (0.0, 0.0);
    let mut stated = [0.0; 2];
    for _ in 0..READINGS {
        let read = read_contact(&finger, &plate, NOISE_MM, &mut normal);
        let ContactPlace::Place(s_mm) = read.contact.place else { panic!("a position") };
        turns += (read.contact.angle_deg - plate.contact.angle_deg).to_radians().powi(2) / READINGS as f64;
        shifts += (s_mm - 70.0).powi(2) / READINGS as f64;
        stated = [read.direction_sd_rad, read.position_sd_mm];
    }
    // Four standard errors of a variance.
    let chance = 4.0 * (2.0 / READINGS as f64).sqrt();
    for (found, stated) in [(turns, stated[0]), (shifts, stated[1])] {
        assert!((found / stated.powi(2) - 1.0).abs() < chance, "{found}, {} stated", stated.powi(2));
    }
    assert!((stated[0] - 2.0_f64.sqrt() * NOISE_MM / 21.5).abs() < 1e-12);
    let exact = read_contact(&finger, &plate, 0.0, &mut normal);
    assert_eq!((exact.contact, exact.direction_sd_rad, exact.position_sd_mm), (plate.contact, 0.0, 0.0));
}

/// Samples that sensing refuses hold no true force: half of them refused is no coverage of 95 %.
#[test]
fn refused_samples_are_not_covered() {
    let exact = SensedForce { true_n: 1.0, sensed_n: 1.0, sigma_n: 0.1 };
    let samples = NoiseSamples { taken: 100, answered: 50, sensed: vec![vec![exact; 50]; 2] };
    assert_eq!((samples.covered(0), samples.coverage(1)), (50, 0.5));
    let scene = scene("shape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = 1\nsteps = 1");
    let mut study =
        SceneStudy::run("refused", &prepared(&scene).with_fineness(COARSE), 0.067, 1, &|| ()).expect("a study");
    study.steps[0].samples = Some(samples);
    let broken = study.shipped_checks().into_iter().filter(|check| !check.passes() && check.problem.contains("sigma"));
    assert_eq!(broken.count(), 4, "contacts and total, over all and where fewest");
}

/// A disc over a rod meets the finger's linear stiffness there.
#[test]
fn a_small_push_on_a_rod_meets_the_linear_stiffness() {
    let object = format!("shape = \"disc\"\nradius_mm = 20\nat_mm = 76.5\ntravel_mm = {TINY_TRAVEL_MM}\nsteps = 1");
    let step = last(&object, COARSE);
    let [seen] = step.contacts[..] else { panic!("one contact: {:?}", step.contacts) };
    assert_eq!(seen.contact.place, ContactPlace::Node(NodeId(19)));
    let expected = step.travel_mm / normal_compliance(&scene(&object), NodeId(19), NodeId(19));
    assert!((seen.normal_n / expected - 1.0).abs() < TINY_TOLERANCE, "{} N, {expected} N expected", seen.normal_n);
}

/// A flat box over three rods touches those under its ends, which both move by its travel: C f = (travel, travel).
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
        step.contacts.iter().map(|seen| seen.contact.place).collect::<Vec<_>>(),
        nodes.map(ContactPlace::Node),
        "the rods under the ends"
    );
    let compliance = |under, at| normal_compliance(&scene(&object), nodes[under], nodes[at]);
    let compliance = nalgebra::Matrix2::from_fn(|at, under| compliance(under, at));
    let expected = compliance.try_inverse().expect("two rods") * nalgebra::Vector2::repeat(step.travel_mm);
    for (seen, expected) in step.contacts.iter().zip(expected.iter()) {
        assert!((seen.normal_n / expected - 1.0).abs() < TINY_TOLERANCE, "{} N, {expected} N expected", seen.normal_n);
    }
}

/// Forces of balls without friction go through their middles, along the line to the disc's.
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
    // The solver's rounding, over a distance that only an overlap would change.
    assert!((line.norm() - 20.0 - scene.rod_radius_mm).abs() < 1e-4, "{} mm apart", line.norm());
    assert!(touch.force.perp(&line).abs() < 1e-6 * touch.force.norm() * line.norm());
}

/// A disc dragged along the finger and back, pressed into it: while it slides, friction is its coefficient times the normal
/// force, and drags the finger along.
#[test]
fn sliding_friction_is_coulombs() {
    const FRICTION: f64 = 0.2;
    /// Settling lets the last bit of the way spring back: it then sticks with a little less.
    const STUCK_SHARE: f64 = 0.9;
    let object = format!(
        "shape = \"disc\"\nradius_mm = 12\nfriction = {FRICTION}\npath_mm = [[50, 38], [50, 20], [62, 17.5], [50, 20]]\nsteps = 12"
    );
    let steps = steps(&prepared(&scene(&object)).with_fineness(COARSE));
    let slides = |step: &SceneStep| {
        let normal_n: f64 = step.contacts.iter().map(|seen| seen.normal_n).sum();
        step.contacts.iter().map(|seen| seen.friction_n).sum::<f64>() / (FRICTION * normal_n)
    };
    // By the middle of each way along the plate it slides: the ends are where it turns.
    let (there, back) = (slides(&steps[7]), slides(&steps[10]));
    assert!((STUCK_SHARE..=1.0 + 1e-6).contains(&there), "{there}");
    assert!((STUCK_SHARE..=1.0 + 1e-6).contains(&-back), "{back}");
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    let object = "shape = \"box\"\nwidth_mm = 20\nheight_mm = 20\nrotation_deg = 20\nfriction = 0.3\nat_mm = 70\nforce_n = 1\nsteps = 2";
    let prepared = prepared(&scene(object)).with_fineness(COARSE);
    assert_eq!(steps(&prepared), steps(&prepared));
}

/// A force that is held and a hand that stands where it led end in the same place.
#[test]
fn force_and_travel_are_two_sides_of_one_equilibrium() {
    let press = |until: &str| {
        last(&format!("shape = \"disc\"\nradius_mm = 20\nat_mm = 70\ndirection_deg = 10\n{until}\nsteps = 1"), COARSE)
    };
    let by_force = press("force_n = 2");
    // The hand gives way across the line by as little as its springs are stiff.
    const TOLERANCE: f64 = 1e-3;
    assert!((by_force.total_n() - 2.0).abs() < TOLERANCE);
    let by_travel = press(&format!("travel_mm = {}", by_force.travel_mm));
    assert!((by_travel.total_n() / 2.0 - 1.0).abs() < 2.0 * TOLERANCE, "{} N", by_travel.total_n());
}

/// The hand goes slowly, however few steps are looked at: the object cannot jump through the finger.
#[test]
fn the_place_of_rest_does_not_depend_on_the_steps() {
    for (object, tolerance) in [
        ("shape = \"disc\"\nradius_mm = 1\npath_mm = [[75, 40], [75, -17]]", 1e-3),
        ("shape = \"disc\"\nradius_mm = 10\nat_mm = 140\ntravel_mm = 60", 1e-3),
    ] {
        let force_n = |steps: usize| last(&format!("{object}\nsteps = {steps}"), COARSE).pressed.contact_force().norm();
        let (once, often) = (force_n(1), force_n(4));
        assert!(once > 0.5 && (once / often - 1.0).abs() < tolerance, "{once} N in one step, {often} N in four");
    }
}

/// Whatever touches there, rods and plate and tip: without friction none is reported, and sensing finds the force.
#[test]
fn smooth_objects_have_no_friction() {
    for object in [
        "shape = \"disc\"\nradius_mm = 5\nat_mm = 152\ntravel_mm = 4\nsteps = 1",
        "shape = \"box\"\nwidth_mm = 20\nheight_mm = 20\nrotation_deg = 30\nat_mm = 70\nforce_n = 2\nsteps = 1",
    ] {
        let prepared = prepared(&scene(object)).with_fineness(2);
        let step = steps(&prepared).pop().expect("a step");
        assert!(step.contacts.iter().all(|seen| seen.friction_n.abs() < 1e-9), "{:?}", step.contacts);
        let sensed = prepared.sense(&step, 0.0, || 0.0).expect("an answer").expect("a contact");
        assert!(sensed.total.relative_error().abs() < 0.03, "{:?}", sensed.total);
    }
}

/// A polygon is moved by the origin of its corners; where that lies changes nothing, as it does not turn.
#[test]
fn the_origin_of_an_outline_does_not_matter() {
    let press = |origin: Vector| {
        let scene = scene("shape = \"polygon\"\npoints_csv = \"x.csv\"\nat_mm = 70\ntravel_mm = 5\nsteps = 1");
        let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]].map(|corner| Vector::from(corner) + origin);
        let object = scene.object.as_ref().expect("an object");
        let prepared = ContactScene::new(&scene, object, &corners).expect("an outline").with_fineness(COARSE);
        (steps(&prepared).pop().expect("a step"), scene.finger.direction(0.0))
    };
    // Moved along the way of the object, so that it meets the same place.
    let (near, normal) = press(Vector::zeros());
    let (far, _) = press(normal * 100.0);
    let (near, far) = (near.pressed.contact_force().norm(), far.pressed.contact_force().norm());
    assert!(near > 0.1 && (far / near - 1.0).abs() < 1e-6, "{near} N, {far} N");
}

/// Along a path with corners the way is the path's, and the total that along its last stretch.
#[test]
fn corners_of_a_path_are_passed() {
    let prepared =
        prepared(&scene("shape = \"disc\"\nradius_mm = 10\npath_mm = [[75, 40], [60, 40], [60, 20]]\nsteps = 1"));
    let step = steps(&prepared.with_fineness(COARSE)).pop().expect("a step");
    // The hand gives way a little.
    assert!((step.travel_mm - 35.0).abs() < 0.1, "{} mm", step.travel_mm);
    assert_eq!(step.along, Vector::new(0.0, -1.0));
    assert!((step.total_n() - step.pressed.contact_force().dot(&step.along)).abs() < 1e-12);
}

/// However near two rods are, each is a contact of its own; plate between them belongs to the one before it, which gives the direction.
#[test]
fn two_rods_are_two_contacts() {
    let text =
        finray_fixtures::PAPER_SCENE.replace("count = 11", "positions_mm = [[40, 40], [75, 75], [78, 78], [120, 120]]");
    let finger = Scene::from_toml(&text).expect("a good scene").finger;
    let lattice = Lattice::new(&finger, COARSE).expect("a lattice");
    let touch = |part, angle_deg: f64, force_n: f64| {
        let normal = finger.direction(angle_deg);
        Touch {
            body: 0,
            part,
            clamped: false,
            point: Vector::zeros(),
            arm: Vector::zeros(),
            normal,
            force: normal * force_n,
            overlap_mm: 0.0,
        }
    };
    // Nodes 9 and 8 at 75 and 78 mm.
    let touches = [
        touch(TouchedPart::Rod(NodeId(9)), 0.0, 3.0),
        touch(TouchedPart::Plate(75.2), 90.0, 4.0),
        touch(TouchedPart::Rod(NodeId(8)), -10.0, 1.0),
        touch(TouchedPart::Plate(100.0), 0.0, 1.0),
    ];
    let seen = seen_contacts(&lattice, &touches, |_| 10.0);
    let places: Vec<ContactPlace> = seen.iter().map(|seen| seen.contact.place).collect();
    let expected = [ContactPlace::Node(NodeId(9)), ContactPlace::Node(NodeId(8)), ContactPlace::Place(100.0)];
    assert_eq!(places, expected);
    assert!(seen[0].contact.angle_deg.abs() < 1e-9 && (seen[1].contact.angle_deg + 10.0).abs() < 1e-9);
    assert!((seen[0].normal_n - 7.0).abs() < 1e-12 && seen[0].friction_n.abs() < 1e-12);
}

/// A way that begins in the air is checked where the object touches.
#[test]
fn steps_without_contact_break_no_promise() {
    let scene = scene("shape = \"disc\"\nradius_mm = 10\npath_mm = [[75, 40], [75, 15]]\nsteps = 5");
    let study = SceneStudy::run("from afar", &prepared(&scene).with_fineness(COARSE), 0.0, 0, &|| ()).expect("a study");
    assert!(study.steps[0].step.contacts.is_empty() && study.steps[0].step.total_n().is_sign_positive());
    all_pass(&study.checks());
}

/// A ten thousandth of the stiffness, a ten thousandth of the force.
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

/// What presses on the clamp is not felt, and counts among the forces on the base.
#[test]
fn a_force_on_the_clamp_is_told_apart() {
    let step = last("shape = \"disc\"\nradius_mm = 15\nat_mm = 6\nforce_n = 3\nsteps = 1", 2);
    assert!(step.contacts.iter().any(|seen| seen.clamped) && step.contacts.iter().any(|seen| !seen.clamped));
    let whole = step.pressed.contact_force();
    assert!((step.pressed.base_force - whole).norm() < 1e-3 * whole.norm());
    assert!((step.pressed.hand_force - whole).norm() < 1e-3 * whole.norm());
    let prepared = prepared(&scene("shape = \"disc\"\nradius_mm = 15\nat_mm = 6\nforce_n = 3\nsteps = 1"));
    let sensed = prepared.sense(&step, 0.0, || 0.0).expect("an answer").expect("a contact");
    assert_eq!(sensed.contacts.len(), 1);
    assert!(sensed.total.true_n < 0.9 * 3.0, "{:?}", sensed.total);
}

/// An outline that is not convex pushes with its prongs, and not with what lies between.
#[test]
fn a_fork_touches_with_its_prongs() {
    let (given, _) = shipped().expect("scenes that ship").swap_remove(2);
    let scene = given.scene;
    let object = ObjectDescription { steps: 1, ..scene.object.clone().expect("an object") };
    let prepared = ContactScene::new(&scene, &object, &given.corners).expect("an outline").with_fineness(COARSE);
    let step = steps(&prepared).pop().expect("a step");
    assert_eq!(step.contacts.len(), 2, "{:?}", step.contacts);
    let places: Vec<f64> =
        step.contacts.iter().map(|seen| seen.contact.place_mm(&scene.finger).expect("a place")).collect();
    // The prongs are 28 to 44 mm apart; the rods next to them carry.
    assert!((28.0..44.0).contains(&(places[1] - places[0])), "{places:?}");
}

#[test]
fn what_is_no_outline_is_refused() {
    let given = scene("shape = \"polygon\"\npoints_csv = \"x.csv\"\nat_mm = 70\ntravel_mm = 1");
    let object = given.object.expect("an object");
    let outline = |corners: &[[f64; 2]]| {
        let corners: Vec<Vector> = corners.iter().map(|&corner| corner.into()).collect();
        TurnedOutline::new(&object, &corners)
    };
    let crossed = [[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]];
    assert_eq!(outline(&crossed), Err(OutlineError::Crossed));
    assert_eq!(outline(&[[0.0, 0.0], [5.0, 5.0], [10.0, 10.0]]), Err(OutlineError::Crossed));
    assert_eq!(outline(&crossed[..2]), Err(OutlineError::TooFewCorners { corners: 2 }));
    assert_eq!(outline(&[[0.0, 0.0], [1e9, 0.0], [0.0, 1.0]]), Err(OutlineError::TooFar { corner: 2 }));
    assert!(outline(&[[0.0, 0.0], [0.0, 10.0], [10.0, 10.0], [10.0, 0.0]]).is_ok(), "clockwise");
}

#[test]
fn an_object_that_the_finger_lets_go_is_said_so() {
    let off = scene("shape = \"disc\"\nradius_mm = 5\nat_mm = 153\ndirection_deg = 80\nforce_n = 5\nsteps = 1");
    let outcome = prepared(&off).with_fineness(COARSE).run(|_| ());
    assert_eq!(outcome, Err(LatticeError::LetGo));
}

#[test]
fn an_object_must_start_outside_the_finger() {
    let inside = scene("shape = \"disc\"\nradius_mm = 10\npath_mm = [[50, 20], [50, 10]]");
    let outcome = prepared(&inside).with_fineness(COARSE).run(|_| ());
    assert!(matches!(outcome, Err(LatticeError::Overlap { .. })), "{outcome:?}");
    // The first touch of a press is no overlap, wherever and however it goes.
    for (at_mm, direction_deg) in [(0.0, 0.0), (70.0, 60.0), (70.0, -60.0), (153.0, 20.0)] {
        let object = format!(
            "shape = \"disc\"\nradius_mm = 10\nat_mm = {at_mm}\ndirection_deg = {direction_deg}\ntravel_mm = 0.01\nsteps = 1"
        );
        let scene = scene(&object);
        steps(&prepared(&scene).with_fineness(COARSE));
        let along = scene.finger.direction(direction_deg);
        let start = prepared(&scene).object().start;
        let line = scene.finger.plate_point(Plate::Front, at_mm) - start;
        assert!(line.perp(&along).abs() < 1e-9, "the line meets the place");
    }
}
