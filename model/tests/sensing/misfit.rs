//! Intervals of forces on fingers with an error that the scene does not state, so that the residual contradicts the stated noise.

use finray_model::finger::{Part, RibPositions, Zone};
use finray_model::mesh::Load;
use finray_model::observation::{Observation, ObservedMarker};
use finray_model::sensing::{ContactPosition, ContactQuestion, Direction, Warning};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions, SensorWarning};
use finray_model::{Finger, Kinematics, Mesh, Scene, Vector, statics};
use finray_tests::{TWO_SIDED_95, case_count, random_stream};
use nalgebra::{Isometry2, Point2};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const NOISE_MM: f64 = 0.02;
/// Noise does not explain a residual with a p-value below this limit.
const MISFIT: f64 = 1e-7;

/// A difference between the true finger and the finger of the scene that the scene does not state.
#[derive(Debug, Clone, Copy)]
enum Unknown {
    Ribs,
    Zone,
    Scale,
    Base,
    Preload,
}

fn normal(chance: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(chance)
}

/// The true finger.
fn differing(finger: &Finger, unknown: Unknown, chance: &mut ChaCha8Rng) -> Finger {
    let mut description = finger.description().clone();
    let (length_mm, ribs) = (description.front_length_mm, finger.rib_count());
    match unknown {
        Unknown::Ribs => {
            let even = |rib| [(rib + 1) as f64 * length_mm / (ribs + 1) as f64; 2];
            let at = match &description.ribs.positions {
                RibPositions::Positions(at) => at.clone(),
                RibPositions::Count(_) => (0..ribs).map(even).collect(),
            };
            let off = at.into_iter().map(|at| at.map(|mm| mm + 0.5 * normal(chance))).collect();
            description.ribs.positions = RibPositions::Positions(off);
        }
        Unknown::Zone => {
            let from_mm = chance.random_range(0.1..0.7) * length_mm;
            let modulus_factor = chance.random_range(0.4..0.8);
            let to_mm = from_mm + 0.2 * length_mm;
            description.zones.push(Zone { part: Part::Front, from_mm, to_mm, modulus_factor });
        }
        Unknown::Scale | Unknown::Base | Unknown::Preload => {}
    }
    Finger::new(description).expect("a finger")
}

/// Error of a force, as a multiple of its stated standard deviation. Returns `None` if the finger has no equilibrium, if the force is refused, or if
/// noise explains the residual. Forces are up to `largest_n`.
fn error(scene: &Scene, unknown: Unknown, knows_position: bool, case: u64, largest_n: f64) -> Option<f64> {
    let chance = &mut random_stream(4700, case);
    let finger = differing(&scene.finger, unknown, chance);
    let length_mm = finger.plate_length_mm(finray_model::finger::Plate::Front);
    let force_n = chance.random_range(0.2..1.0) * largest_n;
    let (s_mm, angle_deg) = (chance.random_range(0.3..0.7) * length_mm, chance.random_range(-20.0..20.0));
    let mut loads = vec![Load::at_position(s_mm, finger.direction(angle_deg) * force_n)];
    let (mut scale, mut base) = (1.0, Isometry2::identity());
    match unknown {
        Unknown::Ribs | Unknown::Zone => {}
        Unknown::Scale => scale += 0.005 * normal(chance),
        Unknown::Base => {
            base = Isometry2::new(0.3 * Vector::new(normal(chance), normal(chance)), 0.005 * normal(chance))
        }
        Unknown::Preload => {
            let moment_nmm = 0.02 * largest_n * length_mm * normal(chance);
            loads.push(Load::Node { node: finger.tip(), force: Vector::zeros(), moment_nmm });
        }
    }
    let mesh = Mesh::with_elements_per_member(&finger, 8);
    let shape = statics::solve(&mesh, &loads, Kinematics::Corotational).ok()?;
    let marker = |node| {
        let at = finger.marker_position(node) + shape.motion(node).marker_displacement(&finger);
        let noise = NOISE_MM * Vector::new(normal(chance), normal(chance));
        let at = (base * Point2::from(at)).coords * scale + noise;
        ObservedMarker {
            node,
            pixel: None,
            position: None,
            displacement: Some(at - scene.finger.marker_position(node)),
            sd_mm: Some(NOISE_MM),
            own_sd_mm: Some(NOISE_MM),
        }
    };
    let seen = Observation {
        image: String::new(),
        markers: finger.marked_nodes().map(marker).collect(),
        base: None,
        ..Observation::default()
    };
    let position = knows_position.then_some(ContactPosition::at(s_mm));
    let question = ContactQuestion::new(position, Direction::Angle(angle_deg));
    let sensor = Sensor::new(scene.clone(), SensorContacts::Asked(vec![question]), SensorOptions::default());
    let sensed = sensor.expect("a question").sense(&seen).ok()?;
    let is_misfit = |warning: &SensorWarning| matches!(warning, SensorWarning::Model { warning: Warning::Residual(test), .. } if test.p_value() < MISFIT);
    let is_warned = sensed.warnings.iter().any(is_misfit);
    is_warned.then(|| (sensed.forces[0].force_n - force_n) / sensed.forces[0].sigma_n)
}

/// The finger has an error that the scene does not state: 0.5 mm in the ribs, a softer part of the plate, 0.5 % in the scale, 0.3 mm and 0.3 degrees
/// in the base, or a preload. If noise does not explain the residual, 95 % intervals contain the force in nine of ten cases. If the whole residual
/// were treated as noise, intervals would contain the force in only five of ten cases.
#[test]
fn intervals_hold_on_fingers_that_do_not_fit_their_scene() {
    let cases = case_count(10, 200) as u64;
    let fingers = [(finray_fixtures::PAPER_SCENE, 3.0), (finray_fixtures::BRACKETED_SCENE, 8.0)];
    let mut all = Vec::new();
    for (text, largest_n) in fingers {
        let scene = Scene { base: None, ..Scene::from_toml(text).expect("a scene") };
        for unknown in [Unknown::Ribs, Unknown::Zone, Unknown::Scale, Unknown::Base, Unknown::Preload] {
            for knows_position in [true, false] {
                let of_case = |case| error(&scene, unknown, knows_position, case, largest_n);
                let errors: Vec<f64> = (0..cases).filter_map(of_case).collect();
                let within = errors.iter().filter(|sigmas| sigmas.abs() < TWO_SIDED_95).count();
                println!("{unknown:?}, position {knows_position}: {within} of {} within", errors.len());
                all.extend(errors);
            }
        }
    }
    let within = all.iter().filter(|sigmas| sigmas.abs() < TWO_SIDED_95).count();
    println!("{within} of {} within", all.len());
    assert!(all.len() as f64 > 10.0 * cases as f64, "{} answers with a misfit", all.len());
    assert!(within as f64 > 0.9 * all.len() as f64, "{within} of {}", all.len());
}
