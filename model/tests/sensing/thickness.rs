//! Sensing on fingers whose plates and ribs are thicker or thinner than their scene states, with and without a modulus that was calibrated on them.

use finray_model::calibration::{CalibrationCase, corotational_modulus};
use finray_model::finger::{StiffnessError, ThicknessError};
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactQuestion, Direction};
use finray_model::sensor::{SensedForce, Sensor, SensorContacts, SensorOptions, TWO_SIDED_95};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, statics};
use finray_tests::{at_position, case_count, random_stream, share_error};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Noise of a marker coordinate, mm, far below the displacements that the thicknesses cause.
const NOISE_MM: f64 = 0.01;
const THICKNESS: ThicknessError = ThicknessError { sd: 0.03, modulus_slopes: [0.0; 3] };
const ELEMENTS: usize = 8;

/// A printed finger whose thicknesses alone are uncertain.
fn scene() -> Scene {
    let text = include_str!("../scenes/short_rib.toml");
    let exact = text.replace("youngs_modulus_sigma = 0.0", "youngs_modulus_sigma = 0.0\nmodel_error = 0.0");
    Scene { thickness_error: THICKNESS, ..Scene::from_toml(&exact).expect("a scene") }
}

/// The finger with other thicknesses of front plate, back plate and ribs.
fn printed(finger: &Finger, chance: &mut ChaCha8Rng) -> Finger {
    let mut description = finger.description().clone();
    let [front, back, ribs] = std::array::from_fn(|_| {
        1.0 + THICKNESS.sd * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, chance)
    });
    description.front.thickness_mm *= front;
    description.back.thickness_mm *= back;
    description.ribs.strip.as_mut().expect("elastic ribs").thickness_mm *= ribs;
    Finger::new(description).expect("a finger")
}

