//! Pressed objects: equilibria compared with statics, and with an independent contact solution with frame elements.

use finray_contact::outline::Shape;
use finray_contact::pressing::{Pressed, Pressing, Push};
use finray_model::finger::Plate;
use finray_model::{Finger, Mesh, Vector};
use finray_tests::paper;

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

    fn at(&self, finger: &Finger, travel_mm: f64) -> Push {
        Push::To(self.start(finger) + self.along(finger) * travel_mm)
    }

    /// Presses the disc to each travel (mm) in turn, and returns the equilibria.
    fn pressed(&self, mesh: &Mesh, travels_mm: &[f64]) -> Vec<Pressed> {
        let mut pressing = self.pressing(mesh);
        let push = |travel_mm: &f64| pressing.push(self.at(mesh.finger(), *travel_mm)).expect("an equilibrium");
        travels_mm.iter().map(push).collect()
    }

    /// Total contact force along the disc's motion after each travel, N.
    fn totals_n(&self, mesh: &Mesh, travels_mm: &[f64]) -> Vec<f64> {
        let along = self.along(mesh.finger());
        self.pressed(mesh, travels_mm).iter().map(|pressed| pressed.contact_force().dot(&along)).collect()
    }
}

const SMOOTH: Disc = Disc { radius_mm: 20.0, friction: 0.0, at_mm: 74.0, direction_deg: 0.0 };
const ROUGH: Disc = Disc { radius_mm: 15.0, friction: 0.3, at_mm: 76.5, direction_deg: 30.0 };

const FLAT: Disc = Disc { radius_mm: 1000.0, friction: 0.0, at_mm: 80.0, direction_deg: 0.0 };
/// The disc slides in monotonic travel. At a contact that slides during the whole last step, friction is the coefficient times the normal force. The
/// total forces agree with those of an independent quasi-static frame with Coulomb contact, for any number of steps.
#[test]
fn friction_stands_where_the_way_left_it() {
    let mesh = Mesh::with_elements_per_member(&paper(), 4);
    let travels_mm = [1.9985, 3.9961, 5.9933, 7.9908, 9.9848];
    let frame_n = [0.18420, 0.47842, 0.77880, 1.08321, 1.72973];
    let totals_n = ROUGH.totals_n(&mesh, &travels_mm);
    for (ours, frame) in totals_n.iter().zip(frame_n) {
        assert!((ours - frame).abs() < 0.01 * frame_n[4], "{totals_n:?}");
    }
    let once = ROUGH.totals_n(&mesh, &travels_mm[4..])[0];
    assert!((once / totals_n[4] - 1.0).abs() < 1e-3, "{once} and {totals_n:?}");
    let start = &ROUGH.pressed(&mesh, &[1.0, 2.0])[1];
    let [touch] = start.touches[..] else { panic!("one contact: {:?}", start.touches) };
    let (normal_n, friction_n) = (touch.force.dot(&touch.normal), touch.force.perp(&touch.normal).abs());
    assert!((friction_n / normal_n - ROUGH.friction).abs() < 1e-9, "{friction_n} N of {normal_n} N");
}

/// The object was once held by a spring, and stopped up to 5 % before its prescribed position.
#[test]
fn the_object_is_where_it_was_told_to_be() {
    let mesh = Mesh::with_elements_per_member(&paper(), 2);
    for disc in [SMOOTH, ROUGH] {
        let Push::To(told) = disc.at(mesh.finger(), 12.0) else { unreachable!() };
        let object = disc.pressed(&mesh, &[6.0, 12.0])[1].object;
        assert!((object - told).norm() < 1e-9, "{object:?} for {told:?}");
    }
}

/// Under nearly flat objects, several rods in a row touch at once, and contacts near the clamp are stiff. The physics engine rapier once did not
/// settle in these cases.
#[test]
fn nearly_flat_objects_have_equilibria() {
    let mesh = Mesh::with_elements_per_member(&paper(), 4);
    for (radius_mm, travel_mm) in [(1000.0, 3.0), (300.0, 10.0)] {
        let disc = Disc { radius_mm, ..FLAT };
        let pressed = &disc.pressed(&mesh, &[0.5 * travel_mm, travel_mm])[1];
        assert!(pressed.touches.len() > 2, "{:?}", pressed.touches);
        assert!(pressed.imbalance().expect("contact") < 1e-7, "{:?}", pressed.imbalance());
    }
}

/// A disc of 1 m radius first touches at 80 mm; above the base, its surface is higher by 80^2 / (2 x 1001.5) mm. After a travel equal to the initial
/// gap above the clamped rod, the disc meets this rod, and neither disc nor rod yields.
#[test]
fn the_clamped_end_stops_the_object() {
    let mesh = Mesh::with_elements_per_member(&paper(), 2);
    let Push::To(start) = FLAT.at(mesh.finger(), 0.0) else { unreachable!() };
    let way_mm = (FLAT.pressed(&mesh, &[5.0])[0].object - start).norm();
    let reach_mm = FLAT.radius_mm + ROD_RADIUS_MM;
    let expected_mm = reach_mm - (reach_mm * reach_mm - FLAT.at_mm * FLAT.at_mm).sqrt();
    assert!((way_mm - expected_mm).abs() < 1e-6, "{way_mm} for {expected_mm}");
}
