//! `press`, `grasp` and `sense` agree: an observation gives the same forces whether it stays in memory or is read from a table.

use finray_contact::press::{ContactScene, SensedStep, read_contact};
use finray_files::observations::{Coordinates, ObservationTable, to_csv};
use finray_fixtures::{BOX_SCENE, DISC_SCENE, FRICTION_SCENE, GRASPED_DISC_SCENE};
use finray_model::Scene;
use finray_model::observation::Observation;
use finray_model::sensing::MeasuredContact;
use finray_model::sensor::{SensedForces, Sensor, SensorContacts, SensorOptions};
use finray_studies::experiments::grasp::{Eyes, GraspScene};
use finray_studies::settings::CAMERA_NOISE_MM;
use std::path::Path;

/// Forces that a sensor computes from an observation, and from the same observation after it was written to a table and read again.
fn sensed_twice(scene: &Scene, contacts: &[MeasuredContact], friction: f64, seen: &Observation) -> [SensedForces; 2] {
    let contacts = SensorContacts::Measured { contacts: contacts.to_vec(), friction };
    let options = SensorOptions { noise_mm: Some(CAMERA_NOISE_MM), ..SensorOptions::default() };
    let sensor = Sensor::new(scene.clone(), contacts, options).unwrap();
    let text = to_csv(&[Ok(seen.clone())]).unwrap();
    let table = ObservationTable::new(Path::new("-"), &text, &scene.finger, Coordinates::Displacements).unwrap();
    [seen.clone(), table.observation(None).unwrap()].map(|seen| sensor.sense(&seen).unwrap())
}

fn assert_alike(scene: &Scene, friction: f64, seen: &Observation, step: &SensedStep) {
    let read: Vec<MeasuredContact> = step.contacts.iter().map(|contact| contact.read).collect();
    for sensed in sensed_twice(scene, &read, friction, seen) {
        let own = step.contacts.iter().map(|contact| (contact.force.sensed_n, contact.force.sigma_n));
        let other = sensed.forces.iter().map(|force| (force.force_n, force.sigma_n));
        assert!(own.eq(other), "{step:?} and {sensed:?}");
    }
}

#[test]
fn press_senses_as_a_sensor_does() {
    let mut compared = 0;
    for text in [DISC_SCENE, BOX_SCENE, FRICTION_SCENE] {
        let scene = Scene::from_toml(text).unwrap();
        let object = scene.object.clone().unwrap();
        let pressed = ContactScene::new(&scene, &object, &[]).unwrap().with_fineness(1);
        let run = pressed.run(|step| {
            // Every noise number is zero, so the contacts are read without error; their stated standard deviations are those of the noise.
            let Some(sensed) = pressed.sense(&step, CAMERA_NOISE_MM, || 0.0).unwrap() else { return };
            let felt = step.contacts.iter().filter(|contact| !contact.clamped);
            let read: Vec<_> = felt.map(|seen| read_contact(&scene.finger, seen, CAMERA_NOISE_MM, || 0.0)).collect();
            assert!(read.iter().eq(sensed.contacts.iter().map(|contact| &contact.read)));
            let seen = Observation::of_shape(&scene.finger, &step.pressed.shape);
            assert_alike(&scene, object.friction, &seen, &sensed);
            compared += 1;
        });
        run.unwrap();
    }
    assert!(compared >= 6, "{compared} steps");
}

#[test]
fn grasp_senses_as_a_sensor_does() {
    let scene = Scene::from_toml(GRASPED_DISC_SCENE).unwrap();
    let friction = scene.object.as_ref().unwrap().friction;
    let grasp = GraspScene::new(&scene, &[]).unwrap().with_fineness(1);
    let mut compared = 0;
    let ended = grasp.run(&Eyes::Noise(0.0), 1, |step| {
        for finger in &step.fingers {
            let Ok(Some(sensed)) = &finger.sensed else { continue };
            // Without noise, `grasp` assumes the standard deviation `LEAST_STATED_MM`, so the sensor gets this value.
            let scene = Scene { noise_mm: None, ..scene.clone() };
            let contacts: Vec<MeasuredContact> = sensed.contacts.iter().map(|contact| contact.read).collect();
            let contacts = SensorContacts::Measured { contacts, friction };
            let options =
                SensorOptions { noise_mm: Some(finray_studies::settings::LEAST_STATED_MM), ..SensorOptions::default() };
            let seen = Observation::of_shape(&scene.finger, &finger.shape);
            let found = Sensor::new(scene.clone(), contacts, options).unwrap().sense(&seen).unwrap();
            let own = sensed.contacts.iter().map(|contact| (contact.force.sensed_n, contact.force.sigma_n));
            assert!(own.eq(found.forces.iter().map(|force| (force.force_n, force.sigma_n))), "{sensed:?}");
            compared += 1;
        }
    });
    ended.unwrap();
    assert!(compared >= 20, "{compared} fingers");
}
