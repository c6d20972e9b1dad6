//! Objects that touch a finger elsewhere than on its front plate: on the back plate, at the tip and the base, and between ribs.

use finray_contact::outline::ContactOutline;
use finray_contact::pressing::{Pressed, Pressing, Push};
use finray_contact::{ContactError, Touch, TouchedPart, Wall};
use finray_model::finger::Plate;
use finray_model::frame::{FrameLoad, PlaneFrame};
use finray_model::statics::Statics;
use finray_model::{Finger, Kinematics, Mesh, Vector};
use finray_tests::{finger_of, mirrored, paper};

/// Two solutions of the same contact problem differ by less than this share; Newton's method converges to rounding.
const SAME: f64 = 1e-6;

/// Presses an object along a straight path, and returns finger and object at its end.
fn pressed(
    mesh: &Mesh,
    rod_radius_mm: f64,
    object: (ContactOutline, f64),
    [from, to]: [Vector; 2],
) -> Result<Pressed, ContactError> {
    let along = (to - from).normalize();
    Pressing::new(mesh, rod_radius_mm, object, from, along)?.push(Push::To(to))
}

fn flipped(vector: Vector) -> Vector {
    Vector::new(vector.x, -vector.y)
}

/// A path that starts `gap_mm` above the surface of a plate, measured along the plate's normal, and ends `depth_mm` below it.
fn path(finger: &Finger, plate: Plate, s_mm: f64, reach_mm: f64, [gap_mm, depth_mm]: [f64; 2]) -> [Vector; 2] {
    let (at, inward) = (finger.plate_point(plate, s_mm), finger.inward(plate));
    let surface_mm = reach_mm + 0.5 * finger.thickness_mm(plate, s_mm);
    [at - inward * (surface_mm + gap_mm), at - inward * (surface_mm - depth_mm)]
}

/// Fingers with different plates, with rods or not.
fn fingers() -> [Finger; 2] {
    let text = finray_fixtures::PAPER_SCENE.replace("back_length_mm = 153.0", "back_length_mm = 149.0");
    [paper(), finger_of(&text.replacen("thickness_mm = 1.5", "thickness_mm = 1.2", 1))]
}

/// The back plate of a finger responds like the front plate of the finger's mirror image, to discs and corners, with and without friction, also near the
/// tip.
#[test]
fn the_back_plate_is_the_front_plate_of_the_mirror_image() {
    let square = ContactOutline::polygon(&[[-6.0, -6.0], [6.0, -6.0], [6.0, 6.0], [-6.0, 6.0]].map(Vector::from));
    let turn = nalgebra::Rotation2::new(0.3).into_inner();
    for (finger, s_mm) in fingers().into_iter().flat_map(|finger| [(finger.clone(), 81.0), (finger, 144.0)]) {
        for (shape, friction) in
            [(ContactOutline::disc(12.0), 0.0), (ContactOutline::disc(12.0), 0.3), (square.mapped(turn), 0.0)]
        {
            let image = mirrored(&finger);
            let ways = path(&image, Plate::Front, s_mm, shape.reach_mm(image.inward(Plate::Front), 0.0), [1.0, 6.0]);
            let [ours, theirs] = [(&finger, true), (&image, false)].map(|(finger, is_back)| {
                let mesh = Mesh::with_elements_per_member(finger, 3);
                let flip = nalgebra::Matrix2::new(1.0, 0.0, 0.0, if is_back { -1.0 } else { 1.0 });
                let ways = ways.map(|at| flip * at);
                pressed(&mesh, 0.0, (shape.mapped(flip), friction), ways).expect("an equilibrium")
            });
            let (force, expected) = (ours.contact_force(), flipped(theirs.contact_force()));
            assert!(expected.norm() > 0.05, "{expected:?}");
            assert!((force - expected).norm() < SAME * expected.norm(), "{s_mm}: {force:?} for {expected:?}");
            assert_eq!(ours.touches.len(), theirs.touches.len());
            for touch in &ours.touches {
                assert!(matches!(touch.part, TouchedPart::On(Wall::Back, _)) || s_mm > 143.0, "{:?}", touch.part);
            }
            assert!(ours.imbalance().expect("contact") < SAME, "{:?}", ours.imbalance());
        }
    }
}

