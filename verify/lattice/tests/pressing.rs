//! Pressed objects: equilibria compared with rapier, statics, and an independent contact solution with frame elements.

use finray_lattice::Lattice;
use finray_lattice::grasp::surface::Shape;
use finray_lattice::pressing::settled::{EnginePressing, RigidObject};
use finray_lattice::pressing::{Pressed, Pressing, Push};
use finray_model::finger::Plate;
use finray_model::{Finger, Vector};
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

    fn pressing<'l>(&self, lattice: &'l Lattice) -> Pressing<'l> {
        let (start, along) = (self.start(lattice.finger()), self.along(lattice.finger()));
        Pressing::new(lattice, ROD_RADIUS_MM, (Shape::disc(self.radius_mm), self.friction), start, along)
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

    /// Presses the disc to each travel (mm) in turn, and returns the equilibria.
    fn pressed(&self, lattice: &Lattice, travels_mm: &[f64]) -> Vec<Pressed> {
        let mut pressing = self.pressing(lattice);
        let push = |travel_mm: &f64| pressing.push(self.at(lattice.finger(), *travel_mm)).expect("an equilibrium");
        travels_mm.iter().map(push).collect()
    }

    /// Total contact force along the disc's motion after each travel, N.
    fn totals_n(&self, lattice: &Lattice, travels_mm: &[f64]) -> Vec<f64> {
        let along = self.along(lattice.finger());
        self.pressed(lattice, travels_mm).iter().map(|pressed| pressed.contact_force().dot(&along)).collect()
    }
}

const SMOOTH: Disc = Disc { radius_mm: 20.0, friction: 0.0, at_mm: 74.0, direction_deg: 0.0 };
const ROUGH: Disc = Disc { radius_mm: 15.0, friction: 0.3, at_mm: 76.5, direction_deg: 30.0 };

const FLAT: Disc = Disc { radius_mm: 1000.0, friction: 0.0, at_mm: 80.0, direction_deg: 0.0 };
/// Tolerance for the errors of rapier's sweeps and of its criterion of rest, as a share of the force and of the largest displacement.
const ENGINE_TOLERANCE: f64 = 2e-3;

fn assert_alike(ours: &Pressed, engine: &Pressed) {
    let (force, other) = (ours.contact_force(), engine.contact_force());
    assert!((force - other).norm() <= ENGINE_TOLERANCE * force.norm(), "{force:?} and {other:?}");
    let apart = shapes_apart(&ours.shape, &engine.shape);
    assert!(apart <= ENGINE_TOLERANCE, "{apart}");
}

/// The physics engine rapier presses the object from a position without contact, either to a point or with a force. It reaches the same equilibrium
/// as Newton's method.
#[test]
fn rapier_on_its_own_way_rests_where_newton_is() {
    let lattice = Lattice::new(&paper(), 2).expect("a lattice");
    for push in [SMOOTH.at(lattice.finger(), 5.0), Push::With(1.0)] {
        let ours = SMOOTH.pressing(&lattice).push(push).expect("an equilibrium");
        let engine = SMOOTH.engine(&lattice).push(push).expect("it settles");
        assert_alike(&ours, &engine);
    }
}

/// With friction, the state of rest is not unique, so the physics engine rapier starts from the equilibrium of Newton's method and must stay there.
/// If the friction coefficient is reduced, the contact forces of the starting equilibrium lie outside the friction cone, and rapier must leave this
/// equilibrium.
#[test]
fn rapier_stays_where_friction_was_found() {
    let lattice = Lattice::new(&paper(), 2).expect("a lattice");
    let travels_mm = [4.0, 10.0];
    let found = ROUGH.pressed(&lattice, &travels_mm);
    for (travel_mm, found) in travels_mm.iter().zip(&found) {
        let push = ROUGH.at(lattice.finger(), *travel_mm);
        assert_alike(found, &ROUGH.engine(&lattice).hold(found, push).expect("it settles"));
        let slippery = Disc { friction: 0.1, ..ROUGH };
        let left = slippery.engine(&lattice).hold(found, push).expect("it settles");
        let changed_n = (found.contact_force() - left.contact_force()).norm();
        assert!(changed_n > 10.0 * ENGINE_TOLERANCE * found.contact_force().norm(), "{changed_n} N");
    }
}