fn bent(finger: &Finger, load: Load) -> Measurement {
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    Measurement::of_shape(finger, &statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium"))
}

fn sensed(scene: &Scene, question: ContactQuestion, seen: &Measurement) -> Option<SensedForce> {
    let sensor = Sensor::new(scene.clone(), SensorContacts::Asked(vec![question]), SensorOptions::default());
    let sensed = sensor.expect("a contact").sense_displacements(seen, Some(NOISE_MM), None);
    sensed.inspect_err(|refusal| println!("{refusal}")).ok().map(|sensed| sensed.forces[0])
}

/// The scene with the modulus that a weight of 1 N at the middle of the printed finger shows.
fn weighed(scene: &Scene, printed: &Finger, chance: &mut ChaCha8Rng) -> Scene {
    let load = Load::at_node(NodeId(7), scene.finger.direction(0.0));
    let mut measurement = bent(printed, load);
    measurement.add_noise(NOISE_MM, || StandardNormal.sample(chance));
    let cases = [CalibrationCase { load, measurement }];
    let fit = |finger: &Finger| corotational_modulus(finger, &cases, ELEMENTS, Some(NOISE_MM));
    let found = fit(&scene.finger).expect("a factor");
    let thickness_error =
        scene.thickness_error.calibrated(&scene.finger, |finger| fit(finger).map(|found| found.factor));
    Scene {
        finger: scene.finger.with_modulus_factor(found.factor).expect("a finger"),
        stiffness_error: StiffnessError { modulus: found.sigma / found.factor, ..scene.stiffness_error },
        thickness_error: thickness_error.expect("a factor"),
        ..scene.clone()
    }
}

/// 95 % intervals hold for known and unknown contacts, with a modulus that is exact and with one that was calibrated on the finger. Without the key,
/// they are too narrow. A calibrated modulus whose dependence on the thicknesses is forgotten has wider intervals at the place of the weight.
#[test]
fn intervals_hold_on_fingers_of_other_thickness() {
    let (scene, cases) = (scene(), case_count(40, 400));
    let (mut held, mut answered, mut held_without) = ([0_usize; 4], [0_usize; 4], 0);
    for case in 0..cases {
        let chance = &mut random_stream(6600, case as u64);
        let printed = printed(&scene.finger, chance);
        let calibrated = weighed(&scene, &printed, chance);
        let force_n: f64 = chance.random_range(0.3..1.0);
        let contact = at_position(chance.random_range(30.0..95.0), chance.random_range(-25.0..25.0));
        let mut seen = bent(&printed, contact.load(&scene.finger, force_n));
        seen.add_noise(NOISE_MM, || StandardNormal.sample(chance));
        let unknown = ContactQuestion::new(None, Direction::Auto);
        let holds = |sensed: SensedForce| (sensed.force_n - force_n).abs() < TWO_SIDED_95 * sensed.sigma_n;
        let questions =
            [(&scene, contact.into()), (&scene, unknown), (&calibrated, contact.into()), (&calibrated, unknown)];
        for (kind, (scene, question)) in questions.into_iter().enumerate() {
            let Some(sensed) = sensed(scene, question, &seen) else { continue };
            answered[kind] += 1;
            held[kind] += usize::from(holds(sensed));
        }
        let exact = Scene { thickness_error: ThicknessError::default(), ..scene.clone() };
        held_without += usize::from(sensed(&exact, contact.into(), &seen).is_some_and(holds));
    }
    println!("held {held:?} of {answered:?}, without the key {held_without} of {cases}");
    for (held, answered) in held.into_iter().zip(answered) {
        assert!(answered as f64 > 0.9 * cases as f64, "{answered} of {cases} answered");
        let share = held as f64 / answered as f64;
        assert!((share - 0.95).abs() < 0.01 + 2.5 * share_error(0.95, answered), "{held} of {answered}");
    }
    assert!((held_without as f64) < 0.5 * cases as f64, "{held_without} of {cases} held without the key");
}

/// Bending rigidities are products of the modulus and the cube of a thickness, so that thicknesses that are all larger by a share cost three times
/// this share of the calibrated modulus; axial and shear deformation change this little. Where the weight hung, forces then depend on the weight alone.
#[test]
fn a_calibrated_modulus_contains_the_thicknesses() {
    let mut chance = random_stream(6601, 0);
    let scene = scene();
    let calibrated = weighed(&scene, &scene.finger, &mut chance);
    let slopes = calibrated.thickness_error.modulus_slopes;
    let expected = -3.0;
    // The arms at the junctions are as long as the members that meet there are thick, which adds to the cube.
    assert!((slopes.iter().sum::<f64>() / expected - 1.0).abs() < 0.15, "{slopes:?} against {expected}");
    assert!(slopes.iter().all(|slope| *slope < 0.0), "{slopes:?}");
    let contact = Contact::at_node(NodeId(7));
    let seen = bent(&scene.finger, contact.load(&scene.finger, 1.0));
    let sigma_n = |scene: &Scene| sensed(scene, contact.into(), &seen).expect("a force").sigma_n;
    let forgotten = Scene { thickness_error: THICKNESS, ..calibrated.clone() };
    assert!(4.0 * sigma_n(&calibrated) < sigma_n(&forgotten), "{} {}", sigma_n(&calibrated), sigma_n(&forgotten));
}

/// A frame with two contacts after one with a single contact ended in a panic.
#[test]
fn the_frame_before_may_show_another_number_of_contacts() {
    let scene = scene();
    let contacts = [at_position(40.0, 0.0), at_position(85.0, 0.0)];
    let seen = bent(&scene.finger, contacts[0].load(&scene.finger, 1.0));
    let sensor = |contacts: &[Contact]| {
        Sensor::new(scene.clone(), SensorContacts::known(contacts), SensorOptions::default()).expect("contacts")
    };
    let before = sensor(&contacts[..1]).sense_displacements(&seen, Some(NOISE_MM), None).expect("a force");
    let found = sensor(&contacts).sense_displacements(&seen, Some(NOISE_MM), Some(&before)).expect("two forces");
    assert_eq!(found.forces.len(), 2);
}
