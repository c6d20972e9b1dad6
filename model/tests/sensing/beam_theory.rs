//! Every stated standard deviation of a force includes the error of beam theory, and the sum of one force has the deviation of this force.

use finray_model::estimators::EstimatorId;
use finray_model::finger::ModelError;
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
/// Difference of standard deviations, relative: measured and known contacts are sensed on meshes that differ.
const MESHES: f64 = 0.005;
/// Difference of forces from two searches, as a share of their standard deviation. A search may stop within 1 % of it.
const SEARCHES: f64 = 0.02;

fn scene() -> Scene {
    let scene = Scene { noise_mm: None, ..paper_scene_with(&[]) };
    Scene { model_error: ModelError::of(&scene.finger, Some(MODEL_ERROR)), ..scene }
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
    Sensor::new(scene.clone(), contacts, options).expect("a contact").sense(&seen).expect("a force")
}

/// The error of beam theory widens the standard deviation by its share of the force, and adds to the errors of the markers.
#[test]
fn a_sensor_states_the_error_of_beam_theory() {
    let scene = scene();
    let without = Scene { model_error: ModelError::of(&scene.finger, None), ..scene.clone() };
    for (estimator, force_n) in [(EstimatorId::LeastSquares, 0.3), (EstimatorId::Nonlinear, 2.0)] {
        for (contact, noise_mm) in
            [(at_node(19, 0.0), 0.02), (at_node(15, 30.0), 0.002), (at_position(60.0, -20.0), 0.02)]
        {
            let of = measured(contact, force_n, noise_mm);
            let options = || SensorOptions { estimator, noise_mm: Some(noise_mm), ..Default::default() };
            let [with, without] = [&scene, &without]
                .map(|scene| sensed(scene, SensorContacts::Asked(vec![contact.into()]), &of, options()).forces[0]);
            assert!((with.force_n - without.force_n).abs() < SEARCHES * with.sigma_n, "{with:?}, {without:?}");
            let least_n = without.sigma_n.hypot(MODEL_ERROR * with.force_n);
            assert!(with.sigma_n > (1.0 - MESHES) * least_n && with.sigma_n < 2.0 * least_n, "{with:?}, {without:?}");
        }
    }
}

/// A contact that is measured exactly has the standard deviation of a known contact, and the sum of its one force has it, too.
#[test]
fn measured_contacts_include_the_model_error() {
    let scene = scene();
    for (contact, noise_mm) in [(at_node(19, 0.0), 0.02), (at_node(22, 20.0), 0.002)] {
        let of = measured(contact, 2.0, noise_mm);
        let options = || SensorOptions { noise_mm: Some(noise_mm), ..Default::default() };
        let known = sensed(&scene, SensorContacts::Asked(vec![contact.into()]), &of, options());
        let exact = MeasuredContact { contact, direction_sd_rad: 0.0, position_sd_mm: 0.0 };
        let contacts = SensorContacts::Measured { contacts: vec![exact], friction: 0.0 };
        let measured = sensed(&scene, contacts, &of, options());
        assert!((measured.forces[0].sigma_n / known.forces[0].sigma_n - 1.0).abs() < MESHES, "{measured:?}, {known:?}");
        let [_, sum_sigma_n] = measured.sum_along(&scene.finger, scene.finger.direction(contact.angle_deg));
        assert!((sum_sigma_n / measured.forces[0].sigma_n - 1.0).abs() < SAME, "{sum_sigma_n}: {measured:?}");
    }
}

/// For one force, the standard deviation of the sum is that of the force, also where no finger explains the measurement.
#[test]
fn the_sum_of_one_force_has_the_deviation_of_this_force() {
    let finger = paper();
    for (s_mm, force_n) in [(38.0, 20.0), (30.0, 25.0), (45.0, 18.0), (76.5, 3.0), (76.5, 0.1)] {
        let contact = at_position(s_mm, 0.0);
        let reference = Mesh::with_elements_per_member(&finger, 4);
        let of = seen(&reference, &[contact], &[force_n], Kinematics::Corotational).expect("an equilibrium");
        let options = SensorOptions::of(EstimatorId::LeastSquares);
        let sensor = Sensor::new(Scene::of_finger(finger.clone()), SensorContacts::known(&[contact]), options);
        let found = sensor.expect("a contact").sense_displacements(&of, Some(CAMERA_NOISE_MM), None).expect("a force");
        let (sigma_n, [_, sum_n]) = (found.forces[0].sigma_n, found.sum());
        assert!((sum_n / sigma_n - 1.0).abs() < SAME, "{s_mm} mm, {force_n} N: {sum_n} of the sum, {sigma_n}");
    }
}