/// Compliance along a unit vector of a mesh node of the linear finger, mm/N, by the sparse solver.
fn compliance(mesh: &Mesh, node: usize, along: Vector) -> f64 {
    let frame: &PlaneFrame = mesh.frame();
    let load = FrameLoad::Node { node, force: along, moment_nmm: 0.0 };
    let found = Statics::sparse(frame, Kinematics::Linear).equilibrium(&[load]).expect("a linear finger");
    found.motion.displacements[node].dot(&along)
}

/// A small disc between two ribs presses on the middle of each of the four walls of its cell. For a small travel, force and travel are related by the
/// compliance of the linear finger, which an independent solver computes. Contact forces, the hand's force and the forces on the clamps balance.
#[test]
fn walls_between_ribs_yield_like_the_linear_finger() {
    const CELL: usize = 5;
    const TRAVEL_MM: f64 = 0.02;
    const NONLINEAR: f64 = 5e-3;
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    let members = finger.rib_count() + 1;
    let at = |node: usize| mesh.frame().position(node);
    let corners = [(Plate::Back, CELL), (Plate::Back, CELL + 1), (Plate::Front, CELL + 1), (Plate::Front, CELL)];
    let centre = corners.map(|(plate, level)| finger.plate_point(plate, finger.plate_positions_mm(plate)[level]));
    let centre: Vector = centre.iter().sum::<Vector>() / 4.0;
    let walls = [
        (Wall::Back, CELL),
        (Wall::Front, members + CELL),
        (Wall::Rib(CELL - 1), 2 * members + CELL - 1),
        (Wall::Rib(CELL), 2 * members + CELL),
    ];
    for (wall, line) in walls {
        let nodes = &mesh.lines()[line].nodes;
        let node = nodes[nodes.len() / 2];
        let along = (at(nodes[nodes.len() - 1]) - at(nodes[0])).normalize();
        let normal = Vector::new(-along.y, along.x);
        let normal = if normal.dot(&(at(node) - centre)) > 0.0 { normal } else { -normal };
        let radius_mm = 2.0;
        let touching = at(node) - normal * (radius_mm + 0.75);
        let ways = [touching - normal * 0.1, touching + normal * TRAVEL_MM];
        let found = pressed(&mesh, 0.0, (ContactOutline::disc(radius_mm), 0.0), ways).expect("an equilibrium");
        let is_there = |touch: &Touch| matches!(touch.part, TouchedPart::On(touched, _) if touched == wall);
        assert!(!found.touches.is_empty() && found.touches.iter().all(is_there), "{wall:?}: {:?}", found.touches);
        let expected_n = TRAVEL_MM / compliance(&mesh, node, normal);
        let force_n = found.contact_force().dot(&normal);
        assert!((force_n / expected_n - 1.0).abs() < NONLINEAR, "{wall:?}: {force_n} N, linear {expected_n} N");
        assert!(found.imbalance().expect("contact") < SAME, "{:?}", found.imbalance());
        let moment_nmm = found.contact_moment_nmm();
        assert!((found.base_moment_nmm - moment_nmm).abs() < SAME * moment_nmm.abs().max(1.0), "{wall:?}");
    }
}

/// An object that moves between the plates from below stops at the base, and an object that is pushed down from inside stops there, too.
#[test]
fn the_base_stops_an_object_on_both_sides() {
    let mesh = Mesh::with_elements_per_member(&paper(), 2);
    for (from_mm, to_mm) in [(-20.0, 30.0), (6.0, -30.0)] {
        let ways = [from_mm, to_mm].map(|x_mm| Vector::new(x_mm, 2.0));
        let found = pressed(&mesh, 1.5, (ContactOutline::disc(5.0), 0.2), ways).expect("an equilibrium");
        let expected_mm = if from_mm < 0.0 { -5.0 } else { 5.0 };
        assert!((found.object.x - expected_mm).abs() < 1e-6, "{:?}", found.object);
    }
}

