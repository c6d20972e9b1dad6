//! Pressed objects: equilibria compared with statics, and with an independent contact solution with frame elements.

use super::press::object_of;
use finray_contact::path::PreparedObject;
use finray_contact::pressing::{Pressed, Pressing, Push};
use finray_model::Mesh;
use finray_model::scene::ROD_RADIUS_MM;
use finray_tests::paper;

const SMOOTH: &str = "shape = \"disc\"\nradius_mm = 20\nat_mm = 74\ntravel_mm = 1";
const ROUGH: &str = "shape = \"disc\"\nradius_mm = 15\nfriction = 0.3\nat_mm = 76.5\ndirection_deg = 30\ntravel_mm = 1";
const FLAT: &str = "shape = \"disc\"\nradius_mm = 1000\nat_mm = 80\ntravel_mm = 1";

fn at(object: &PreparedObject, travel_mm: f64) -> Push {
    Push::To(object.start + object.along * travel_mm)
}

/// Presses an object to each travel (mm) in turn, and returns the equilibria.
fn pressed(object: &PreparedObject, mesh: &Mesh, travels_mm: &[f64]) -> Vec<Pressed> {
    let rigid = (object.outline.clone(), object.friction);
    let mut pressing = Pressing::new(mesh, ROD_RADIUS_MM, rigid, object.start, object.along).expect("no overlap");
    travels_mm.iter().map(|travel_mm| pressing.push(at(object, *travel_mm)).expect("an equilibrium")).collect()
}

/// The disc slides in monotonic travel. At a contact that slides during the whole last step, friction is the coefficient times the normal force. The
/// total forces agree with those of an independent quasi-static frame with Coulomb contact, for any number of steps.
#[test]
fn friction_stands_where_the_way_left_it() {
    let mesh = Mesh::with_elements_per_member(&paper(), 4);
    let travels_mm = [1.9985, 3.9961, 5.9933, 7.9908, 9.9848];
    let frame_n = [0.18420, 0.47842, 0.77880, 1.08321, 1.72973];
    let rough = object_of(ROUGH);
    let totals_n = |travels_mm: &[f64]| -> Vec<f64> {
        let steps = pressed(&rough, &mesh, travels_mm);
        steps.iter().map(|pressed| pressed.contact_force().dot(&rough.along)).collect()
    };
    let once = totals_n(&travels_mm[4..])[0];
    let totals_n = totals_n(&travels_mm);
    for (ours, frame) in totals_n.iter().zip(frame_n) {
        assert!((ours - frame).abs() < 0.01 * frame_n[4], "{totals_n:?}");
    }
    assert!((once / totals_n[4] - 1.0).abs() < 1e-3, "{once} and {totals_n:?}");
    let start = &pressed(&rough, &mesh, &[1.0, 2.0])[1];
    let [touch] = start.touches[..] else { panic!("one contact: {:?}", start.touches) };
    let (normal_n, friction_n) = (touch.force.dot(&touch.normal), touch.force.perp(&touch.normal).abs());
    assert!((friction_n / normal_n - rough.friction).abs() < 1e-9, "{friction_n} N of {normal_n} N");
}

/// The object was once held by a spring, and stopped up to 5 % before its prescribed position.
#[test]
fn the_object_is_where_it_was_told_to_be() {
    let mesh = Mesh::with_elements_per_member(&paper(), 2);
    for disc in [SMOOTH, ROUGH].map(object_of) {
        let object = pressed(&disc, &mesh, &[6.0, 12.0])[1].object;
        let told = disc.start + disc.along * 12.0;
        assert!((object - told).norm() < 1e-9, "{object:?} for {told:?}");
    }
}

/// Under nearly flat objects, several rods in a row touch at once, and contacts near the clamp are stiff. The physics engine rapier once did not
/// settle in these cases.
#[test]
fn nearly_flat_objects_have_equilibria() {
    let mesh = Mesh::with_elements_per_member(&paper(), 4);
    for (radius_mm, travel_mm) in [(1000, 3.0), (300, 10.0)] {
        let disc = object_of(&FLAT.replace("1000", &radius_mm.to_string()));
        let pressed = &pressed(&disc, &mesh, &[0.5 * travel_mm, travel_mm])[1];
        assert!(pressed.touches.len() > 2, "{:?}", pressed.touches);
        assert!(pressed.imbalance().expect("contact") < 1e-7, "{:?}", pressed.imbalance());
    }
}

/// A disc of 1 m radius first touches at 80 mm; above the base, its surface is higher by 80^2 / (2 x 1001.5) mm. After a travel equal to the initial
/// gap above the clamped rod, the disc meets this rod, and neither disc nor rod yields.
#[test]
fn the_clamped_end_stops_the_object() {
    let mesh = Mesh::with_elements_per_member(&paper(), 2);
    let flat = object_of(FLAT);
    let way_mm = (pressed(&flat, &mesh, &[5.0])[0].object - flat.start).norm();
    let (reach_mm, at_mm) = (1000.0 + ROD_RADIUS_MM, 80.0_f64);
    let expected_mm = reach_mm - (reach_mm * reach_mm - at_mm * at_mm).sqrt();
    assert!((way_mm - expected_mm).abs() < 1e-6, "{way_mm} for {expected_mm}");
}
