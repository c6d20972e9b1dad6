//! Every stated standard deviation of a force includes the error of beam theory, and the sum of one force has the deviation of this force.

use finray_model::estimators::network::Networks;
use finray_model::estimators::{BeamTheoryError, Estimator, EstimatorId, Sensed, WithBeamTheoryError};
use finray_model::measurement::Measurement;
use finray_model::observation::{Observation, ObservedMarker};
use finray_model::sensing::{Contact, MeasuredContact};
use finray_model::sensor::{SensedForces, Sensor, SensorContacts, SensorOptions};
use finray_model::{Kinematics, Mesh, Scene};
use finray_tests::{CAMERA_NOISE_MM, at_node, at_position, noisy, paper, paper_scene_with, seen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const MODEL_ERROR: f64 = 0.01;
/// Rounding, relative.
const SAME: f64 = 1e-6;
/// Difference of standard deviations, relative: sensors and maps compute the errors of linearisation and mesh on meshes that differ.
const MESHES: f64 = 0.005;
/// Difference of forces from two searches, as a share of their standard deviation. A search may stop within 1 % of it.
const SEARCHES: f64 = 0.02;

fn scene() -> Scene {
    Scene { model_error: MODEL_ERROR, noise_mm: None, ..paper_scene_with(&[]) }
}

/// Noisy displacements of the co-rotational finger under one force.
fn measured(contact: Contact, force_n: f64, noise_mm: f64) -> Measurement {
    let mesh = Mesh::with_elements_per_member(&paper(), 8);
    let clean = seen(&mesh, &[contact], &[force_n], Kinematics::Corotational).expect("an equilibrium");
    noisy(&clean, noise_mm, &mut ChaCha8Rng::seed_from_u64(11))
}

fn sensed(scene: &Scene, contacts: SensorContacts, of: &Measurement, options: SensorOptions) -> SensedForces {
    let markers = of.markers().iter().map(|marker| ObservedMarker::displaced(marker.node, marker.displacement));
    let seen = Observation { markers: markers.collect(), ..Observation::default() };
    Sensor::new(scene, contacts, options).expect("a contact").sense(&seen).expect("a force")
}

fn answered(estimator: &dyn Estimator, contact: Contact, of: &Measurement, noise_mm: f64) -> Sensed {
    estimator.prepare(&[contact], of).expect("prepared").estimate(of, Some(noise_mm)).expect("a force")
}

/// Estimators of maps and sweeps state the same force and standard deviation as a sensor.
#[test]
fn estimators_of_maps_state_the_deviations_of_a_sensor() {
    let scene = scene();
    for (id, force_n) in [(EstimatorId::LeastSquares, 0.3), (EstimatorId::Nonlinear, 2.0)] {
        let mesh = id.mesh(&scene.finger);
        let with_error = || WithBeamTheoryError::around(id.on(&mesh, Networks::none()), BeamTheoryError(MODEL_ERROR));
        for (contact, noise_mm) in
            [(at_node(19, 0.0), 0.02), (at_node(15, 30.0), 0.002), (at_position(60.0, -20.0), 0.02)]
        {
            let of = measured(contact, force_n, noise_mm);
            let mesh_nodes = (id == EstimatorId::Nonlinear).then(|| mesh.node_count());
            let options = SensorOptions { estimator: id, noise_mm: Some(noise_mm), mesh_nodes, ..Default::default() };
            let expected = sensed(&scene, SensorContacts::Asked(vec![contact.into()]), &of, options);
            let whole = with_error();
            let for_many = whole.for_many(false);
            for estimator in [Some(&*whole), for_many.as_deref()].into_iter().flatten() {
                let found = answered(estimator, contact, &of, noise_mm);
                let sigma_n = found.sigmas_n.expect("stated")[0];
                let apart_n = (found.forces_n[0] - expected.forces_n[0]).abs();
                assert!(apart_n < SEARCHES * sigma_n, "{id:?}: {apart_n} N, {expected:?}");
                assert!((sigma_n / expected.sigmas_n[0] - 1.0).abs() < MESHES, "{id:?}: {sigma_n}, {expected:?}");
                assert!(sigma_n > MODEL_ERROR * expected.forces_n[0]);
            }
        }
    }
}

/// Without an error of beam theory, the estimator is the given one.
#[test]
fn an_estimator_without_model_error_keeps_every_bit() {
    let finger = paper();
    let mesh = EstimatorId::Nonlinear.mesh(&finger);
    let of = measured(at_node(19, 0.0), 2.0, 0.02);
    let plain = EstimatorId::Nonlinear.on(&mesh, Networks::none());
    let around = WithBeamTheoryError::around(EstimatorId::Nonlinear.on(&mesh, Networks::none()), BeamTheoryError(0.0));
    assert_eq!(answered(&*around, at_node(19, 0.0), &of, 0.02), answered(&*plain, at_node(19, 0.0), &of, 0.02));
}

/// A contact that is measured exactly has the standard deviation of a known contact, and the sum of its one force has it, too.
#[test]
fn measured_contacts_include_the_model_error() {
    let scene = scene();
    for (contact, noise_mm) in [(at_node(19, 0.0), 0.02), (at_node(22, 20.0), 0.002)] {
        let of = measured(contact, 2.0, noise_mm);
        let options = SensorOptions { noise_mm: Some(noise_mm), ..Default::default() };
        let known = sensed(&scene, SensorContacts::Asked(vec![contact.into()]), &of, options);
        let exact = MeasuredContact { contact, direction_sd_rad: 0.0, position_sd_mm: 0.0 };
        let contacts = SensorContacts::Measured { contacts: vec![exact], friction: 0.0 };
        let measured = sensed(&scene, contacts, &of, options);
        assert!((measured.sigmas_n[0] / known.sigmas_n[0] - 1.0).abs() < MESHES, "{measured:?}, {known:?}");
        let [_, sum_sigma_n] = measured.sum_along(&scene.finger, scene.finger.direction(contact.angle_deg));
        assert!((sum_sigma_n / measured.sigmas_n[0] - 1.0).abs() < SAME, "{sum_sigma_n}: {measured:?}");
    }
}

/// The error of beam theory is a common factor: relative to the sum, it does not decrease with the number of forces.
#[test]
fn the_model_error_of_a_sum_is_a_share_of_the_sum() {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, 8);
    let contacts = [at_node(16, 0.0), at_node(21, 0.0)];
    let of = seen(&mesh, &contacts, &[1.0, 2.0], Kinematics::Corotational).expect("an equilibrium");
    let estimator_mesh = EstimatorId::Nonlinear.mesh(&finger);
    let sum_sigma_n = |share: f64| {
        let plain = EstimatorId::Nonlinear.on(&estimator_mesh, Networks::none());
        let estimator = WithBeamTheoryError::around(plain, BeamTheoryError(share));
        let found = estimator.prepare(&contacts, &of).expect("prepared").estimate(&of, Some(1e-6)).expect("forces");
        found.sum_sigma_n.expect("stated")
    };
    let sigma_n = sum_sigma_n(MODEL_ERROR);
    assert!(sigma_n > 3.0 * MODEL_ERROR && sigma_n > sum_sigma_n(0.0), "{sigma_n}");
}

