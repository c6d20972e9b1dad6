//! Searches that start from the forces of another observation.

use finray_model::mesh::Load;
use finray_model::observation::Observation;
use finray_model::sensing::{Contact, ContactPosition, ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions, StreamSensor};
use finray_model::statics::{ArcLength, PathPoint, Statics};
use finray_model::{Kinematics, Mesh, Scene, Vector, statics};
use finray_tests::random_stream;
use rand_distr::{Distribution, StandardNormal};

/// The finger under one force, along the normal of its undeformed plate.
fn seen(scene: &Scene, s_mm: f64, force_n: f64) -> Observation {
    let contact = Contact { position: ContactPosition::at(s_mm), angle_deg: 0.0 };
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
        let asked = SensorContacts::Asked(vec![ContactQuestion::new(None, direction)]);
        let sensor = Sensor::new(scene.clone(), asked, options.clone()).expect("a question");
        let observed = seen(&scene, 80.0, 2.0);
        let expected = sensor.sense(&observed).expect("an answer");
        let near = |force_n: f64, s_mm: f64| {
            let mut near = expected.clone();
            near.forces[0].contact = Contact { position: ContactPosition::at(s_mm), angle_deg: 0.0 };
            near.forces[0].force_n = force_n;
            near
        };
        for before in [near(1.9, 78.0), near(0.5, 30.0), near(-2.0, 80.0), near(500.0, 140.0), expected.clone()] {
            let found = sensor.sense_near(&observed, Some(&before)).expect("an answer");
            let off = (found.forces[0].force_n - expected.forces[0].force_n) / expected.forces[0].sigma_n;
            assert!(off.abs() < 1e-3, "{direction:?} from {:?}: {off} sigma", before.forces);
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
        let asked = SensorContacts::Asked(vec![ContactQuestion::new(None, direction)]);
        let sensor = Sensor::new(scene.clone(), asked.clone(), options.clone()).expect("a question");
        let following = StreamSensor::new(scene.clone(), asked, options.clone()).expect("a question");
        let mut before = None;
        let mut in_contact = 0;
        for observed in &stream {
            let found = following.sense(observed, before.as_ref()).expect("an answer");
            if let Some(found) = &found {
                let expected = sensor.sense_near(observed, before.as_ref()).expect("an answer");
                let off = (found.forces[0].force_n - expected.forces[0].force_n) / expected.forces[0].sigma_n;
                assert!(off.abs() < 1e-4, "{direction:?}: {off} sigma");
                assert!((found.forces[0].sigma_n / expected.forces[0].sigma_n - 1.0).abs() < 1e-3, "{direction:?}");
                let mut others = expected;
                others.forces[0].force_n *= 1.01;
                let of_others = following.clone().sense(observed, Some(&others)).expect("an answer");
                assert_eq!(of_others, Some(sensor.sense_near(observed, Some(&others)).expect("an answer")));
                in_contact += 1;
            }
            before = found;
        }
        assert_eq!(in_contact, 7, "{direction:?}");
    }
}

/// Shapes of the finger under one force: on the branch from rest, at shares of the limit load, and on the stable branch to which the finger then snaps.
fn around_a_snap(scene: &Scene, contact: &Contact, shares: &[f64]) -> (Vec<Observation>, Observation) {
    let mesh = Mesh::with_elements_per_member(&scene.finger, 8);
    let load = mesh.frame_load(&contact.load(&scene.finger, 1.0)).expect("a load on the plate");
    // The path ends where a node has turned by 1.6 rad.
    let has_turned = |point: &PathPoint| point.motion.rotations.iter().any(|turn| turn.abs() > 1.6);
    let path = ArcLength::new(mesh.frame(), Kinematics::Corotational).follow(&[load], 250, has_turned).expect("a path");
    let limit = path.limits.first().expect("a limit point");
    let snapped = path.points[limit.after + 1..].iter().find(|point| point.is_stable()).expect("another stable branch");
    let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
    let mut at = |share: f64| {
        let load = mesh.frame_load(&contact.load(&scene.finger, share * limit.multiple)).expect("a load on the plate");
        let carried = statics.equilibrium(&[load]).expect("carried below the limit load");
        Observation::of_shape(&scene.finger, &mesh.shape(&carried.motion))
    };
    let carried = shares.iter().map(|share| at(*share)).collect();
    (carried, Observation::of_shape(&scene.finger, &mesh.shape(&snapped.motion)))
}

/// A finger approaches its limit load, snaps to another stable branch, and snaps back. A stream reports a force in the same frames as a sensor that starts
/// from rest in each frame, so the shape of an earlier frame leads to no other branch. Forces agree within 1e-3 standard deviations: a stream stops where
/// the next step is expected to move the markers by 5e-3 standard deviations at most, and near the limit load its shape is less exact than elsewhere. The
/// force of a finger that snapped is refused, and all other forces at a known position are sensed.
#[test]
fn a_finger_that_snaps_and_returns_is_sensed_as_from_rest() {
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene");
    let options = SensorOptions { noise_mm: Some(0.02), ..SensorOptions::default() };
    let shares = [0.5, 0.6, 0.9, 0.95, 0.999, 0.7, 0.2];
    for (s_mm, angle_deg) in [(38.25, -90.0), (76.5, 180.0)] {
        let contact = Contact { position: ContactPosition::at(s_mm), angle_deg };
        let (carried, snapped) = around_a_snap(&scene, &contact, &shares);
        let (below, after) = carried.split_at(5);
        let stream = below.iter().chain([&snapped, &snapped, &below[4], &snapped]).chain(after);
        let is_snapped = |frame: usize| [5, 6, 8].contains(&frame);
        for position in [Some(contact.position), None] {
            let question = ContactQuestion::new(position, Direction::Angle(angle_deg));
            let from_rest = StreamSensor::new(scene.clone(), SensorContacts::Asked(vec![question]), options.clone())
                .expect("a question");
            let (following, mut before) = (from_rest.clone(), None);
            for (frame, observed) in stream.clone().enumerate() {
                let case = format!("{contact:?}, known: {}, frame {frame}", position.is_some());
                let found = following.sense(observed, before.as_ref());
                let expected = from_rest.clone().sense(observed, None);
                assert_eq!(found.is_ok(), expected.is_ok(), "{case}: {found:?}, from rest {expected:?}");
                match position {
                    Some(_) => assert_eq!(found.is_ok(), !is_snapped(frame), "{case}: {found:?}"),
                    None => assert!(found.is_err() || !is_snapped(frame), "{case}: {found:?}"),
                }
                before = found.ok().flatten();
                let (Some(found), Ok(Some(expected))) = (&before, expected) else { continue };
                let off = (found.forces[0].force_n - expected.forces[0].force_n) / expected.forces[0].sigma_n;
                assert!(off.abs() < 1e-3, "{case}: {off} sigma");
            }
        }
    }
}
