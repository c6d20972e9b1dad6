//! Maps of where sensing fails.

use super::{Effort, MAP_FORCES_N, Progress, StudyError};
use crate::estimators::{BeamEstimator, EstimatorKind};
use crate::map::{AccuracyMap, MapRequest, accuracy_maps};
use crate::truth::MeshTruth;
use finray_model::{Finger, Kinematics, Mesh};

/// Maps by least squares: linear truth, then large-rotation truth, each at every level of noise.
pub(super) fn maps(
    finger: &Finger,
    coarse: &Mesh,
    corotational: &MeshTruth,
    noise_levels_mm: &[f64],
    effort: Effort,
    progress: &dyn Progress,
) -> Result<Vec<AccuracyMap>, StudyError> {
    let linear = MeshTruth::new("linear", coarse, Kinematics::Linear)?;
    let (places, step_deg, noise_pictures) = effort.resolution();
    let (places_mm, angles_deg) = MapRequest::grid(finger, places, step_deg);
    let cells = places_mm.len() * angles_deg.len();
    let request = MapRequest {
        places_mm,
        angles_deg,
        forces_n: MAP_FORCES_N.to_vec(),
        noise_levels_mm: noise_levels_mm.to_vec(),
        noise_pictures,
        seed: 1,
    };
    let least_squares = BeamEstimator { kind: EstimatorKind::LeastSquares, mesh: coarse };
    let mut maps = Vec::new();
    for (name, truth) in [("map, linear", &linear), ("map, large rotation", corotational)] {
        progress.part(name, cells);
        maps.extend(accuracy_maps(finger, truth, &least_squares, &request, &|| progress.step()));
    }
    Ok(maps)
}
