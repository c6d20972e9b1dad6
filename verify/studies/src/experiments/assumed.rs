//! Sensing with an assumed contact: its position and direction are wrong by as much as a user may misjudge them.

use super::Context;
use crate::prelude::*;
use crate::sampling::map::{AccuracyMap, MapRequest, accuracy_maps};
use crate::sampling::sampled::SampledSensor;
use crate::settings::{DIRECTION_OFF_DEG, POSITION_OFF_MM};
use crate::truths::TruthError;

/// Number of combinations of a position error and a direction error, each of either sign.
const SIDES: usize = 4;

/// Accuracy map of the co-rotational finger for the nonlinear estimator with [misjudged contacts](misjudged). `None` without noise.
pub(crate) fn run(context: &Context) -> Result<Option<AccuracyMap>, TruthError> {
    let &Context { finger, noise_mm, forces, effort, .. } = context;
    if noise_mm == 0.0 {
        return Ok(None);
    }
    let (positions, step_deg, _) = effort.coarse_resolution();
    let (positions_mm, angles_deg) = MapRequest::grid(finger, positions, step_deg);
    let request = MapRequest {
        positions_mm,
        angles_deg,
        forces_n: forces.of_maps_n().to_vec(),
        noise_levels_mm: vec![noise_mm],
        noise_samples: SIDES,
        seed: 1,
    };
    context.progress.part("assumed contacts", request.contact_count());
    let sensor = SampledSensor { stated: misjudged, ..SampledSensor::new(EstimatorId::Nonlinear, context.networks) };
    let scene = Scene::of_finger(finger.clone());
    Ok(accuracy_maps(scene, context.corotational, &[sensor], &request, &|| context.progress.step()).pop())
}

/// Contacts with a wrong position (by [`POSITION_OFF_MM`]) and a wrong direction (by [`DIRECTION_OFF_DEG`]), for each combination of signs.
/// Positions off the plate are omitted, unless all are.
pub fn misjudged(finger: &Finger, contact: Contact) -> Vec<Contact> {
    let length_mm = finger.plate_length_mm(Plate::Front);
    let s_mm = contact.position_mm(finger).unwrap_or(f64::NAN);
    let off = |(by_mm, by_deg)| Contact {
        position: ContactPosition::at(s_mm + by_mm),
        angle_deg: contact.angle_deg + by_deg,
    };
    let signs =
        [-POSITION_OFF_MM, POSITION_OFF_MM].map(|mm| [-DIRECTION_OFF_DEG, DIRECTION_OFF_DEG].map(|deg| (mm, deg)));
    let all: Vec<Contact> = signs.concat().into_iter().map(off).collect();
    let on_plate = |contact: &&Contact| matches!(contact.position, ContactPosition::At(at) if at.s_mm > 0.0 && at.s_mm <= length_mm);
    let on: Vec<Contact> = all.iter().filter(on_plate).copied().collect();
    if on.is_empty() { all } else { on }
}
