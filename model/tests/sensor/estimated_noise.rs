//! Forces from markers whose noise is itself an estimate, as after compression.

use finray_model::measurement::MarkerErrors;
use finray_model::observation::{EstimatedNoise, Observation, ObservedMarker};
use finray_model::sensing::{Contact, ContactPosition, ContactQuestion, Direction};
use finray_model::sensor::{Refusal, SensedForces, SensorContacts, SensorOptions, StreamSensor};
use finray_model::{Kinematics, Mesh, Scene, Vector, statics};
use finray_tests::{case_count, random_stream};
use rand::RngExt;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

/// Stated standard deviation of a coordinate, mm.
const STATED_MM: f64 = 0.03;
/// Degrees of freedom from which the stated noise was estimated.
const DEGREES_OF_FREEDOM: f64 = 8.0;

/// Nodes of the mesh, enough for an error far below the noise.
const MESH_NODES: usize = 100;

struct Frame {
    force_n: f64,
    contact: Contact,
    seen: Observation,
}

fn scene() -> Scene {
    Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene")
}

/// A frame whose actual noise is the stated one times a random factor that all markers share.
fn frame(scene: &Scene, case: u64, force_n: impl FnOnce(f64) -> f64, degrees_of_freedom: Option<f64>) -> Frame {
    let chance = &mut random_stream(6700, case);
    let finger = &scene.finger;
    let force_n = force_n(chance.random_range(0.0..1.0));
    let contact = Contact { position: ContactPosition::at(chance.random_range(40.0..110.0)), angle_deg: 0.0 };
    let mesh = Mesh::with_elements_per_member(finger, 4);
    let shape = statics::solve(&mesh, &[contact.load(finger, force_n)], Kinematics::Corotational).expect("carried");
    let spread = ChiSquared::new(DEGREES_OF_FREEDOM).expect("a distribution").sample(chance) / DEGREES_OF_FREEDOM;
    let noise_mm = STATED_MM / f64::sqrt(spread);
    let marker = |node| {
        let [x, y] = [(); 2].map(|()| StandardNormal.sample(chance));
        let displacement = shape.motion(node).marker_displacement(finger) + noise_mm * Vector::new(x, y);
        ObservedMarker { sd_mm: Some(STATED_MM), ..ObservedMarker::displaced(node, displacement) }
    };
    let markers = finger.marked_nodes().map(marker).collect();
    let noise = degrees_of_freedom.map(|degrees_of_freedom| EstimatedNoise { degrees_of_freedom, shared_sd_mm: 0.0 });
    Frame { force_n, contact, seen: Observation { markers, noise, ..Observation::default() } }
}

fn sensed(scene: &Scene, frame: &Frame, is_known: bool) -> Result<Option<SensedForces>, Refusal> {
    let question = match is_known {
        true => frame.contact.into(),
        false => ContactQuestion::new(None, Direction::Auto),
    };
    let contacts = SensorContacts::Asked(vec![question]);
    let options = SensorOptions { mesh_nodes: Some(MESH_NODES), ..SensorOptions::default() };
    StreamSensor::new(scene.clone(), contacts, options).expect("a question").sense(&frame.seen, None)
}

/// Number of refused frames, of sensed forces and of those that the interval contains, of frames with a force.
fn pressed(cases: u64, degrees_of_freedom: Option<f64>, is_known: bool) -> [usize; 3] {
    let (scene, mut counts) = (scene(), [0; 3]);
    for case in 0..cases {
        let frame = frame(&scene, case, |share| 1.0 + 2.0 * share, degrees_of_freedom);
        match sensed(&scene, &frame, is_known) {
            Err(_) => counts[0] += 1,
            Ok(None) => {}
            Ok(Some(sensed)) => {
                let [low_n, high_n] = sensed.forces[0].interval_n();
                counts[1] += 1;
                counts[2] += usize::from((low_n..=high_n).contains(&frame.force_n));
            }
        }
    }
    counts
}

/// A residual of uniform kind changes the noise before it contradicts the model: frames are not refused, and intervals hold. With a known noise, a tenth
/// of the same frames is refused.
#[test]
fn an_estimated_noise_widens_before_it_refuses() {
    let cases = case_count(200, 4000) as u64;
    let [refused, answered, hold] = pressed(cases, Some(DEGREES_OF_FREEDOM), true);
    assert!(refused as f64 <= 0.005 * cases as f64, "{refused} of {cases} refused");
    let share = hold as f64 / answered as f64;
    // Three standard deviations of a share of 0.95.
    let tolerance = 3.0 * (0.95_f64 * 0.05 / answered as f64).sqrt();
    assert!((share - 0.95).abs() < tolerance, "{hold} of {answered} intervals hold");
    let [refused, ..] = pressed(cases, None, true);
    assert!(refused as f64 > 0.05 * cases as f64, "{refused} of {cases} refused with a known noise");
}

