//! Properties of every estimator in the list.

use finray_model::Scene;
use finray_model::estimators::network::Networks;
use finray_model::estimators::{EstimatorError, EstimatorId};
use finray_model::measurement::Measurement;
use finray_model::scene::ContactDescription;
use finray_model::sensing::Pad;
use finray_model::sensor::{Refusal, Sensor, SensorContacts, SensorOptions};
use finray_studies::truths::TruthId;
use finray_tests::{CAMERA_NOISE_MM, at_node, paper};

/// Tolerance of the relative error. For a small force in the middle, linear estimators have an error of 1 %, and networks have a smaller error.
const TOLERANCE: f64 = 0.02;

/// Every estimator senses 0.5 N in the middle of the co-rotational finger. Only the nonlinear estimator supports pads.
#[test]
fn every_estimator_finds_a_small_force() {
    let finger = paper();
    let contact = at_node(19, 0.0);
    let mesh = TruthId::Corotational.mesh(&finger).expect("a mesh");
    let truth = TruthId::Corotational.on(&mesh, &Scene::of_finger(finger.clone())).expect("a finger at rest");
    let measurement = Measurement::of_shape(&finger, &truth.shapes(&contact, &[0.5])[0]);
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that read");
    for &id in EstimatorId::ALL {
        let sense = |pad| {
            let contact_description = ContactDescription { pad, ..ContactDescription::default() };
            let scene = Scene { contact: contact_description, ..Scene::of_finger(finger.clone()) };
            let options = SensorOptions { estimator: id, networks: networks.clone(), ..SensorOptions::default() };
            let sensor = Sensor::new(scene, SensorContacts::Asked(vec![contact.into()]), options)?;
            sensor.sense_displacements(&measurement, Some(CAMERA_NOISE_MM), None)
        };
        let sensed = sense(None).unwrap_or_else(|refusal| panic!("{id}: {refusal}"));
        assert_eq!(sensed.forces[0].contact, contact, "{id}");
        assert!((sensed.forces[0].force_n / 0.5 - 1.0).abs() < TOLERANCE, "{id}: {sensed:?}");
        let padded = sense(Some(Pad { length_mm: 4.0, thickness_mm: 1.0 }));
        let is_refused = padded == Err(Refusal::Estimator(EstimatorError::NoPad));
        assert_eq!(is_refused, id != EstimatorId::Nonlinear, "{id}: {padded:?}");
    }
}
