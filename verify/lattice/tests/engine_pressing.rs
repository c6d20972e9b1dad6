//! Pressed objects: presses on beams compared with the physics engine rapier, which finds the contacts of the object with the lattice on its own.

use finray_contact::path::PreparedObject;
use finray_contact::pressing::{Pressed, Pressing, Push};
use finray_contact::{Touch, TouchedPart, Wall};
use finray_lattice::Lattice;
use finray_lattice::engine_pressing::EnginePressing;
use finray_model::scene::ROD_RADIUS_MM;
use finray_model::{Mesh, Vector};
use finray_tests::{paper, paper_scene_with, shapes_apart};

const SMOOTH: &str = "[object]\nshape = \"disc\"\nradius_mm = 20\nat_mm = 74\ntravel_mm = 1";
const ROUGH: &str =
    "[object]\nshape = \"disc\"\nradius_mm = 15\nfriction = 0.3\nat_mm = 76.5\ndirection_deg = 30\ntravel_mm = 1";

fn object_of(object: &str) -> PreparedObject {
    let scene = paper_scene_with(&[("[finger.ribs]", &format!("{object}\n[finger.ribs]"))]);
    PreparedObject::new(&scene, scene.object.as_ref().expect("an object"), &[]).expect("an outline")
}

fn pressing<'m>(object: &PreparedObject, mesh: &'m Mesh) -> Pressing<'m> {
    let rigid = (object.outline.clone(), object.friction);
    Pressing::new(mesh, ROD_RADIUS_MM, rigid, object.start, object.along).expect("no overlap")
}

fn engine<'l>(object: &PreparedObject, lattice: &'l Lattice) -> EnginePressing<'l> {
    EnginePressing::new(lattice, ROD_RADIUS_MM, object).expect("no overlap")
}

fn at(object: &PreparedObject, travel_mm: f64) -> Push {
    Push::To(object.start + object.along * travel_mm)
}

/// Tolerance for the errors of rapier's sweeps and of its criterion of rest, and for the discretisation of the lattice, as a share of the force and of
/// the largest displacement.
const ENGINE_TOLERANCE: f64 = 2e-3;
/// Number of segments per plate member of the lattice. The next constant is the number of elements of each member.
const FINENESS: usize = 4;
const ELEMENTS: usize = 4;

/// Same as [`ENGINE_TOLERANCE`], for contact on a plate without rods. The engine's plate is a chain of straight capsules, so the direction of the force is
/// off by half the angle between two segments of the bent plate at most: with four segments per member, 0.01 rad.
const CHAIN_TOLERANCE: f64 = 1e-2 + ENGINE_TOLERANCE;

fn assert_alike(ours: &Pressed, engine: &Pressed, tolerance: f64) {
    let (force, other) = (ours.contact_force(), engine.contact_force());
    assert!((force - other).norm() <= tolerance * force.norm(), "{force:?} and {other:?}");
    let apart = shapes_apart(&ours.shape, &engine.shape);
    assert!(apart <= tolerance, "{apart}");
}

/// The physics engine rapier presses the object from a position without contact, either to a point or with a force. It reaches the same equilibrium
/// as Newton's method on beams.
#[test]
fn rapier_on_its_own_way_rests_where_the_beams_are() {
    let ((mesh, lattice), smooth) = (models(), object_of(SMOOTH));
    for push in [at(&smooth, 5.0), Push::With(1.0)] {
        let ours = pressing(&smooth, &mesh).push(push).expect("an equilibrium");
        let engine = engine(&smooth, &lattice).push(push).expect("it settles");
        assert_alike(&ours, &engine, ENGINE_TOLERANCE);
    }
}

/// On the back plate, rapier reaches the same equilibrium as Newton's method on beams, too.
#[test]
fn rapier_rests_where_the_beams_are_on_the_back_plate() {
    let ((mesh, lattice), smooth) = (models(), object_of(SMOOTH));
    let flip = |vector: Vector| Vector::new(vector.x, -vector.y);
    let behind = PreparedObject { start: flip(smooth.start), along: flip(smooth.along), ..smooth };
    // The back plate has no rods.
    let travel_mm = 5.0 + ROD_RADIUS_MM - 0.75;
    let ours = pressing(&behind, &mesh).push(at(&behind, travel_mm)).expect("an equilibrium");
    assert!(ours.touches.iter().all(|touch| matches!(touch.part, TouchedPart::On(Wall::Back, _))));
    let engine = engine(&behind, &lattice).push(at(&behind, travel_mm)).expect("it settles");
    assert_alike(&ours, &engine, CHAIN_TOLERANCE);
}

/// With friction, the state of rest is not unique, so rapier has no say. The lattice's equilibrium under the contact forces that were found on beams has
/// the shape of the beams; without the friction of these forces, it has another shape.
#[test]
fn the_lattice_bends_as_the_beams_do_under_friction() {
    let ((mesh, lattice), rough) = (models(), object_of(ROUGH));
    let mut pressing = pressing(&rough, &mesh);
    for travel_mm in [4.0, 10.0] {
        let found = pressing.push(at(&rough, travel_mm)).expect("an equilibrium");
        let apart = |touches: &[Touch]| {
            let loads = lattice.contact_loads(touches, &found.shape).expect("loads on the plate");
            let motions = lattice.motions_under(&loads).expect("an equilibrium of the lattice");
            shapes_apart(&found.shape, &lattice.shape(&motions))
        };
        let smooth = |touch: &Touch| Touch { force: touch.normal * touch.force.dot(&touch.normal), ..*touch };
        let smooth: Vec<Touch> = found.touches.iter().map(smooth).collect();
        let (near, far) = (apart(&found.touches), apart(&smooth));
        assert!(near <= ENGINE_TOLERANCE && far > 5.0 * ENGINE_TOLERANCE, "{near} and {far}");
    }
}

fn models() -> (Mesh, Lattice) {
    (Mesh::with_elements_per_member(&paper(), ELEMENTS), Lattice::new(&paper(), FINENESS).expect("a lattice"))
}