/// An object once gave 0 N in silence if it started among the ribs, or across a plate.
#[test]
fn an_object_across_a_wall_is_refused() {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, 2);
    let refused = |at: Vector, radius_mm: f64| {
        pressed(&mesh, 1.5, (ContactOutline::disc(radius_mm), 0.0), [at, at + Vector::x()])
            .map(|_| ())
            .expect_err("an overlap")
    };
    let back = refused(finger.plate_point(Plate::Back, 60.0), 4.0);
    let ContactError::Overlap { part: Some(TouchedPart::On(Wall::Back, s_mm)), overlap_mm } = back else {
        panic!("{back:?}")
    };
    assert!((s_mm - 60.0).abs() < 1.0 && (overlap_mm - 4.75).abs() < 1e-9, "{back}");
    let on_rib = 0.5 * (finger.position(finger.rib_nodes(3)[0]) + finger.position(finger.rib_nodes(3)[1]));
    let rib = refused(on_rib, 1.0);
    assert!(matches!(rib, ContactError::Overlap { part: Some(TouchedPart::On(Wall::Rib(3), _)), .. }), "{rib:?}");
    // A box that covers the plates has no corner near them.
    let wide = ContactOutline::polygon(&[[-20.0, -60.0], [20.0, -60.0], [20.0, 60.0], [-20.0, 60.0]].map(Vector::from));
    let ways = [Vector::new(60.0, 0.0), Vector::new(61.0, 0.0)];
    let wide = pressed(&mesh, 1.5, (wide, 0.0), ways).map(|_| ()).expect_err("an overlap");
    assert!(matches!(wide, ContactError::Overlap { .. }), "{wide:?}");
}

/// A back plate that is thicker than the front plate reaches through the surface of the front plate at the tip. An object on the front plate does not
/// touch it there.
#[test]
fn a_thick_back_plate_is_not_touched_from_the_front() {
    let text =
        finray_fixtures::PAPER_SCENE.replace("[finger.back]\nthickness_mm = 1.5", "[finger.back]\nthickness_mm = 4.0");
    let finger = finger_of(&text);
    let mesh = Mesh::with_elements_per_member(&finger, 2);
    let (along, inward) = (finger.front_tangent(), finger.inward(Plate::Front));
    let corners = [[-15.0, 0.0], [15.0, 0.0], [15.0, -10.0], [-15.0, -10.0]];
    let shape = ContactOutline::polygon(&corners.map(|[x, y]| along * x + inward * y));
    let at = finger.plate_point(Plate::Front, 145.0) - inward * 0.75;
    let found = pressed(&mesh, 0.0, (shape, 0.0), [at, at + inward * 2.0]).expect("an equilibrium");
    assert!(!found.touches.is_empty());
    let is_front = |touch: &Touch| matches!(touch.part, TouchedPart::On(Wall::Front, _));
    assert!(found.touches.iter().all(is_front), "{:?}", found.touches);
}

/// Contact with hinged ribs and with a tapered back plate is not modelled: an object that reaches them is refused, and an object that does not is not.
#[test]
fn a_wall_without_a_contact_model_is_named() {
    let hinged = finger_of(&finray_fixtures::PAPER_SCENE.replace("joints = \"rigid\"", "joints = \"hinged\""));
    let mesh = Mesh::with_elements_per_member(&hinged, 2);
    let centre = 0.5 * (hinged.position(hinged.rib_nodes(4)[0]) + hinged.position(hinged.rib_nodes(4)[1]));
    let start = centre + Vector::new(6.0, 0.0);
    let press = |to: Vector| pressed(&mesh, 1.5, (ContactOutline::disc(2.0), 0.0), [start, to]);
    assert!(press(start - Vector::x()).expect("no contact").touches.is_empty());
    let outcome = press(start - Vector::x() * 6.0).map(|_| ());
    assert!(matches!(outcome, Err(ContactError::Unmodelled { part: TouchedPart::On(Wall::Rib(4), _) })), "{outcome:?}");
}
