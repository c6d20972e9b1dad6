//! Accuracy maps for every true finger and estimator.

use super::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::map::{AccuracyMap, MapRequest, accuracy_maps};
use crate::sampling::sampled::SampledSensor;
use crate::truths::{Truth, TruthError, TruthId};

impl Evidence for AccuracyMap {}

struct Plan {
    truth: TruthId,
    estimator: EstimatorId,
    request: MapRequest,
}

/// Computes a map for each true finger and estimator. For scenes other than the paper's, the only true fingers are those made of the scene's own
/// beams. The continuum has no map, because its
/// material and rods are not those of the paper's scene. The claim on solid elements states the factor by which material and rods stiffen the finger.
pub(crate) fn run(context: &Context) -> Result<Vec<AccuracyMap>, TruthError> {
    let finger = context.finger;
    let is_mapped = |id: &TruthId| id.kinematics().is_some() || context.is_paper && *id != TruthId::Continuum;
    let ids: Vec<TruthId> = TruthId::ALL.iter().copied().filter(is_mapped).collect();
    let meshes = ids.iter().map(|id| id.mesh(finger)).collect::<Result<Vec<_>, _>>()?;
    let truths = ids.iter().zip(&meshes).map(|(id, mesh)| id.on(mesh, &context.given.scene));
    let truths = truths.collect::<Result<Vec<_>, _>>()?;
    let mut plans = Vec::new();
    for truth in &truths {
        for &estimator in EstimatorId::ALL {
            plans.extend(plan(context, &**truth, estimator)?);
        }
    }
    context.progress.part("maps", plans.iter().map(|plan| plan.request.contact_count()).sum());
    let scene = PreparedScene::from(context.given.scene.of_same_finger());
    // Maps with the same grid and true finger are computed together, so that each true shape is computed once.
    let maps = |plans: &[Plan]| {
        let sensor = |plan: &Plan| SampledSensor::new(plan.estimator, context.networks);
        let sensors: Vec<SampledSensor> = plans.iter().map(sensor).collect();
        let Plan { truth, request, .. } = &plans[0];
        let truth = truths.iter().find(|candidate| candidate.id() == *truth);
        let of = |truth: &dyn Truth| {
            accuracy_maps(scene.clone(), truth, &sensors, request, &|| {
                sensors.iter().for_each(|_| context.progress.step())
            })
        };
        truth.map_or_else(Vec::new, |truth| of(&**truth))
    };
    let share_grid = |a: &Plan, b: &Plan| a.truth == b.truth && a.request == b.request;
    Ok(plans.chunk_by(share_grid).flat_map(maps).collect())
}

/// Grid of the map of an estimator on a true finger. Only networks, and least squares on the scene's own beams, get the finest grid. `None` without
/// such a map.
fn plan(context: &Context, truth: &dyn Truth, estimator: EstimatorId) -> Result<Option<Plan>, TruthError> {
    if estimator.at_nodes() && !context.is_paper {
        return Ok(None);
    }
    let effort = context.effort;
    // The shapes of the linear finger and of the twin differ strongly from the shapes of the scene's co-rotational beams.
    let unexplained = estimator.searches() && matches!(truth.id(), TruthId::Linear | TruthId::Twin);
    let (positions, step_deg, noise_samples) = match estimator {
        EstimatorId::LeastSquares if truth.id().kinematics().is_some() => effort.resolution(),
        _ if estimator.at_nodes() => effort.resolution(),
        _ if unexplained => effort.few_samples(),
        // Shapes of the lattice take milliseconds.
        _ if truth.id() == TruthId::Lattice => effort.lattice_resolution(estimator.searches()),
        _ => effort.coarse_resolution(),
    };
    let mut noise_levels_mm = context.noise_levels_mm();
    if unexplained {
        noise_levels_mm.drain(..noise_levels_mm.len() - 1);
    }
    let mut forces_n = context.forces.of_maps_n().to_vec();
    forces_n.retain(|force_n| truth.positions(&[*force_n]).is_ok());
    if forces_n.is_empty() {
        return Ok(None);
    }
    let (positions_mm, angles_deg) = match truth.positions(&forces_n)? {
        Some(positions) if !estimator.at_nodes() => positions,
        _ if estimator.at_nodes() => {
            let nodes = context.finger.contact_nodes().rev();
            (nodes.filter_map(|node| context.finger.front_position_mm(node)).collect(), vec![0.0])
        }
        _ => MapRequest::grid(context.finger, positions, step_deg),
    };
    let is_leaning = false;
    let request =
        MapRequest { positions_mm, angles_deg, is_leaning, forces_n, noise_levels_mm, noise_samples, seed: 1 };
    Ok(Some(Plan { truth: truth.id(), estimator, request }))
}
