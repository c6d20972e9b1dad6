//! Forces whose direction is known from a range of friction, at unknown positions.

use finray_model::measurement::Measurement;
use finray_model::sensing::{ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use finray_model::{Kinematics, Mesh, Scene, statics};
use finray_tests::at_position;

const NOISE_MM: f64 = 0.02;
const ELEMENTS: usize = 16;

/// A push is sensed as a push, in an interval that holds, over the middle of the plate. A search once turned the lean of a force by 180 degrees and
/// kept the sign: at 33.6 mm, 1 N was sensed as -1.145 N, because the opposite lean is far from the prior.
#[test]
fn a_push_is_sensed_as_a_push() {
    let scene = Scene::from_toml(include_str!("../scenes/eleven_ribs.toml")).expect("a scene");
    let mesh = Mesh::with_elements_per_member(&scene.finger, ELEMENTS);
    let lean = scene.contact.lean.expect("friction");
    let question = ContactQuestion::new(None, Direction::Leaning(lean));
    for s_mm in [16.8, 25.4, 29.5, 33.6, 37.0, 40.4, 48.4, 57.6, 66.1, 74.9] {
        for angle_deg in [-20.0, -10.0, 0.0, 10.0, 20.0] {
            let load = at_position(s_mm, angle_deg).load(&scene.finger, 1.0);
            let bent = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium");
            let seen = Measurement::of_shape(&scene.finger, &bent);
            // Each force is sensed afresh: the last estimate would lead the search.
            let sensor = Sensor::new(scene.clone(), SensorContacts::Asked(vec![question]), SensorOptions::default());
            let sensed = sensor.expect("a contact").sense_displacements(&seen, Some(NOISE_MM), None);
            let force = sensed.expect("a force").forces[0];
            let [low_n, high_n] = force.interval_n();
            assert!(low_n < 1.0 && 1.0 < high_n, "{s_mm} mm, {angle_deg} degrees: {force:?}");
        }
    }
}
