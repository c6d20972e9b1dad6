//! Sensing of contact with an object of known shape, whose pose determines position and direction of the force.
//!
//! The true case is built in reverse: a force along the deformed normal bends the finger, then the object is placed in contact.

use finray_model::finger::Plate;
use finray_model::measurement::{BaseUncertainty, Marker, Measurement};
use finray_model::mesh::Load;
use finray_model::sensing::{
    ContactQuestion, Direction, Lean, NonlinearEstimate, NonlinearEstimator, Normal, NotConvex, Pad, SensingError,
    TouchedObject, TouchedOutline,
};
use finray_model::statics::Statics;
use finray_model::{Finger, Kinematics, Mesh, NodeId, Vector};
use finray_tests::{ELEMENTS, TWO_SIDED_95, assert_standardised, case_count, finger_of, noisy};
use nalgebra::{Isometry2, Rotation2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Elements per member of the mesh that computes the true shape.
const FINE: usize = 32;
/// Largest relative difference between forces on the mesh of the true shape and forces on the mesh of the estimator.
const MESHES: f64 = 1e-3;

fn bracketed() -> Finger {
    finger_of(finray_fixtures::BRACKETED_SCENE)
}

fn shapes() -> [TouchedOutline; 3] {
    let corners = [[-25.0, -15.0], [20.0, -18.0], [24.0, 12.0], [-5.0, 22.0]].map(Vector::from);
    [
        TouchedOutline::Disc { radius_mm: 30.0 },
        TouchedOutline::Ellipse { semi_axes_mm: [36.0, 22.0] },
        TouchedOutline::polygon(corners.to_vec()).expect("convex"),
    ]
}

/// Point of the unrotated outline at which `normal` is the outward normal.
fn outline_point(shape: &TouchedOutline, normal: Vector) -> Vector {
    match shape {
        TouchedOutline::Disc { radius_mm } => normal * *radius_mm,
        TouchedOutline::Ellipse { semi_axes_mm: [a, b] } => {
            Vector::new(a * a * normal.x, b * b * normal.y) / (a * normal.x).hypot(b * normal.y)
        }
        // The corner that is farthest in the direction of the normal.
        TouchedOutline::Polygon { corners } => {
            *corners.iter().max_by(|p, q| p.dot(&normal).total_cmp(&q.dot(&normal))).expect("corners")
        }
    }
}

/// A rotation with which an object touches the plate at one point. A polygon touches the plate with a corner, and none of its sides is parallel to
/// the plate.
fn turn_rad(shape: &TouchedOutline, finger: &Finger, any_rad: f64) -> f64 {
    let TouchedOutline::Polygon { corners } = shape else { return any_rad };
    let [before, corner, after] = [0, 1, 2].map(|i| corners[i]);
    let outward = (corner - before).normalize() + (corner - after).normalize();
    let inward = finger.direction(0.0);
    inward.y.atan2(inward.x) - outward.y.atan2(outward.x) + 0.1 * any_rad
}

/// A finger pressed by an object.
struct Pressed {
    seen: Measurement,
    s_mm: f64,
    pose: Isometry2<f64>,
}

/// Applies a force that leans from the normal of the deformed plate at a node of the fine mesh, and places the object in contact at this node.
fn pressed(
    mesh: &Mesh,
    at: f64,
    force_n: f64,
    lean_deg: f64,
    shape: &TouchedOutline,
    turn_rad: f64,
    pad_mm: f64,
) -> Pressed {
    let finger = mesh.finger();
    let (tangent, base) = (finger.front_tangent(), finger.plate_point(Plate::Front, 0.0));
    let is_front = |line: &&finray_model::mesh::Line| {
        let apart = |node: usize| tangent.perp(&(mesh.frame().position(node) - base)).abs();
        line.nodes.iter().all(|node| apart(*node) < 1e-6)
    };
    let nodes = mesh.lines().iter().filter(is_front).flat_map(|line| line.nodes.clone());
    let along_mm = |node: usize| tangent.dot(&(mesh.frame().position(node) - base));
    let node = nodes.min_by(|a, b| (along_mm(*a) - at).abs().total_cmp(&(along_mm(*b) - at).abs())).expect("nodes");
    let s_mm = along_mm(node);
    let mut statics = Statics::ladder(mesh, Kinematics::Corotational);
    let mut turned_deg = 0.0;
    let mut motion = None;
    for _ in 0..40 {
        let force = finger.direction(lean_deg + turned_deg) * force_n;
        // On a pad, friction acts at a distance from the plate, so cases with a thick pad have no friction.
        let load = mesh.frame_load(&Load::at_position(s_mm, force)).expect("on the plate");
        let found = statics.equilibrium(&[load]).expect("carried").motion;
        turned_deg = found.rotations[mesh.frame().rotation_of(node)].to_degrees();
        motion = Some(found);
    }
    let motion = motion.expect("iterated");
    let normal = finger.direction(turned_deg);
    let turn = Rotation2::new(turn_rad);
    let touching = mesh.frame().position(node) + motion.displacements[node];
    let reach_mm = pad_mm + 0.5 * finger.description().front.thickness_mm;
    let origin = touching - normal * reach_mm - turn * outline_point(shape, turn.inverse() * normal);
    Pressed { seen: Measurement::of_shape(finger, &mesh.shape(&motion)), s_mm, pose: Isometry2::new(origin, turn_rad) }
}

fn question(lean: Lean) -> ContactQuestion {
    ContactQuestion::new(None, Direction::Leaning(Lean { from: Normal::Object, ..lean }))
}

fn sense(
    mesh: &Mesh,
    question: ContactQuestion,
    object: &TouchedObject,
    seen: &Measurement,
    noise_mm: f64,
) -> Result<NonlinearEstimate, SensingError> {
    let estimator = NonlinearEstimator::new(mesh, &[question]).expect("one contact").with_object(Some(object));
    estimator.clone().estimate(seen, Some(noise_mm))
}

/// Force and position are recovered with known friction, for any shape and rotation of the object.
#[test]
fn objects_show_place_and_direction() {
    let finger = bracketed();
    let (fine, mesh) = (Mesh::with_elements_per_member(&finger, FINE), Mesh::with_elements_per_member(&finger, 16));
    for shape in shapes() {
        for (at, force_n, friction, turn_rad) in [(72.0, 4.0, 0.0, 0.3), (58.0, 6.0, 0.3, -0.8), (90.0, 2.0, -0.2, 2.0)]
        {
            let (lean, turn_rad) = (Lean::of_friction(friction, 0.0), self::turn_rad(&shape, &finger, turn_rad));
            let truth = pressed(&fine, at, force_n, lean.angle_deg, &shape, turn_rad, 0.0);
            let object = TouchedObject { shape: shape.clone(), pose: truth.pose, sd_mm: 0.0, sd_rad: 0.0 };
            let found = sense(&mesh, question(lean), &object, &truth.seen, 1e-3).expect("identifiable");
            let off = found.forces.forces_n[0] / force_n - 1.0;
            assert!(off.abs() < MESHES, "{shape:?} at {at}: {off}");
            let found_mm = found.contacts[0].position_mm(&finger).expect("on the plate");
            assert!((found_mm - truth.s_mm).abs() < 0.05, "{shape:?}: {found_mm}, {}", truth.s_mm);
        }
    }
}

/// Errors are as large as stated. Noise, position and rotation of the object, and friction are drawn with their stated standard deviations.
#[test]
fn stated_sigmas_hold_what_the_objects_pose_leaves_open() {
    const NOISE_MM: f64 = 0.02;
    const SD_MM: f64 = 0.3;
    const SD_RAD: f64 = 0.02;
    let cases = case_count(30, 300);
    let finger = bracketed();
    let (fine, mesh) = (Mesh::with_elements_per_member(&finger, 8), Mesh::with_elements_per_member(&finger, ELEMENTS));
    for ((shape, friction_sd), name) in shapes().into_iter().zip([0.0, 0.05, 0.0]).zip(["disc", "ellipse", "polygon"]) {
        let mut rng = ChaCha8Rng::seed_from_u64(19);
        let lean = Lean::of_friction(0.2, friction_sd);
        let mut errors = Vec::new();
        for _ in 0..cases {
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let lean_deg = lean.angle_deg + lean.sd_deg * normal();
            let (off, off_rad) = (Vector::new(normal(), normal()) * SD_MM, normal() * SD_RAD);
            let turn_rad = turn_rad(&shape, &finger, rng.random_range(-3.0..3.0));
            let (at, force_n) = (rng.random_range(50.0..95.0), rng.random_range(1.5..7.0));
            let truth = pressed(&fine, at, force_n, lean_deg, &shape, turn_rad, 0.0);
            let pose = Isometry2::new(truth.pose.translation.vector + off, turn_rad + off_rad);
            let object = TouchedObject { shape: shape.clone(), pose, sd_mm: SD_MM, sd_rad: SD_RAD };
            let seen = noisy(&truth.seen, NOISE_MM, &mut rng);
            let found = match sense(&mesh, question(lean), &object, &seen, NOISE_MM) {
                Ok(found) => found,
                Err(error) => {
                    println!("{shape:?} at {at} with {force_n}: {error}");
                    continue;
                }
            };
            errors.push((found.forces.forces_n[0] - force_n) / found.forces.sigmas_n[0]);
        }
        assert!(errors.len() * 100 >= cases * 97, "{shape:?}: {} of {cases} answered", errors.len());
        assert_standardised(&format!("sensing::object {name}"), &errors);
    }
}

/// The square of the stated standard deviation is the sum of the squared responses of the force to the noise of each coordinate and to the errors of
/// the pose.
#[test]
fn sigmas_are_responses_to_noise_and_pose() {
    const NOISE_MM: f64 = 0.02;
    const SD_MM: f64 = 0.1;
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let (shape, lean) = (TouchedOutline::Disc { radius_mm: 30.0 }, Lean::of_friction(0.3, 0.0));
    let truth = pressed(&mesh, 72.0, 7.0, lean.angle_deg, &shape, 0.0, 0.0);
    let sensed = |moved: Option<(NodeId, Vector)>, off: Vector| {
        let marker = |marker: &Marker| match moved {
            Some((node, by)) if node == marker.node => Marker { displacement: marker.displacement + by, ..*marker },
            _ => *marker,
        };
        let seen = Measurement::new(&finger, truth.seen.markers().iter().map(marker)).expect("the same nodes");
        let pose = Isometry2::new(truth.pose.translation.vector + off, 0.0);
        let object = TouchedObject { shape: shape.clone(), pose, sd_mm: SD_MM, sd_rad: 0.0 };
        sense(&mesh, question(lean), &object, &seen, NOISE_MM).expect("identifiable").forces
    };
    let stated = sensed(None, Vector::zeros()).sigmas_n[0];
    let response = |step_mm: f64, of: &dyn Fn(f64) -> f64| (of(step_mm) - of(-step_mm)) / (2.0 * step_mm);
    let mut variance = 0.0;
    for way in [Vector::x(), Vector::y()] {
        let to_pose = response(0.1 * SD_MM, &|by| sensed(None, way * by).forces_n[0]);
        variance += (to_pose * SD_MM).powi(2);
        for marker in truth.seen.markers() {
            let to_noise =
                response(0.1 * NOISE_MM, &|by| sensed(Some((marker.node, way * by)), Vector::zeros()).forces_n[0]);
            variance += (to_noise * NOISE_MM).powi(2);
        }
    }
    let responses = variance.sqrt();
    // Forces converge to a hundredth of their standard deviation. The stated deviation also includes the tolerance of a closed contact, 0.01 mm.
    assert!((stated / responses - 1.0).abs() < 0.02, "stated {stated} N, responses {responses} N");
}

/// A pad separates the outline from the plate by the pad's thickness.
#[test]
fn an_object_touches_the_pad() {
    let finger = bracketed();
    let (fine, mesh) = (Mesh::with_elements_per_member(&finger, FINE), Mesh::with_elements_per_member(&finger, 16));
    let shape = TouchedOutline::Disc { radius_mm: 30.0 };
    let pad = Pad { length_mm: 0.0, thickness_mm: 3.0 };
    let truth = pressed(&fine, 72.0, 4.0, 0.0, &shape, 0.0, pad.thickness_mm);
    let object = TouchedObject { shape, pose: truth.pose, sd_mm: 0.05, sd_rad: 0.0 };
    let sensed = |pad: Pad| {
        let question = ContactQuestion { pad: Some(pad), ..question(Lean::NONE) };
        let estimator = NonlinearEstimator::new(&mesh, &[question]).expect("one contact");
        estimator.with_object(Some(&object)).estimate(&truth.seen, Some(0.01))
    };
    let found = sensed(pad).expect("identifiable");
    assert!((found.forces.forces_n[0] / 4.0 - 1.0).abs() < MESHES, "{found:?}");
    let refused = sensed(Pad::default());
    assert!(
        matches!(refused, Err(SensingError::NotTouching { gap_mm, .. }) if (gap_mm - 3.0).abs() < 0.1),
        "{refused:?}"
    );
}

/// For friction within a wide range, forces are returned, and intervals contain the true forces.
#[test]
fn a_wide_range_of_friction_is_answered() {
    const NOISE_MM: f64 = 0.06;
    let finger = bracketed();
    let (fine, mesh) = (Mesh::with_elements_per_member(&finger, 8), Mesh::with_elements_per_member(&finger, ELEMENTS));
    let shape = TouchedOutline::Disc { radius_mm: 30.0 };
    let lean = Lean::within([0.0, 0.6]);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut within = 0;
    for (at, force_n, friction) in
        [(66.0, 1.2, 0.1), (66.0, 4.0, 0.3), (68.0, 9.0, 0.4), (70.0, 12.6, 0.45), (80.0, 6.0, 0.2)]
    {
        let truth = pressed(&fine, at, force_n, f64::atan(friction).to_degrees(), &shape, 0.0, 0.0);
        let object = TouchedObject { shape: shape.clone(), pose: truth.pose, sd_mm: 0.4, sd_rad: 0.0 };
        let seen = noisy(&truth.seen, NOISE_MM, &mut rng);
        let base = BaseUncertainty { sd_mm: 1.0, sd_rad: 0.02, ..BaseUncertainty::default() };
        let found = sense(&mesh, question(lean), &object, &seen.with_base(base), NOISE_MM);
        let forces = found.expect("identifiable").forces;
        within += usize::from((forces.forces_n[0] - force_n).abs() < TWO_SIDED_95 * forces.sigmas_n[0]);
    }
    assert!(within >= 4, "{within} of 5");
}

/// An object at a wrong position is refused, whether it is away from the plate or inside the finger.
#[test]
fn an_object_that_cannot_touch_is_refused() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let shape = TouchedOutline::Disc { radius_mm: 30.0 };
    let truth = pressed(&mesh, 72.0, 4.0, 0.0, &shape, 0.0, 0.0);
    for off_mm in [2.0, -2.0] {
        let pose = Isometry2::new(truth.pose.translation.vector - finger.direction(0.0) * off_mm, 0.0);
        let object = TouchedObject { shape: shape.clone(), pose, sd_mm: 0.1, sd_rad: 0.0 };
        let refused = sense(&mesh, question(Lean::NONE), &object, &truth.seen, 0.02);
        assert!(
            matches!(refused, Err(SensingError::NotTouching { contact: 1, gap_mm, .. }) if gap_mm * off_mm > 0.0),
            "{refused:?}"
        );
    }
    let lost =
        NonlinearEstimator::new(&mesh, &[question(Lean::NONE)]).expect("one contact").estimate(&truth.seen, Some(0.02));
    assert_eq!(lost, Err(SensingError::NoObject { contact: 1 }));
}

fn polygon(corners: &[[f64; 2]]) -> Result<TouchedOutline, NotConvex> {
    TouchedOutline::polygon(corners.iter().map(|c| Vector::new(c[0], c[1])).collect())
}

#[test]
fn polygons_are_convex() {
    for wrong in [
        &[[0.0, 0.0], [1.0, 0.0]][..],
        &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]],
        &[[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]],
        &[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        // A star of five points.
        &[[0.0, 1.0], [-0.588, -0.809], [0.951, 0.309], [-0.951, 0.309], [0.588, -0.809]],
    ] {
        assert_eq!(polygon(wrong), Err(NotConvex), "{wrong:?}");
    }
    assert!(polygon(&[[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]).is_ok());
}
