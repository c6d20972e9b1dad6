//! Pressed objects: presses on beams compared with the physics engine rapier, which finds the contacts of the object with the lattice on its own.

use finray_contact::Touch;
use finray_contact::outline::Shape;
use finray_contact::pressing::{Pressed, Pressing, Push};
use finray_lattice::Lattice;
use finray_lattice::engine_pressing::{EnginePressing, RigidObject};
use finray_model::finger::Plate;
use finray_model::{Finger, Mesh, Vector};
use finray_tests::{paper, shapes_apart};
use rapier2d::prelude::SharedShape;

const ROD_RADIUS_MM: f64 = 1.5;

/// A disc above a position on the front plate, pressed at an angle from its inward normal.
struct Disc {
    radius_mm: f64,
    friction: f64,
    at_mm: f64,
    direction_deg: f64,
}

impl Disc {
    fn along(&self, finger: &Finger) -> Vector {
        finger.direction(self.direction_deg)
    }

    /// Position, mm, at which the disc first touches the line that is tangent to the rods.
    fn start(&self, finger: &Finger) -> Vector {
        let along = self.along(finger);
        let way_mm = (self.radius_mm + ROD_RADIUS_MM) / along.dot(&finger.direction(0.0));
        finger.plate_point(Plate::Front, self.at_mm) - along * way_mm
    }

    fn pressing<'m>(&self, mesh: &'m Mesh) -> Pressing<'m> {
        let (start, along) = (self.start(mesh.finger()), self.along(mesh.finger()));
        Pressing::new(mesh, ROD_RADIUS_MM, (Shape::disc(self.radius_mm), self.friction), start, along)
            .expect("the disc starts outside the finger")
    }

    fn engine<'l>(&self, lattice: &'l Lattice) -> EnginePressing<'l> {
        let (start, along) = (self.start(lattice.finger()), self.along(lattice.finger()));
        let rigid = RigidObject { shape: SharedShape::ball(self.radius_mm), friction: self.friction };
        EnginePressing::new(lattice, ROD_RADIUS_MM, &rigid, start, along).expect("the disc starts outside the finger")
    }

    fn at(&self, finger: &Finger, travel_mm: f64) -> Push {
        Push::To(self.start(finger) + self.along(finger) * travel_mm)
    }
}

const SMOOTH: Disc = Disc { radius_mm: 20.0, friction: 0.0, at_mm: 74.0, direction_deg: 0.0 };
const ROUGH: Disc = Disc { radius_mm: 15.0, friction: 0.3, at_mm: 76.5, direction_deg: 30.0 };

/// Tolerance for the errors of rapier's sweeps and of its criterion of rest, and for the discretisation of the lattice, as a share of the force and of
/// the largest displacement.
const ENGINE_TOLERANCE: f64 = 2e-3;
/// Number of segments per plate member of the lattice. The next constant is the number of elements of each member.
const FINENESS: usize = 4;
const ELEMENTS: usize = 4;

fn assert_alike(ours: &Pressed, engine: &Pressed) {
    let (force, other) = (ours.contact_force(), engine.contact_force());
    assert!((force - other).norm() <= ENGINE_TOLERANCE * force.norm(), "{force:?} and {other:?}");
    let apart = shapes_apart(&ours.shape, &engine.shape);
    assert!(apart <= ENGINE_TOLERANCE, "{apart}");
}

/// The physics engine rapier presses the object from a position without contact, either to a point or with a force. It reaches the same equilibrium
/// as Newton's method on beams.
#[test]
fn rapier_on_its_own_way_rests_where_the_beams_are() {
    let (mesh, lattice) = models();
    for push in [SMOOTH.at(lattice.finger(), 5.0), Push::With(1.0)] {
        let ours = SMOOTH.pressing(&mesh).push(push).expect("an equilibrium");
        let engine = SMOOTH.engine(&lattice).push(push).expect("it settles");
        assert_alike(&ours, &engine);
    }
}

/// With friction, the state of rest is not unique, so rapier has no say. The lattice's equilibrium under the contact forces that were found on beams has
/// the shape of the beams; without the friction of these forces, it has another shape.
#[test]
fn the_lattice_bends_as_the_beams_do_under_friction() {
    let (mesh, lattice) = models();
    let mut pressing = ROUGH.pressing(&mesh);
    for travel_mm in [4.0, 10.0] {
        let found = pressing.push(ROUGH.at(lattice.finger(), travel_mm)).expect("an equilibrium");
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