/// Free frames with more noise than stated show no force, although a contact at some position and in some direction would explain a part of the noise.
#[test]
fn an_estimated_noise_shows_no_force() {
    let scene = scene();
    let forces = |cases: u64, degrees_of_freedom, is_known| {
        let frames = (0..cases).map(|case| frame(&scene, 50_000 + case, |_| 0.0, degrees_of_freedom));
        frames.filter(|frame| !matches!(sensed(&scene, frame, is_known), Ok(None))).count()
    };
    // Contacts of unknown position take a hundred times as long.
    for (cases, is_known) in [(case_count(2000, 20000) as u64, true), (case_count(10, 200) as u64, false)] {
        let found = forces(cases, Some(DEGREES_OF_FREEDOM), is_known);
        // A frame in 10 000 may show a force by chance: three standard deviations of their number.
        let by_chance = 1e-4 * cases as f64;
        let most = by_chance + 3.0 * by_chance.sqrt();
        assert!(found as f64 <= most, "{found} of {cases} free frames refused or in contact");
    }
    assert!(forces(200, None, true) > 10, "a known noise explains as much");
}

/// An error that all markers of an image share, as compression causes, is part of the interval. Markers do not show it.
#[test]
fn an_error_that_all_markers_share_widens() {
    let (scene, cases, shared_sd_mm) = (scene(), 200, 0.1);
    let held = |stated_sd_mm: f64| {
        let holds = |case: &u64| {
            let mut frame = frame(&scene, *case, |share| 1.0 + 2.0 * share, Some(DEGREES_OF_FREEDOM));
            let chance = &mut random_stream(6701, *case);
            let [x, y] = [(); 2].map(|()| StandardNormal.sample(chance));
            let moved = shared_sd_mm * Vector::new(x, y);
            frame.seen.markers.iter_mut().filter_map(|marker| marker.displacement.as_mut()).for_each(|of| *of += moved);
            frame.seen.noise.iter_mut().for_each(|noise| noise.shared_sd_mm = stated_sd_mm);
            let Ok(Some(sensed)) = sensed(&scene, &frame, true) else { return false };
            let [low_n, high_n] = sensed.forces[0].interval_n();
            (low_n..=high_n).contains(&frame.force_n)
        };
        (0..cases).filter(holds).count() as f64 / cases as f64
    };
    let [stated, not_stated] = [shared_sd_mm, 0.0].map(held);
    assert!(stated > 0.9 && not_stated < 0.8, "{stated} hold, {not_stated} without the shared error");
}

/// A wrong contact is still contradicted: its residual is not of the size that an estimate of the noise may be wrong by.
#[test]
fn a_wrong_contact_is_contradicted() {
    let scene = scene();
    for case in 0..3 {
        let mut frame = frame(&scene, case, |share| 2.0 + share, Some(DEGREES_OF_FREEDOM));
        let s_mm = frame.contact.position_mm(&scene.finger).expect("a position");
        frame.contact.position = ContactPosition::at(if s_mm > 75.0 { s_mm - 35.0 } else { s_mm + 35.0 });
        assert!(
            matches!(sensed(&scene, &frame, true), Err(Refusal::Contradicted { .. } | Refusal::Estimator(_))),
            "{case}"
        );
    }
}

/// The factor of a calibration reduces the noise of images like those it was estimated from, and not what compression adds.
#[test]
fn a_noise_factor_reduces_only_the_noise_it_was_estimated_from() {
    let errors = MarkerErrors { noise_factor: 0.347, noise_factor_of_mm: Some(0.01), calibration_error_mm: 0.0 };
    let sd_mm = |stated_mm: f64| errors.of_image(stated_mm).sd_mm(stated_mm);
    for stated_mm in [0.001, 0.005, 0.01] {
        assert_eq!(sd_mm(stated_mm), 0.347 * stated_mm);
    }
    for stated_mm in [0.02_f64, 0.05, 1.0] {
        // Variances: the known noise is reduced, the rest is not.
        let expected_mm2 = (0.347_f64 * 0.01).powi(2) + stated_mm.powi(2) - 0.01_f64.powi(2);
        assert!((sd_mm(stated_mm).powi(2) / expected_mm2 - 1.0).abs() < 1e-12, "{stated_mm}");
    }
    let unknown = MarkerErrors { noise_factor_of_mm: None, ..errors };
    assert_eq!(unknown.of_image(1.0), unknown);
}
