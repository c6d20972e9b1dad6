//! What the maps say, in sentences made from their numbers.

use super::Of;
use crate::experiments::explain::Explanation;
use crate::report::format::percent;
use crate::sampling::map::{AccuracyMap, Cell};
use crate::settings::TRUSTED_ERROR;
use crate::study::Study;
use finray_model::finger::Plate;

/// Directions up to this many degrees from the normal count as pressing, those from the second on as tangential.
const PRESSING_DEG: f64 = 20.0;
const TANGENTIAL_DEG: f64 = 60.0;
/// This share of the plate at either end counts as its base and its tip.
const END: f64 = 1.0 / 6.0;
/// A direction known to less than this, degrees, is not known: the nonlinear estimator refuses it.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;

/// The middle one, or the mean of the two in the middle.
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len() % 2 == 1 { upper } else { (sorted[middle - 1] + upper) / 2.0 })
}

/// What every estimator meets: noise on the one hand, what is not known on the other.
pub(super) fn says(study: &Study) -> Vec<String> {
    if study.noise_mm == 0.0 {
        carried(study).into_iter().collect()
    } else {
        [carried(study), unknown_direction(study)].into_iter().flatten().collect()
    }
}

/// Whether bias or spread is at fault where a map fails.
pub(super) fn kind_of_error(map: &AccuracyMap) -> String {
    let failed: Vec<&Cell> = map.cells.iter().filter(|cell| cell.is_above(TRUSTED_ERROR) == Some(true)).collect();
    // A cell that is refused has neither.
    let biased = failed.iter().filter(|cell| cell.bias.map(f64::abs) > cell.spread).count();
    match failed.len() {
        0 => format!("No force at any cell errs by more than {}.", percent(TRUSTED_ERROR)),
        failed => format!(
            "{failed} of {} forces err by more than {}: in {biased} of them the bias, which no better camera mends, exceeds the spread by noise.",
            map.cells.len(),
            percent(TRUSTED_ERROR)
        ),
    }
}

/// A quantity by direction and by position: medians of pressing and tangential directions, of base, middle and tip.
struct Medians {
    pressing: f64,
    tangential: f64,
    base: f64,
    middle: f64,
    tip: f64,
}

fn medians(study: &Study, of: Of) -> Option<Medians> {
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let over = |among: &dyn Fn(&Explanation) -> bool| {
        median(study.explanations.cells.iter().filter(|cell| among(cell)).filter_map(of))
    };
    let pressing = |cell: &Explanation| cell.angle_deg.abs() <= PRESSING_DEG;
    let along = |cell: &Explanation| cell.s_mm / length_mm;
    Some(Medians {
        pressing: over(&pressing)?,
        tangential: over(&|cell| cell.angle_deg.abs() >= TANGENTIAL_DEG)?,
        base: over(&|cell| pressing(cell) && along(cell) <= END)?,
        middle: over(&|cell| pressing(cell) && along(cell) > END && along(cell) < 1.0 - END)?,
        tip: over(&|cell| pressing(cell) && along(cell) >= 1.0 - END)?,
    })
}

fn unknown_direction(study: &Study) -> Option<String> {
    let cells = || study.explanations.cells.iter().filter(|cell| cell.bound.is_some());
    let loss = median(cells().filter_map(|cell| Some(cell.bound_unknown_direction? / cell.bound?)))?;
    let condition = median(cells().filter_map(|cell| cell.condition))?;
    let identifiable =
        cells().filter(|cell| cell.direction_sigma_deg.is_some_and(|sigma| sigma <= LARGEST_ANGLE_SIGMA_DEG)).count();
    Some(format!(
        "If the direction is sought too, the bound of the force is {loss:.1} times larger in the median; the markers see one component \
         {condition:.0} times better than the other, and at {} N the direction's bound is {LARGEST_ANGLE_SIGMA_DEG} deg (beyond it an answer is \
         refused) or less in {} of the cells.",
        study.explanations.force_n,
        percent(identifiable as f64 / cells().count() as f64)
    ))
}

/// How far wrong assumptions carry.
fn carried(study: &Study) -> Option<String> {
    let (direction, place) = (medians(study, |cell| cell.error_per_deg)?, medians(study, |cell| cell.error_per_mm)?);
    Some(format!(
        "A contact position that is 1 mm wrong changes the force by {} near the base, {} in the middle, {} near the tip; a direction that is 1 deg \
         wrong by {} near the normal, {} from {TANGENTIAL_DEG} deg on (medians, to first order; positions with forces within {PRESSING_DEG} deg of the normal).",
        percent(place.base),
        percent(place.middle),
        percent(place.tip),
        percent(direction.pressing),
        percent(direction.tangential)
    ))
}
