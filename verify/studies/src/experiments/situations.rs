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
    let &Context { noise_mm, forces, effort, given, .. } = context;
    if noise_mm == 0.0 {
        return Ok(Vec::new());
    }
    let mut scene = given.scene.of_same_finger();
    // Of the scene's contact, only friction concerns the true finger.
    scene.contact.lean = given.scene.contact.lean;
    let scene = PreparedScene::from(scene);
    let request = |situation: Situation| {
        let (positions, step_deg, noise_samples) = match situation.contact.is_leaning() {
            true => effort.unknown_resolution(),
            false => effort.coarse_resolution(),
        };
        let (positions_mm, angles_deg) = MapRequest::of_knowledge(&scene, situation.contact, positions, step_deg);
        MapRequest {
            positions_mm,
            angles_deg,
            is_leaning: situation.contact.is_leaning(),
            forces_n: forces.of_maps_n().to_vec(),
            noise_levels_mm: vec![noise_mm],
            noise_samples,
            seed: SEED,
        }
    };
    let plans = SITUATIONS.map(|situation| (situation, request(situation)));
    context.progress.part("unknown contacts", plans.iter().map(|(_, request)| request.contact_count()).sum());
    let map = |(situation, request): (Situation, MapRequest)| {
        let sensor = SampledSensor { situation, ..SampledSensor::new(EstimatorId::Nonlinear, context.networks) };
        accuracy_maps(scene.clone(), context.corotational, &[sensor], &request, &|| context.progress.step())
    };
    Ok(plans.into_iter().flat_map(map).collect())
}
