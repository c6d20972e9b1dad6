//! Uncertain moduli and depth scale all forces by one factor, so that intervals, sums included, hold for fingers whose stiffness is drawn.

use finray_model::finger::StiffnessError;
use finray_model::sensing::Contact;
use finray_model::sensor::{SensedForces, Sensor, SensorContacts, SensorOptions, TWO_SIDED_95};
use finray_model::{Finger, Kinematics, Mesh, Scene};
use finray_tests::{at_node, at_position, noisy, paper, seen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const NOISE_MM: f64 = 0.01;
/// Rounding, relative.
const SAME: f64 = 1e-6;

fn scene(stiffness_error: StiffnessError) -> Scene {
    Scene { stiffness_error, ..Scene::of_finger(paper()) }
}

fn stiffer(finger: &Finger, factor: f64) -> Finger {
    let mut description = finger.description().clone();
    description.front.youngs_modulus_mpa *= factor;
    description.back.youngs_modulus_mpa *= factor;
    description.ribs.strip.as_mut().expect("elastic ribs").youngs_modulus_mpa *= factor;
    Finger::new(description).expect("a finger")
}

/// Forces of `contacts` on a finger that is stiffer than the scene's by `factor`.
fn sensed(scene: &Scene, contacts: &[Contact], forces_n: &[f64], factor: f64, rng: &mut ChaCha8Rng) -> SensedForces {
    let mesh = Mesh::with_elements_per_member(&stiffer(&scene.finger, factor), 4);
    let clean = seen(&mesh, contacts, forces_n, Kinematics::Corotational).expect("an equilibrium");
    let sensor = Sensor::new(scene.clone(), SensorContacts::known(contacts), SensorOptions::default());
    let seen = noisy(&clean, NOISE_MM, rng);
    sensor.expect("contacts").sense_displacements(&seen, Some(NOISE_MM), None).expect("forces")
}

/// A finger stiffer by a factor is sensed with forces smaller by this factor, and the errors of two contacts add in their sum.
#[test]
fn intervals_and_sums_hold_for_drawn_moduli() {
    let error = StiffnessError { modulus: 0.08, depth: 0.06, ..StiffnessError::default() };
    let scene = scene(error);
    let contacts = [at_node(17, 0.0), at_position(60.0, 10.0)];
    let forces_n = [1.0, 2.0];
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut held, mut sums_held, cases) = (0, 0, 300);
    for _ in 0..cases {
        let deviation: f64 = StandardNormal.sample(&mut rng);
        let factor = 1.0 + 0.1 * deviation;
        let found = sensed(&scene, &contacts, &forces_n, factor, &mut rng);
        for (found, force_n) in found.forces.iter().zip(forces_n) {
            let [low_n, high_n] = found.interval_n();
            held += usize::from(low_n < force_n && force_n < high_n);
        }
        let [sum_n, sigma_n] = found.sum();
        assert!((sigma_n / (0.1 * sum_n) - 1.0).abs() < 0.02, "{sigma_n} of {sum_n}");
        sums_held += usize::from((sum_n - 3.0).abs() < TWO_SIDED_95 * sigma_n);
    }
    // Three standard deviations of the share: the two intervals of a finger hold together, so that they count as one.
    let tolerance = 3.0 * (0.95 * 0.05 / f64::from(cases)).sqrt();
    let shares = [held as f64 / f64::from(2 * cases), sums_held as f64 / f64::from(cases)];
    assert!(shares.iter().all(|share| (share - 0.95).abs() < tolerance), "{shares:?} within {tolerance}");
}

/// Without noise the forces are those of the true finger divided by the factor, and sigma is the stated share.
#[test]
fn the_error_is_a_share_of_the_force() {
    let with = scene(StiffnessError { modulus: 0.1, ..StiffnessError::default() });
    let without = Scene { stiffness_error: StiffnessError::default(), ..with.clone() };
    let contacts = [at_node(19, 20.0)];
    let [with, without] = [&with, &without]
        .map(|scene| sensed(scene, &contacts, &[2.0], 1.25, &mut ChaCha8Rng::seed_from_u64(1)).forces[0]);
    assert!((with.force_n * 1.25 / 2.0 - 1.0).abs() < 0.01, "{with:?}");
    assert!((with.force_n / without.force_n - 1.0).abs() < SAME);
    assert!((with.sigma_n / without.sigma_n.hypot(0.1 * with.force_n) - 1.0).abs() < SAME, "{with:?}, {without:?}");
}

/// Only a finger whose beams describe a solid of plastic has an assumed error, and a stated value replaces it.
#[test]
fn a_plastic_of_unknown_modulus_has_a_default() {
    let solid = include_str!("../scenes/short_rib.toml").replace("youngs_modulus_sigma = 0.0\n", "");
    let read = |text: &str| Scene::from_toml(text).expect("a scene").stiffness_error;
    let assumed = read(&solid);
    assert!(assumed.is_assumed && assumed.modulus == 0.1 && assumed.share() == 0.1, "{assumed:?}");
    assert_eq!(assumed.to_string(), "10 % (modulus, assumed: 10 %)");
    let stated = solid.replace("[finger]\n", "[finger]\nyoungs_modulus_sigma = 0.04\ndepth_sigma_mm = 0.6\n");
    assert_eq!(read(&stated).to_string(), "5 % (modulus, stated: 4 %; depth: 3 %)");
    assert_eq!(read(&solid.replace("= 48.0", "= 210000.0")), StiffnessError::default());
    assert_eq!(read(finray_fixtures::PAPER_SCENE), StiffnessError::default());
    let warnings = Scene::from_toml(&solid).expect("a scene").warnings();
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(
        warning
            .to_string()
            .starts_with("finger.youngs_modulus_sigma is not stated: intervals of forces allow for 10 %")
    );
}
