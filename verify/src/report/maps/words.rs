//! What the maps say, in sentences made from their numbers.

use super::{Of, small};
use crate::estimators::EstimatorId;
use crate::experiments::explain::Explanation;
use crate::report::format::percent;
use crate::sampling::map::{AccuracyMap, Cell, CellState};
use crate::settings::{DRAWN_FORCE_N, TRUSTED_ERROR};
use crate::study::Study;
use crate::truths::TruthId;
use finray_model::Finger;
use finray_model::finger::Plate;

/// Directions up to this many degrees from the normal count as pressing, those from the second on as tangential.
const PRESSING_DEG: f64 = 20.0;
const TANGENTIAL_DEG: f64 = 60.0;
/// This share of the plate at either end counts as its base and its tip.
const END: f64 = 1.0 / 6.0;
/// A direction known to less than this, degrees, is not known: the nonlinear estimator refuses it.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;

/// The middle one, or the mean of the two in the middle.
pub(super) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len() % 2 == 1 { upper } else { (sorted[middle - 1] + upper) / 2.0 })
}

/// Where a map is worst among some of its cells.
struct Worst {
    error: f64,
    s_mm: f64,
    angle_deg: f64,
}

fn worst(map: &AccuracyMap, among: impl Fn(&Cell) -> bool) -> Option<Worst> {
    map.cells
        .iter()
        .filter(|cell| among(cell))
        .filter_map(|cell| Some(Worst { error: cell.mean_error?, s_mm: cell.s_mm, angle_deg: cell.angle_deg }))
        .max_by(|a, b| a.error.total_cmp(&b.error))
}

/// How far along the plate a position is, and which node is next to it.
fn position(finger: &Finger, s_mm: f64) -> String {
    let distance = |node| finger.front_position_mm(node).map_or(f64::INFINITY, |at: f64| (at - s_mm).abs());
    let nearest = finger.contact_nodes().min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    nearest.map_or_else(|| format!("s = {s_mm:.0} mm"), |node| format!("s = {s_mm:.0} mm, near node {node}"))
}

fn is_drawn(cell: &Cell) -> bool {
    cell.force_n == DRAWN_FORCE_N
}

