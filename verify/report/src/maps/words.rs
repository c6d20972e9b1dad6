//! Sentences on the maps.

use super::ExplainedQuantity;
use crate::format::{list, percent};
use crate::prelude::*;
use finray_studies::experiments::explain::Explanation;
use finray_studies::statistics::median;

/// A force counts as pressing if its angle to the normal is at most `PRESSING_DEG`, and as tangential if this angle is at least `TANGENTIAL_DEG`,
/// degrees.
const PRESSING_DEG: f64 = 20.0;
const TANGENTIAL_DEG: f64 = 60.0;
/// Length of the region at each end of the plate that counts as base or tip, as a share of the plate's length.
const END: f64 = 1.0 / 6.0;
/// The nonlinear estimator refuses an answer whose direction has a larger standard deviation than this, degrees.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;

/// Caption of the overview.
pub(super) fn overview(study: &Study) -> String {
    let forces_n = list(study.forces.of_maps_n(), ", ");
    let noise = match study.noise_mm {
        0.0 => "no noise".to_owned(),
        noise_mm => format!("{noise_mm} mm noise"),
    };
    let exported = study.map_by(TruthId::Mujoco, EstimatorId::LeastSquares, study.noise_mm > 0.0);
    let of_paper = match exported {
        None => "Softer ends, lattice, MuJoCo and networks exist only for the paper's finger.".to_owned(),
        Some(map) => format!(
            "Networks are evaluated for forces along the normal at contact nodes; MuJoCo's shapes are evaluated for forces of {} N at the nodes.",
            list(&map.request.forces_n, " and ")
        ),
    };
    format!(
        "Largest of the mean errors under {forces_n} N, {noise}, contact known. Rows: the true finger; columns: the estimator, which knows only the \
         uniform finger. Shares refer to the cells (position and direction) with an equilibrium. {of_paper}"
    )
}

/// Sentences on the limits of every estimator: noise, and unknown contact.
pub(super) fn says(study: &Study) -> Vec<String> {
    let unknown = unknown_direction(study).filter(|_| study.noise_mm > 0.0);
    [carried(study), unknown].into_iter().flatten().collect()
}

/// Sentence that says whether bias or spread dominates in the cells that fail.
pub(super) fn kind_of_error(map: &AccuracyMap) -> String {
    let failed: Vec<&MapCell> = map.cells.iter().filter(|cell| cell.is_above(TRUSTED_ERROR) == Some(true)).collect();
    // A refused cell has neither bias nor spread.
    let biased = failed.iter().filter(|cell| cell.bias.map(f64::abs) > cell.spread).count();
    let (failed, cells, trusted) = (failed.len(), map.cells.len(), percent(TRUSTED_ERROR));
    match failed {
        0 => format!("No force at any cell errs by more than {trusted}."),
        _ => format!(
            "{failed} of {cells} forces err by more than {trusted}. For {biased} of the {failed} the bias, which a better camera does not reduce, \
             exceeds the spread due to noise."
        ),
    }
}

/// Sentence on the bounds of force and direction if both are unknown.
fn unknown_direction(study: &Study) -> Option<String> {
    let cells = || study.explanations.cells.iter().filter(|cell| cell.bound.is_some());
    let identifiable =
        cells().filter(|cell| cell.direction_sigma_deg.is_some_and(|sigma| sigma <= LARGEST_ANGLE_SIGMA_DEG)).count();
    let loss = median(cells().filter_map(|cell| Some(cell.bound_unknown_direction? / cell.bound?)))?;
    let condition = median(cells().filter_map(|cell| cell.condition))?;
    let (force_n, share) = (study.explanations.force_n, percent(identifiable as f64 / cells().count() as f64));
    Some(format!(
        "If the direction is unknown, the bound of the force is {loss:.1} times as large in the median. The \
            markers determine one component of the force {condition:.0} times better than the other. At {force_n} N \
            the direction's bound is at most {LARGEST_ANGLE_SIGMA_DEG} deg in {share} of the cells; above this limit \
            an answer is refused."
    ))
}

/// Sentence on the median errors of the force due to a wrong position or a wrong direction.
fn carried(study: &Study) -> Option<String> {
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let over = |of: ExplainedQuantity, among: &dyn Fn(&Explanation) -> bool| {
        median(study.explanations.cells.iter().filter(|cell| among(cell)).filter_map(of)).map(percent)
    };
    let is_pressing = |cell: &Explanation| cell.angle_deg.abs() <= PRESSING_DEG;
    let along = |cell: &Explanation| cell.s_mm / length_mm;
    let by_position =
        |among: &dyn Fn(f64) -> bool| over(|cell| cell.error_per_mm, &|cell| is_pressing(cell) && among(along(cell)));
    let base = by_position(&|along| along <= END)?;
    let middle = by_position(&|along| along > END && along < 1.0 - END)?;
    let tip = by_position(&|along| along >= 1.0 - END)?;
    let pressing = over(|cell| cell.error_per_deg, &is_pressing)?;
    let tangential = over(|cell| cell.error_per_deg, &|cell| cell.angle_deg.abs() >= TANGENTIAL_DEG)?;
    Some(format!(
        "A contact position that is 1 mm wrong changes the force by {base} near the base, {middle} in the middle and {tip} near the tip. A direction \
         that is 1 deg wrong changes the force by {pressing} near the normal, and by {tangential} at {TANGENTIAL_DEG} deg or more from the normal. \
         These are medians, to first order; the medians for positions include only forces within {PRESSING_DEG} deg of the normal."
    ))
}
