//! Standard deviations that a sensor is expected to state, before the finger is pressed.

use super::{PreparedScene, Refusal, Sensor, SensorContacts, SensorOptions};
use crate::estimators::{ELEMENTS, EstimatorError};
use crate::observation::{Observation, ObservedMarker};
use crate::sensing::{Contact, ContactPosition, ContactQuestion, Direction, SensingError};
use crate::{Kinematics, Mesh, statics};

/// Expected standard deviations of a force along the undeformed normal, N.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpectedSigma {
    /// If position and direction of the force are known.
    pub known_n: Result<f64, Refusal>,
    /// If both are unknown.
    pub unknown_n: Result<f64, Refusal>,
}

/// The standard deviations for a force of `force_n`, N, at `s_mm` along the front plate of a scene's finger. `at_rest` contains the markers of the unloaded
/// finger with their standard deviations; a marker that it lacks counts as hidden. The finger is simulated without noise.
///
/// # Errors
/// [`Refusal`] if the finger has no equilibrium under the force.
pub fn expected_sigma(
    scene: &PreparedScene,
    at_rest: &Observation,
    s_mm: f64,
    force_n: f64,
) -> Result<ExpectedSigma, Refusal> {
    let finger = &scene.finger;
    let contact = Contact { position: ContactPosition::at(s_mm), angle_deg: 0.0 };
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let shape = statics::solve(&mesh, &[contact.load(finger, force_n)], Kinematics::Corotational)
        .map_err(|error| EstimatorError::from(SensingError::from(error)))?;
    let pressed = |marker: &ObservedMarker| ObservedMarker {
        displacement: Some(shape.motion(marker.node).marker_displacement(finger)),
        position: None,
        ..*marker
    };
    let seen = Observation { markers: at_rest.markers.iter().map(pressed).collect(), ..at_rest.clone() };
    let sigma = |question: ContactQuestion| {
        let sensor = Sensor::new(scene.clone(), SensorContacts::Asked(vec![question]), SensorOptions::default())?;
        Ok(sensor.sense(&seen)?.forces[0].sigma_n)
    };
    Ok(ExpectedSigma { known_n: sigma(contact.into()), unknown_n: sigma(ContactQuestion::new(None, Direction::Auto)) })
}
