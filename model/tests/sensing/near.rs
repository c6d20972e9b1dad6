//! Searches that start from the forces of another observation.

use finray_model::mesh::Load;
use finray_model::observation::Observation;
use finray_model::sensing::{Contact, ContactPosition, ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions, StreamSensor};
use finray_model::{Kinematics, Mesh, Scene, Vector, statics};
use finray_tests::random_stream;
use rand_distr::{Distribution, StandardNormal};

/// The finger under one force, along the normal of its undeformed plate.
fn seen(scene: &Scene, s_mm: f64, force_n: f64) -> Observation {
    let contact = Contact { position: ContactPosition::At(s_mm), angle_deg: 0.0 };
    let mesh = Mesh::with_elements_per_member(&scene.finger, 16);
    let load: Load = contact.load(&scene.finger, force_n);
    Observation::of_shape(&scene.finger, &statics::solve(&mesh, &[load], Kinematics::Corotational).expect("carried"))
}

/// A search may start near the result, at another position, or with a force for which the finger has no equilibrium. Its result does not depend on
/// the start.
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

/// For each observation, a stream sensor starts from the finger shapes that it computed for the previous observation. The forces of a stream sensor
/// agree within 1e-4 standard deviations with those of a sensor that starts from the previous forces alone. Both searches end when a step changes the
/// forces by less than 1e-8. The markers have noise, so the residuals are not zero. If the previous forces come from another sensor, the shapes of
/// the stream sensor do not belong to these forces. Both sensors then return the same result to the last bit.
#[test]
fn shapes_of_the_previous_observation_do_not_change_the_forces() {
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene");
    let options = SensorOptions { noise_mm: Some(0.02), ..SensorOptions::default() };
    let chance = &mut random_stream(48, 0);
    let mut noisy = |s_mm: f64, force_n: f64| {
        let mut seen = seen(&scene, s_mm, force_n);
        for displacement in seen.markers.iter_mut().filter_map(|marker| marker.displacement.as_mut()) {
            let noise: [f64; 2] = [0, 1].map(|_| Distribution::<f64>::sample(&StandardNormal, chance));
            *displacement += 0.02 * Vector::from(noise);
        }
        seen
    };
    // The force changes little, then jumps to another position, then vanishes and returns.
    let stream =
        [(80.0, 1.0), (80.5, 1.05), (81.0, 1.1), (50.0, 2.0), (50.5, 2.1), (50.0, 0.0), (60.0, 1.5), (60.5, 1.6)];
    let stream = stream.map(|(s_mm, force_n)| noisy(s_mm, force_n));
    for direction in [Direction::Angle(0.0), Direction::NORMAL, Direction::Auto] {
        let asked = SensorContacts::Asked(vec![ContactQuestion { position: None, direction }]);
        let sensor = Sensor::new(&scene, asked.clone(), options).expect("a question");
        let mut following = StreamSensor::new(&scene, asked, options).expect("a question");
        let mut before = None;
        let mut in_contact = 0;
        for observed in &stream {
            let found = following.sense(observed, before.as_ref()).expect("an answer");
            if let Some(found) = &found {
                let expected = sensor.sense_near(observed, before.as_ref()).expect("an answer");
                let off = (found.forces_n[0] - expected.forces_n[0]) / expected.sigmas_n[0];
                assert!(off.abs() < 1e-4, "{direction:?}: {off} sigma");
                assert!((found.sigmas_n[0] / expected.sigmas_n[0] - 1.0).abs() < 1e-3, "{direction:?}");
                let mut others = expected;
                others.forces_n[0] *= 1.01;
                let of_others = following.clone().sense(observed, Some(&others)).expect("an answer");
                assert_eq!(of_others, Some(sensor.sense_near(observed, Some(&others)).expect("an answer")));
                in_contact += 1;
            }
            before = found;
        }
        assert_eq!(in_contact, 7, "{direction:?}");
    }
}
