//! What the maps say, in sentences made from their numbers.

use super::ExplainedQuantity;
use crate::prelude::*;
use finray_studies::experiments::explain::Explanation;
use finray_studies::statistics::median;

/// Directions up to this many degrees from the normal count as pressing, those from the second on as tangential.
const PRESSING_DEG: f64 = 20.0;
const TANGENTIAL_DEG: f64 = 60.0;
/// This share of the plate at either end counts as its base and its tip.
const END: f64 = 1.0 / 6.0;
/// A direction known to less than this, degrees, is not known: the nonlinear estimator refuses it.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;

/// What every estimator meets: noise on the one hand, what is not known on the other.
pub(super) fn says(study: &Study) -> Result<Vec<String>, ReportError> {
    let unknown = unknown_direction(study).filter(|_| study.noise_mm > 0.0);
    let said = [say("maps.carried", carried(study))?, say("maps.unknown_direction", unknown)?];
    Ok(said.into_iter().flatten().collect())
}

/// Whether bias or spread is at fault where a map fails.
pub(super) fn kind_of_error(map: &AccuracyMap) -> Result<String, ReportError> {
    let failed: Vec<&MapCell> = map.cells.iter().filter(|cell| cell.is_above(TRUSTED_ERROR) == Some(true)).collect();
    // A cell that is refused has neither.
    let biased = failed.iter().filter(|cell| cell.bias.map(f64::abs) > cell.spread).count();
    let numbers = context! { failed => failed.len(), biased, cells => map.cells.len(), trusted => TRUSTED_ERROR };
    Ok(say("maps.kind_of_error", Some(numbers))?.unwrap_or_default())
}

/// A quantity by direction and by position: medians of pressing and tangential directions, of base, middle and tip.
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

/// How far wrong assumptions carry.
fn carried(study: &Study) -> Option<Value> {
    let (direction, place) = (medians(study, |cell| cell.error_per_deg)?, medians(study, |cell| cell.error_per_mm)?);
    Some(context! { direction, place, pressing_deg => PRESSING_DEG, tangential_deg => TANGENTIAL_DEG })
}
