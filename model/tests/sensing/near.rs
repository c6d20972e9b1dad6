//! Searches that start from the forces of another observation.

use finray_model::mesh::Load;
use finray_model::observation::Observation;
use finray_model::sensing::{Contact, ContactPosition, ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use finray_model::{Kinematics, Mesh, Scene, statics};

/// The finger under one force, along the normal of its undeformed plate.
fn seen(scene: &Scene, s_mm: f64, force_n: f64) -> Observation {
    let contact = Contact { position: ContactPosition::At(s_mm), angle_deg: 0.0 };
    let mesh = Mesh::with_elements_per_member(&scene.finger, 16);
    let load: Load = contact.load(&scene.finger, force_n);
    Observation::of_shape(&scene.finger, &statics::solve(&mesh, &[load], Kinematics::Corotational).expect("carried"))
}

/// The result does not depend on the start of the search: near the result, at another position, or with a force for which the finger has no
/// equilibrium.
#[test]
fn the_start_of_a_search_does_not_change_its_result() {
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene");
    let options = SensorOptions { noise_mm: Some(0.02), ..SensorOptions::default() };
    for direction in [Direction::Angle(0.0), Direction::NORMAL, Direction::Auto] {
        let asked = SensorContacts::Asked(vec![ContactQuestion { position: None, direction }]);
        let sensor = Sensor::new(&scene, asked, options).expect("a question");
        let observed = seen(&scene, 80.0, 2.0);
        let expected = sensor.sense(&observed).expect("an answer");
        let near = |force_n: f64, s_mm: f64| {
            let mut near = expected.clone();
            near.contacts = vec![Contact { position: ContactPosition::At(s_mm), angle_deg: 0.0 }];
            near.forces_n = vec![force_n];
            near
        };
        for before in [near(1.9, 78.0), near(0.5, 30.0), near(-2.0, 80.0), near(500.0, 140.0), expected.clone()] {
            let found = sensor.sense_near(&observed, Some(&before)).expect("an answer");
            let off = (found.forces_n[0] - expected.forces_n[0]) / expected.sigmas_n[0];
            assert!(off.abs() < 1e-3, "{direction:?} from {:?}: {off} sigma", before.forces_n);
        }
    }
}