/// Where linear sensing fails, and what noise adds.
pub(super) fn says(study: &Study) -> Vec<String> {
    let mut sentences = Vec::new();
    let finger = &study.finger;
    if let Some(map) = study.map(TruthId::Corotational, false) {
        let summary = map.summary(Some(DRAWN_FORCE_N));
        if let Some(worst) = worst(map, |cell| is_drawn(cell) && cell.angle_deg == 0.0) {
            sentences.push(format!(
                "Without noise, linear sensing of {DRAWN_FORCE_N} N along the normal of the co-rotational finger errs by \
                 up to {} (at {}); over all positions and directions {} of the cells with an equilibrium err by more than 10 % and \
                 {} by more than 25 % ({}).",
                percent(worst.error),
                position(finger, worst.s_mm),
                percent(summary.share_above_10.unwrap_or(f64::NAN)),
                percent(summary.share_above_25.unwrap_or(f64::NAN)),
                summary.counts()
            ));
        }
        if let Some(worst) = worst(map, is_drawn) {
            sentences.push(format!(
                "Over all directions it fails most at {:.0} deg, at {}: {}.",
                worst.angle_deg,
                position(finger, worst.s_mm),
                percent(worst.error)
            ));
        }
        if summary.without_equilibrium > 0 {
            sentences.push(format!(
                "In {} of {} cells the finger cannot carry {DRAWN_FORCE_N} N: it folds or snaps through before.",
                summary.without_equilibrium, summary.cells
            ));
        }
    }
    if let Some(map) = study.map(TruthId::Linear, true) {
        let smallest = map.request.forces_n.first().copied().unwrap_or(DRAWN_FORCE_N);
        let along_normal = |cell: &Cell| cell.force_n == smallest && cell.angle_deg == 0.0;
        let best = map
            .cells
            .iter()
            .filter(|c| along_normal(c))
            .filter_map(|c| Some((c.mean_error?, c.s_mm)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some(worst), Some(best)) = (worst(map, along_normal), best) {
            sentences.push(format!(
                "Camera noise alone ({} mm a coordinate, linear truth) costs {smallest} N along the normal between {} (at {}) \
                 and {} (at {}).",
                map.noise_mm,
                percent(best.0),
                position(finger, best.1),
                percent(worst.error),
                position(finger, worst.s_mm)
            ));
        }
    }
    sentences
}

/// The sentences below the overview.
pub(super) fn findings(study: &Study) -> Vec<String> {
    let noisy = study.noise_mm > 0.0;
    let mut sentences: Vec<String> =
        EstimatorId::ALL.iter().filter_map(|estimator| failing(study, *estimator, noisy)).collect();
    sentences.extend(study.map(TruthId::Corotational, noisy).and_then(|map| kind_of_error(study, map)));
    sentences.extend(study.map(TruthId::Twin, noisy).and_then(|map| kind_of_error(study, map)));
    if noisy {
        sentences.extend(bound(study));
        sentences.extend(unknown_direction(study));
    }
    sentences.extend(carried(study));
    sentences
}

/// Where one estimator fails, truth by truth.
fn failing(study: &Study, estimator: EstimatorId, noisy: bool) -> Option<String> {
    let parts: Vec<String> = TruthId::ALL
        .iter()
        .filter_map(|&truth| {
            let label = truth.label();
            let map = small(study, truth, estimator, noisy)?;
            let summary = map.summary(Some(DRAWN_FORCE_N));
            let counts = summary.counts();
            Some(match (summary.share_above_10, summary.share_above_25) {
                (Some(above_10), Some(above_25)) => {
                    format!("{} and {} on {label} ({counts})", percent(above_10), percent(above_25))
                }
                _ => format!("no equilibrium on {label} ({counts})"),
            })
        })
        .collect();
    (!parts.is_empty())
        .then(|| {
        format!(
            "{}: share of the cells with an equilibrium that err by more than 10 % and by more than 25 %, refused ones included: \
             {}.",
            capital(estimator.label()),
            parts.join("; ")
        )
    })
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn drawn(map: &AccuracyMap) -> impl Iterator<Item = &Cell> {
    map.cells.iter().filter(|cell| is_drawn(cell))
}

/// Where least squares fails by direction and place, and whether bias or spread is at fault.
fn kind_of_error(study: &Study, map: &AccuracyMap) -> Option<String> {
    let failed: Vec<&Cell> = drawn(map).filter(|cell| fails(cell)).collect();
    if failed.is_empty() {
        return None;
    }
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let share = |among: &dyn Fn(&Cell) -> bool| {
        let (failing, all) = drawn(map)
            .filter(|cell| cell.state() != CellState::WithoutEquilibrium && among(cell))
            .fold((0.0, 0.0), |(failing, all), cell| (failing + f64::from(u8::from(fails(cell))), all + 1.0));
        percent(failing / f64::max(all, 1.0))
    };
    // A cell that is refused has neither; least squares answers wherever the finger bends.
    let biased = failed.iter().filter(|cell| cell.bias.map(f64::abs) > cell.spread).count();
    let spread = median(drawn(map).filter_map(|cell| cell.spread))?;
    Some(format!(
        "Least squares errs by more than {} on the {} finger ({}) in {} of the cells within {PRESSING_DEG} deg of the normal, in {} \
         of those turned further to the tip and in {} of those turned further to the base; in {} of those in the sixth of the \
         plate at the base and {} in the sixth at the tip. The bias exceeds the spread in {} of the cells that fail; the median \
         spread over all cells is {}.",
        percent(TRUSTED_ERROR),
        map.truth.label(),
        map.summary(Some(DRAWN_FORCE_N)).counts(),
        share(&|cell| cell.angle_deg.abs() <= PRESSING_DEG),
        share(&|cell| cell.angle_deg > PRESSING_DEG),
        share(&|cell| cell.angle_deg < -PRESSING_DEG),
        share(&|cell| cell.s_mm <= END * length_mm),
        share(&|cell| cell.s_mm >= (1.0 - END) * length_mm),
        percent(biased as f64 / failed.len() as f64),
        percent(spread)
    ))
}

/// A refused cell fails as well.
fn fails(cell: &Cell) -> bool {
    cell.is_above(TRUSTED_ERROR) == Some(true)
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

fn bound(study: &Study) -> Option<String> {
    let medians = medians(study, |cell| cell.bound)?;
    Some(format!(
        "The bound explains where noise counts: in the median {} for directions within {PRESSING_DEG} deg of the normal and {} \
         from {TANGENTIAL_DEG} deg on; near the normal {} in the sixth of the plate at the base, {} in the middle and {} in the \
         sixth at the tip.",
        percent(medians.pressing),
        percent(medians.tangential),
        percent(medians.base),
        percent(medians.middle),
        percent(medians.tip)
    ))
}

fn unknown_direction(study: &Study) -> Option<String> {
    let cells = || study.explanations.cells.iter().filter(|cell| cell.bound.is_some());
    let loss = median(cells().filter_map(|cell| Some(cell.bound_unknown_direction? / cell.bound?)))?;
    let condition = median(cells().filter_map(|cell| cell.condition))?;
    let identifiable =
        cells().filter(|cell| cell.direction_sigma_deg.is_some_and(|sigma| sigma <= LARGEST_ANGLE_SIGMA_DEG)).count();
    Some(format!(
        "If the direction is sought too, the bound of the force is {loss:.1} times larger in the median; the markers see one component \
         {condition:.0} times better than the other, and the direction is identifiable to {LARGEST_ANGLE_SIGMA_DEG} deg or better in {} of the cells.",
        percent(identifiable as f64 / cells().count() as f64)
    ))
}

/// How far wrong assumptions carry.
fn carried(study: &Study) -> Option<String> {
    let (direction, place) = (medians(study, |cell| cell.error_per_deg)?, medians(study, |cell| cell.error_per_mm)?);
    Some(format!(
        "A direction that is wrong by one degree changes the force by {} in the median near the normal and by {} from \
         {TANGENTIAL_DEG} deg on; a position that is wrong by one millimetre by {} at the base, {} in the middle and {} at the tip \
         (near the normal).",
        percent(direction.pressing),
        percent(direction.tangential),
        percent(place.base),
        percent(place.middle),
        percent(place.tip)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_one() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), Some(2.0));
        assert_eq!(median([4.0, 1.0, 2.0, 3.0].into_iter()), Some(2.5));
        assert_eq!(median(std::iter::empty()), None);
    }

    #[test]
    fn sentences_begin_with_a_capital() {
        assert_eq!(capital("least squares"), "Least squares");
        assert_eq!(capital(""), "");
    }
}
