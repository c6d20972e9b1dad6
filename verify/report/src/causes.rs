//! Causes of sensing errors: maps of the largest cause, the error due to each cause along the finger, and remedies.

mod drawings;
mod rows;
mod shares;

use self::drawings::{clearing, map_figure, remedies};
use self::shares::{Region, Shares};
use super::format::{error_as, list, percent};
use crate::prelude::*;
use finray_studies::experiments::causes::{
    Cause, CauseCell, CauseMap, ContactKnowledge, DIRECTION_OFF_DEG, POSITION_OFF_MM, Practice,
};

const CSV: &str = "causes.csv";
/// Number of drawn maps of the largest cause: least squares with known contact, and least squares with assumed contact.
const DRAWN: usize = 2;
/// The simulated true finger that equals the scene's finger.
const OWN: TruthId = TruthId::Corotational;
/// The simulated true finger that was fitted to the paper's Table I.
const FITTED: TruthId = TruthId::Twin;

/// Text that names the regions in which the nonlinear estimator fails for forces along the normal, with the largest cause in each.
pub(super) fn largest_by_region(study: &Study, truth: TruthId, contact: ContactKnowledge) -> Option<String> {
    let force_n = study.forces.drawn_n();
    let mut by_cause: Vec<(Cause, Vec<&str>)> = Vec::new();
    for (region, cause) in failing(study, truth, contact)? {
        let place = region.in_words();
        match by_cause.iter_mut().find(|(of, _)| *of == cause) {
            Some((_, places)) => places.push(place),
            None => by_cause.push((cause, vec![place])),
        }
    }
    let part = |(cause, places): &(Cause, Vec<&str>)| format!("{}, mostly {}", list(places, " and "), because(*cause));
    Some(match by_cause.is_empty() {
        true => format!("errors of {force_n} N along the normal stay within {}", percent(TRUSTED_ERROR)),
        false => format!("{force_n} N along the normal fails {}", list(by_cause.iter().map(part), "; ")),
    })
}

/// Regions in which the nonlinear estimator fails for forces along the normal, each with its largest cause; `None` without a map of causes.
fn failing(study: &Study, truth: TruthId, contact: ContactKnowledge) -> Option<Vec<(Region, Cause)>> {
    let is = |map: &&CauseMap| (map.truth, map.practice, map.contact) == (truth, Practice::Nonlinear, contact);
    let map = study.causes.iter().find(is)?;
    let of_region = |region: Region| {
        let shares = Shares::of(&study.finger, map, study.forces.drawn_n(), region)?;
        let largest = shares.largest().filter(|_| shares.rms_error > TRUSTED_ERROR)?;
        Some((region, largest.cause))
    };
    Some(Region::ENDS_AND_MIDDLE.into_iter().filter_map(of_region).collect())
}

/// The cause in words, for the end of a sentence.
fn because(cause: Cause) -> &'static str {
    match cause {
        Cause::Noise => "because of noise",
        Cause::Linearisation => "because of linearisation",
        Cause::Modulus => "because the modulus is wrong",
        Cause::Direction => "because the direction is wrong",
        Cause::Position => "because the position is wrong",
        Cause::BaseCompliance => "because the base is compliant",
        Cause::TipCompliance => "because the tip is compliant",
        Cause::NetworkFit => "because the network fits badly",
    }
}

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![rows::by_cell(study), rows::by_region(study)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    if study.causes.is_empty() {
        return Ok(None);
    }
    let mut blocks: Vec<Block> = clearing(study)?.map(Block::Figure).into_iter().collect();
    blocks.extend(remedies(study)?.map(Block::Figure));
    blocks.push(text(about(study)));
    blocks.push(Block::Table(by_region(study)));
    // Maps with several directions, not only the normal.
    let full = own_first(study).filter(|map| map.request.angles_deg.len() > 1);
    let figures = full.take(DRAWN).map(|map| map_figure(map, study.forces.drawn_n()));
    blocks.push(Block::Figures(figures.collect::<Result<_, _>>()?));
    Ok(Some(Section::new("causes", "Causes of errors, and remedies", blocks)))
}

/// Text on the errors of the assumed contact, and on how the shares of the causes are computed.
fn about(study: &Study) -> String {
    let fitted = match study.causes.iter().any(|map| map.truth == FITTED) {
        true => {
            " The softer ends of the simulated finger are an assumption, so their appearance among the causes is no \
            finding."
        }
        false => "",
    };
    format!(
        "An assumed contact is off by {POSITION_OFF_MM} mm (the radius of the paper's rods) and {DIRECTION_OFF_DEG} deg (the largest rotation of the \
         paper's deformed normal), with all combinations of signs. The share of a cause is the error that disappears if only this cause is removed. \
         Errors of opposite sign partly cancel, so the shares do not add up to the total.{fitted}"
    )
}

/// All maps of causes; the maps of the scene's finger come first.
fn own_first(study: &Study) -> impl Iterator<Item = &CauseMap> {
    let (own, others): (Vec<_>, Vec<_>) = study.causes.iter().partition(|map| map.truth == OWN);
    own.into_iter().chain(others)
}

/// Name of a map's estimator as part of a sentence.
pub(super) fn estimator_in_words(map: &CauseMap) -> &'static str {
    match map.practice {
        Practice::LeastSquares => "least squares",
        Practice::Nonlinear => "nonlinear",
        Practice::Network => "network",
    }
}

/// Table of the largest cause in each region.
fn by_region(study: &Study) -> Table {
    let force_n = study.forces.drawn_n();
    let cell = move |map: &CauseMap, region: Region| {
        let Some(shares) = Shares::of(&study.finger, map, force_n, region) else {
            return Cell::plain("refused");
        };
        let why = match shares.largest() {
            Some(largest) => format!("{}, {}", largest.cause.name(), shares.without(&largest)),
            None => "causes cancel each other".to_owned(),
        };
        let refused = match shares.cells - shares.answered {
            0 => String::new(),
            refused => format!("; refused at {refused} of {} positions", shares.cells),
        };
        error_as(format!("{}: {why}{refused}", percent(shares.rms_error)), shares.rms_error)
    };
    let caption = format!(
        "Root mean square error at {force_n} N along the normal, its largest cause, and the error without this \
            cause. \"Near an end\" means within a sixth of the plate's length from an end. Amber marks errors above 10 \
            %, red errors above 25 %"
    );
    Columns::<&CauseMap>::new()
        .page("finger, contact", Format::Words, |map| format!("{}, {}", map.truth.label(), map.contact.name()))
        .page("sensed by", Format::Words, |map| estimator_in_words(map))
        .each(Region::ENDS_AND_MIDDLE, |columns, region| {
            columns.cells(region.name(), Format::Words, move |map| cell(map, region))
        })
        .table(caption, CSV, own_first(study))
}

/// Contact nodes from base to tip, each with its cell for the drawn force along the normal.
fn at_nodes<'s>(study: &'s Study, map: &'s CauseMap) -> impl Iterator<Item = (NodeId, &'s CauseCell)> {
    let finger = &study.finger;
    let nodes = finger.contact_nodes().rev().filter_map(|node| Some((node, finger.front_position_mm(node)?)));
    nodes.flat_map(|(node, s_mm)| {
        let at = map.cells.iter().filter(move |cell| cell.angle_deg == 0.0 && (cell.s_mm - s_mm).abs() < 1e-9 * s_mm);
        at.filter(|cell| cell.force_n == study.forces.drawn_n()).map(move |cell| (node, cell))
    })
}