/// For one force, the standard deviation of the sum is that of the force, also where no finger explains the measurement.
#[test]
fn the_sum_of_one_force_has_the_deviation_of_this_force() {
    let finger = paper();
    for (s_mm, force_n) in [(38.0, 20.0), (30.0, 25.0), (45.0, 18.0), (76.5, 3.0), (76.5, 0.1)] {
        let contact = at_position(s_mm, 0.0);
        let reference = Mesh::with_elements_per_member(&finger, 4);
        let of = seen(&reference, &[contact], &[force_n], Kinematics::Corotational).expect("an equilibrium");
        let mesh = EstimatorId::LeastSquares.mesh(&finger);
        for share in [0.0, MODEL_ERROR] {
            let plain = EstimatorId::LeastSquares.on(&mesh, Networks::none());
            let estimator = WithBeamTheoryError::around(plain, BeamTheoryError(share));
            let found = answered(&*estimator, contact, &of, CAMERA_NOISE_MM);
            let (sigma_n, sum_n) = (found.sigmas_n.expect("stated")[0], found.sum_sigma_n.expect("stated"));
            assert!((sum_n / sigma_n - 1.0).abs() < SAME, "{s_mm} mm, {force_n} N: {sum_n} of the sum, {sigma_n}");
        }
    }
}