/// The disc slides in monotonic travel. At a contact that slides during the whole last step, friction is the coefficient times the normal force. The
/// total forces agree with those of an independent quasi-static frame with Coulomb contact, for any number of steps.
#[test]
fn friction_stands_where_the_way_left_it() {
    let lattice = Lattice::new(&paper(), 6).expect("a lattice");
    let travels_mm = [1.9985, 3.9961, 5.9933, 7.9908, 9.9848];
    let frame_n = [0.18420, 0.47842, 0.77880, 1.08321, 1.72973];
    let totals_n = ROUGH.totals_n(&lattice, &travels_mm);
    for (ours, frame) in totals_n.iter().zip(frame_n) {
        assert!((ours - frame).abs() < 0.01 * frame_n[4], "{totals_n:?}");
    }
    let once = ROUGH.totals_n(&lattice, &travels_mm[4..])[0];
    assert!((once / totals_n[4] - 1.0).abs() < 1e-3, "{once} and {totals_n:?}");
    let start = &ROUGH.pressed(&lattice, &[1.0, 2.0])[1];
    let [touch] = start.touches[..] else { panic!("one contact: {:?}", start.touches) };
    let (normal_n, friction_n) = (touch.force.dot(&touch.normal), touch.force.perp(&touch.normal).abs());
    assert!((friction_n / normal_n - ROUGH.friction).abs() < 1e-9, "{friction_n} N of {normal_n} N");
}

/// The object was once held by a spring, and stopped up to 5 % before its prescribed position.
#[test]
fn the_object_is_where_it_was_told_to_be() {
    let lattice = Lattice::new(&paper(), 2).expect("a lattice");
    for disc in [SMOOTH, ROUGH] {
        let Push::To(told) = disc.at(lattice.finger(), 12.0) else { unreachable!() };
        let object = disc.pressed(&lattice, &[6.0, 12.0])[1].object;
        assert!((object - told).norm() < 1e-9, "{object:?} for {told:?}");
    }
}

/// Under nearly flat objects, several rods in a row touch at once, and contacts near the clamp are stiff. The physics engine rapier once did not
/// settle in these cases.
#[test]
fn nearly_flat_objects_have_equilibria() {
    let lattice = Lattice::new(&paper(), 6).expect("a lattice");
    for (radius_mm, travel_mm) in [(1000.0, 3.0), (300.0, 10.0)] {
        let disc = Disc { radius_mm, ..FLAT };
        let pressed = &disc.pressed(&lattice, &[0.5 * travel_mm, travel_mm])[1];
        assert!(pressed.touches.len() > 2, "{:?}", pressed.touches);
        assert!(pressed.imbalance().expect("contact") < 1e-7, "{:?}", pressed.imbalance());
    }
}

/// A disc of 1 m radius first touches at 80 mm; above the base, its surface is higher by 80^2 / (2 x 1001.5) mm. After a travel equal to the initial
/// gap above the clamped rod, the disc meets this rod, and neither disc nor rod yields.
#[test]
fn the_clamped_end_stops_the_object() {
    let lattice = Lattice::new(&paper(), 2).expect("a lattice");
    let Push::To(start) = FLAT.at(lattice.finger(), 0.0) else { unreachable!() };
    let way_mm = (FLAT.pressed(&lattice, &[5.0])[0].object - start).norm();
    let reach_mm = FLAT.radius_mm + ROD_RADIUS_MM;
    let expected_mm = reach_mm - (reach_mm * reach_mm - FLAT.at_mm * FLAT.at_mm).sqrt();
    assert!((way_mm - expected_mm).abs() < 1e-6, "{way_mm} for {expected_mm}");
}
