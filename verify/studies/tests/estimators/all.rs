//! Properties of every estimator in the list.

use finray_model::estimators::network::Networks;
use finray_model::estimators::{EstimatorError, EstimatorId, Question};
use finray_model::measurement::Measurement;
use finray_model::sensing::Pad;
use finray_studies::truths::TruthId;
use finray_tests::{CAMERA_NOISE_MM, at_node, paper};

/// Tolerance of the relative error. For a small force in the middle, linear estimators have an error of 1 %, and networks have a smaller error.
const TOLERANCE: f64 = 0.02;

/// Every estimator senses 0.5 N in the middle of the co-rotational finger, both as a prepared estimator and in a single call.
#[test]
fn every_estimator_finds_a_small_force() {
    let finger = paper();
    let contact = at_node(19, 0.0);
    let mesh = TruthId::Corotational.mesh(&finger).expect("a mesh");
    let truth = TruthId::Corotational.on(&mesh).expect("a finger at rest");
    let measurement = Measurement::of_shape(&finger, &truth.shapes(&contact, &[0.5])[0]);
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that read");
    for &id in EstimatorId::ALL {
        let mesh = id.mesh(&finger);
        let estimator = id.on(&mesh, &networks);
        assert_eq!(estimator.id(), id);
        let mut prepared = estimator.prepare(&[contact], &measurement).unwrap_or_else(|error| panic!("{id}: {error}"));
        let sensed =
            prepared.estimate(&measurement, Some(CAMERA_NOISE_MM)).unwrap_or_else(|error| panic!("{id}: {error}"));
        let question = Question {
            contacts: &[contact.into()],
            pad: Pad::default(),
            object: None,
            measurement: &measurement,
            noise_mm: Some(CAMERA_NOISE_MM),
            mesh_nodes: None,
            networks: &networks,
            unloaded: None,
            near: None,
        };
        let (contacts, estimate) = id.answer(&finger, &question).unwrap_or_else(|error| panic!("{id}: {error}"));
        assert_eq!(contacts, [contact], "{id}");
        for force_n in [sensed.forces_n[0], estimate.forces_n[0]] {
            assert!((force_n / 0.5 - 1.0).abs() < TOLERANCE, "{id}: {force_n} N");
        }
        // Only the nonlinear estimator supports pads; the other estimators return an error.
        let padded = id.answer(&finger, &Question { pad: Pad { length_mm: 4.0, thickness_mm: 1.0 }, ..question });
        assert_eq!(padded == Err(EstimatorError::NoPad), id != EstimatorId::Nonlinear, "{id}: {padded:?}");
    }
}
