//! Sentences on the maps.

use super::ExplainedQuantity;
use crate::prelude::*;
use finray_studies::experiments::explain::Explanation;
use finray_studies::statistics::median;

/// A direction counts as pressing within the first angle of the normal, and as tangential beyond the second angle, degrees.
const PRESSING_DEG: f64 = 20.0;
const TANGENTIAL_DEG: f64 = 60.0;
/// Share of the plate's length at either end that counts as base and tip.
const END: f64 = 1.0 / 6.0;
/// The nonlinear estimator refuses an answer whose direction has a larger standard deviation than this, degrees.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;

/// Sentences on the limits of every estimator: noise, and unknown contact.
pub(super) fn says(study: &Study) -> Result<Vec<String>, ReportError> {
    let unknown = unknown_direction(study).filter(|_| study.noise_mm > 0.0);
    let said = [say("maps.carried", carried(study))?, say("maps.unknown_direction", unknown)?];
    Ok(said.into_iter().flatten().collect())
}

/// Sentence that says whether bias or spread dominates in the cells that fail.
pub(super) fn kind_of_error(map: &AccuracyMap) -> Result<String, ReportError> {
    let failed: Vec<&MapCell> = map.cells.iter().filter(|cell| cell.is_above(TRUSTED_ERROR) == Some(true)).collect();
    // A refused cell has neither bias nor spread.
    let biased = failed.iter().filter(|cell| cell.bias.map(f64::abs) > cell.spread).count();
    let numbers = context! { failed => failed.len(), biased, cells => map.cells.len(), trusted => TRUSTED_ERROR };
    Ok(say("maps.kind_of_error", Some(numbers))?.unwrap_or_default())
}

/// Medians of an explaining quantity over pressing and tangential directions, and over base, middle and tip.
fn medians(study: &Study, of: ExplainedQuantity) -> Option<Value> {
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let over = |among: &dyn Fn(&Explanation) -> bool| {
        median(study.explanations.cells.iter().filter(|cell| among(cell)).filter_map(of))
    };
    let pressing = |cell: &Explanation| cell.angle_deg.abs() <= PRESSING_DEG;
    let along = |cell: &Explanation| cell.s_mm / length_mm;
    Some(context! {
        pressing => over(&pressing)?,
        tangential => over(&|cell| cell.angle_deg.abs() >= TANGENTIAL_DEG)?,
        base => over(&|cell| pressing(cell) && along(cell) <= END)?,
        middle => over(&|cell| pressing(cell) && along(cell) > END && along(cell) < 1.0 - END)?,
        tip => over(&|cell| pressing(cell) && along(cell) >= 1.0 - END)?,
    })
}

fn unknown_direction(study: &Study) -> Option<Value> {
    let cells = || study.explanations.cells.iter().filter(|cell| cell.bound.is_some());
    let identifiable =
        cells().filter(|cell| cell.direction_sigma_deg.is_some_and(|sigma| sigma <= LARGEST_ANGLE_SIGMA_DEG)).count();
    Some(context! {
        loss => median(cells().filter_map(|cell| Some(cell.bound_unknown_direction? / cell.bound?)))?,
        condition => median(cells().filter_map(|cell| cell.condition))?,
        force_n => study.explanations.force_n,
        sigma_deg => LARGEST_ANGLE_SIGMA_DEG,
        share => identifiable as f64 / cells().count() as f64,
    })
}

/// Numbers for the sentence on errors of the force from a wrong direction or position.
fn carried(study: &Study) -> Option<Value> {
    let (direction, place) = (medians(study, |cell| cell.error_per_deg)?, medians(study, |cell| cell.error_per_mm)?);
    Some(context! { direction, place, pressing_deg => PRESSING_DEG, tangential_deg => TANGENTIAL_DEG })
}
