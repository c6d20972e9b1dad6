//! Maps of contacts that are not known exactly, with all or only some of the markers visible: what users have.

use super::Context;
use crate::prelude::*;
use crate::sampling::map::{AccuracyMap, MapRequest, accuracy_maps};
use crate::sampling::sampled::SampledSensor;
use crate::sampling::situation::ContactKnowledge::{Friction, Frictionless, Misjudged, Nothing, Position};
use crate::sampling::situation::{ContactKnowledge, HiddenMarkers, Situation};
use std::convert::Infallible;

/// The situations, the most common one first: an unknown contact.
pub const SITUATIONS: [Situation; 7] = [
    of(Nothing, HiddenMarkers::None),
    of(Nothing, HiddenMarkers::Object),
    of(Nothing, HiddenMarkers::Tip),
    of(Friction, HiddenMarkers::None),
    of(Frictionless, HiddenMarkers::None),
    of(Position, HiddenMarkers::None),
    of(Misjudged, HiddenMarkers::None),
];

const fn of(contact: ContactKnowledge, hidden: HiddenMarkers) -> Situation {
    Situation { contact, hidden }
}

/// Seed of the noise.
const SEED: u64 = 1;

/// Accuracy maps of the co-rotational finger for the nonlinear estimator, one for each of [`SITUATIONS`]. Empty without noise.
pub(crate) fn run(context: &Context) -> Result<Vec<AccuracyMap>, Infallible> {
    if context.noise_mm == 0.0 {
        return Ok(Vec::new());
    }
    let scene = sensed(context);
    let contacts = |situation| request(context, &scene, situation, context.noise_mm).contact_count();
    context.progress.part("unknown contacts", SITUATIONS.into_iter().map(contacts).sum());
    Ok(SITUATIONS.map(|situation| map(context, situation, context.noise_mm, &|| context.progress.step())).into())
}

/// The scene as the sensor sees it: of its contact, only friction concerns the true finger.
fn sensed(context: &Context) -> Scene {
    let mut scene = context.given.scene.of_same_finger();
    scene.contact.lean = context.given.scene.contact.lean;
    scene
}

/// The grid of a situation's map.
fn request(context: &Context, scene: &Scene, situation: Situation, noise_mm: f64) -> MapRequest {
    let (positions, step_deg, noise_samples) = match situation.contact.is_leaning() {
        true => context.effort.unknown_resolution(),
        false => context.effort.coarse_resolution(),
    };
    let (positions_mm, angles_deg) = MapRequest::of_knowledge(scene, situation.contact, positions, step_deg);
    MapRequest {
        positions_mm,
        angles_deg,
        is_leaning: situation.contact.is_leaning(),
        forces_n: context.forces.of_maps_n().to_vec(),
        noise_levels_mm: vec![noise_mm],
        noise_samples,
        seed: SEED,
    }
}

/// The map of a situation, with a noise of standard deviation `noise_mm`, mm. `progress` is called after each contact.
pub(super) fn map(context: &Context, situation: Situation, noise_mm: f64, progress: &(dyn Fn() + Sync)) -> AccuracyMap {
    let scene = sensed(context);
    let request = request(context, &scene, situation, noise_mm);
    let sensor = SampledSensor { situation, ..SampledSensor::new(EstimatorId::Nonlinear, context.networks) };
    // One sensor and one noise level give one map.
    accuracy_maps(scene, context.corotational, &[sensor], &request, progress).remove(0)
}
