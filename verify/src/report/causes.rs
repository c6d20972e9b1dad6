//! Why sensing fails: maps of the largest cause, what each costs along the finger, and what clears it.

mod drawings;
mod rows;
mod shares;

pub use rows::{CauseRow, CauseSummary};
pub(super) use rows::{rows, summaries};

use self::drawings::{clearing, line_figure, map_figure};
use self::shares::{Region, Shares};
use super::ReportError;
use super::page::{Block, Cell, Column, Figure, Row, Section, Table};
use super::sections::{section as section_of, text};
use super::tables::{error, percent};
use crate::experiments::causes::{
    Cause, CauseMap, ContactKnowledge, DIRECTION_OFF_DEG, PLACE_OFF_MM, Practice, REMEDIES,
};
use crate::experiments::explain::Explanation;
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;
use finray_model::finger::Plate;

pub(super) const CSV: &str = "causes.csv";
/// The finger at hand among the true fingers.
const OWN: &str = "corotational";
/// The finger that is fitted to the paper's Table I.
const FITTED: &str = "twin";

/// What limits sensing of the finger at hand near the base, in the middle and near the tip, in one sentence. A fitted finger, whose soft
/// ends were put in, is not asked.
pub(super) fn verdict(study: &Study) -> Option<String> {
    let map = find(study, OWN, Practice::LeastSquares, ContactKnowledge::Known)?;
    let part = |region: Region| {
        let shares = Shares::of(&study.finger, map, DRAWN_FORCE_N, region)?;
        let largest = shares.largest()?;
        let [cause, at, error] = [largest.cause.name(), region.in_words(), &percent(shares.rms_error)];
        Some(format!("{cause} {at} (error {error}, {})", shares.without(&largest)))
    };
    let parts: Vec<String> = Region::ENDS_AND_MIDDLE.into_iter().filter_map(part).collect();
    if parts.is_empty() {
        return None;
    }
    let in_the_middle =
        |map: &CauseMap| Some(Shares::of(&study.finger, map, DRAWN_FORCE_N, Region::Middle)?.largest()?.cause);
    let assumed = find(study, OWN, Practice::LeastSquares, ContactKnowledge::Assumed).and_then(in_the_middle);
    let assumed = assumed.filter(|cause| Some(*cause) != in_the_middle(map)).map_or_else(String::new, |cause| {
        format!("; where a contact is only assumed, in the middle it is {}", cause.name())
    });
    Some(format!(
        "In simulation, what limits linear sensing of {DRAWN_FORCE_N} N along the normal on this finger, as described: {}{assumed}.",
        parts.join(", ")
    ))
}

pub(super) fn section(study: &Study) -> Result<Option<Section>, ReportError> {
    if study.causes.is_empty() {
        return Ok(None);
    }
    let mut blocks = vec![
        text(format!(
            "Each cause of error is switched off in turn, the others left as they are; its share is the part of the mean square \
             error that goes away. Shares need not add up to one: errors that point the same way grow when squared, and one that \
             hides another has a negative share. Where a contact is assumed, its place is {PLACE_OFF_MM} mm off to either side (the \
             radius of the paper's rods) and its direction {DIRECTION_OFF_DEG} deg to either side (as far as the paper's deformed normal \
             turns from the one it assumes); the modulus is calibrated from weights by the model that senses.{}",
            fitted_in_words(study)
        )),
        Block::Table(by_region(study)),
    ];
    blocks.extend(mechanism(study).map(text));
    let figures: Vec<Figure> = drawn(study).map(|map| map_figure(study, map)).collect::<Result<_, _>>()?;
    blocks.push(Block::Figures { figures });
    let lines: Vec<Option<Figure>> = along(study).map(line_figure).collect::<Result<_, _>>()?;
    blocks.push(Block::Figures { figures: lines.into_iter().flatten().collect() });
    blocks.extend(clearing(study)?.map(Block::Figure));
    blocks.extend(remedies(study).map(Block::Table));
    Ok(Some(section_of("causes", "Why sensing fails", blocks)))
}

fn find<'s>(study: &'s Study, truth: &str, practice: Practice, contact: ContactKnowledge) -> Option<&'s CauseMap> {
    let is = |map: &&CauseMap| map.truth == truth && map.practice == practice && map.contact == contact;
    study.causes.iter().find(is)
}

/// What the fitted finger is, where it was asked.
fn fitted_in_words(study: &Study) -> &'static str {
    match study.causes.iter().any(|map| map.truth == FITTED) {
        true => {
            " The finger at hand comes first. \"Fitted to Table I\" is one of several fingers with softer zones that err as the paper's table has \
             it: its zones were put in and are not known to sensing, so that they come out as causes is no finding about the paper's finger."
        }
        false => "",
    }
}

/// All maps, those of the finger at hand first.
fn own_first(study: &Study) -> impl Iterator<Item = &CauseMap> {
    let (own, others): (Vec<_>, Vec<_>) = study.causes.iter().partition(|map| map.truth == OWN);
    own.into_iter().chain(others)
}

/// The maps over place and direction, those of the finger at hand first.
fn drawn(study: &Study) -> impl Iterator<Item = &CauseMap> {
    own_first(study).filter(|map| map.request.angles_deg.len() > 1)
}

/// The maps whose causes are drawn along the normal.
fn along(study: &Study) -> impl Iterator<Item = &CauseMap> {
    drawn(study)
        .filter(|map| map.contact == ContactKnowledge::Known)
        .chain(own_first(study).filter(|map| map.practice == Practice::Network))
}

fn truth_in_words(map: &CauseMap) -> &'static str {
    if map.truth == FITTED { "fitted to Table I" } else { "as described" }
}

fn estimator_in_words(map: &CauseMap) -> &'static str {
    match map.practice {
        Practice::LeastSquares => "linear least squares",
        Practice::Nonlinear => "nonlinear, an element a member",
        Practice::Network => "network",
    }
}

fn practice_in_words(map: &CauseMap) -> String {
    format!("{}, contact {}", estimator_in_words(map), map.contact.name())
}

/// The largest causes region by region.
fn by_region(study: &Study) -> Table {
    let mut columns = vec![Column::words("finger, contact"), Column::words("sensed by")];
    columns.extend(Region::ENDS_AND_MIDDLE.iter().map(|region| Column::words(region.name())));
    let of_map = |map: &CauseMap| {
        let region = |region: Region| {
            let Some(shares) = Shares::of(&study.finger, map, DRAWN_FORCE_N, region) else {
                return Cell::plain("refused");
            };
            let rms = error(shares.rms_error);
            let why = match shares.largest() {
                Some(largest) => format!("{}, {}", largest.cause.name(), shares.without(&largest)),
                None => "each hides others".to_owned(),
            };
            let refused = match shares.cells - shares.answered {
                0 => String::new(),
                refused => format!("; refused at {refused} of {} places", shares.cells),
            };
            Cell { text: format!("{}: {why}{refused}", rms.text), ..rms }
        };
        let what = format!("{}, {}", truth_in_words(map), map.contact.name());
        let cells = [what, estimator_in_words(map).to_owned()].map(Cell::plain);
        Row { cells: cells.into_iter().chain(Region::ENDS_AND_MIDDLE.map(region)).collect() }
    };
    Table {
        caption: format!(
            "Root mean square error at {DRAWN_FORCE_N} N along the normal, the cause with the largest share of its square, and the error without that cause. Near an end: within a sixth of the plate's length. Grey above 10 %, dark above \
             25 %"
        ),
        columns,
        rows: own_first(study).map(of_map).collect(),
        csv: Some(CSV.to_owned()),
    }
}

/// What the finger's mechanics have to do with it: how well force, position and direction are identifiable.
fn mechanism(study: &Study) -> Option<String> {
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let mean = |region: Region, of: fn(&Explanation) -> Option<f64>| {
        let cells = study.explanations.cells.iter();
        let values: Vec<f64> =
            cells.filter(|cell| region.covers(length_mm, cell.s_mm, cell.angle_deg)).filter_map(of).collect();
        (!values.is_empty()).then(|| percent(values.iter().sum::<f64>() / values.len() as f64))
    };
    let list = |of: fn(&Explanation) -> Option<f64>| -> Option<String> {
        let part = |region: &Region| Some(format!("{} {}", mean(*region, of)?, region.in_words()));
        let parts: Option<Vec<String>> = Region::ENDS_AND_MIDDLE.iter().map(part).collect();
        Some(parts?.join(", "))
    };
    let noise = list(|cell| cell.bound).filter(|_| study.noise_mm > 0.0).map_or_else(String::new, |noise| {
        format!(" Noise of {} mm leaves no estimator less than {noise}.", study.noise_mm)
    });
    let largest = |region: Region| {
        let map = find(study, FITTED, Practice::LeastSquares, ContactKnowledge::Known)?;
        Some(Shares::of(&study.finger, map, DRAWN_FORCE_N, region)?.largest()?.cause)
    };
    let mut ends = String::new();
    if largest(Region::Base) == Some(Cause::BaseCompliance) {
        ends += " If a finger gives way at its clamp, as the one fitted to Table I was made to, that is a large part of the little motion \
                 that a force near the clamp causes, and is taken for force.";
    }
    if largest(Region::Tip) == Some(Cause::TipCompliance) {
        ends += " If the last segments of plate are softer, as the fitted one's were made, a force near the tip bends these most of all: their \
                 modulus decides, not the one that was calibrated in the middle.";
    }
    Some(format!(
        "For the nonlinear estimator, to first order, a place that is 1 mm off changes the force by {}, a direction that is 1 deg off by \
         {}.{noise} (Means at {DRAWN_FORCE_N} N along the normal, finger as described.){ends}",
        list(|cell| cell.error_per_mm)?,
        list(|cell| cell.error_per_deg)?
    ))
}

/// Error at the nodes as remedies are taken one after the other.
fn remedies(study: &Study) -> Option<Table> {
    let map = find(study, OWN, Practice::LeastSquares, ContactKnowledge::Assumed)?;
    let finger = &study.finger;
    let mut columns = vec![Column::numbers("node"), Column::numbers("as it is")];
    columns.extend(REMEDIES.iter().map(|(name, _)| Column::numbers(format!("+ {name}"))));
    let cell = |value: Option<f64>| value.map_or_else(|| Cell::plain("refused"), error);
    let mut rows = Vec::new();
    for node in finger.contact_nodes() {
        let Some(s_mm) = finger.front_place_mm(node) else { continue };
        let at = map.cells.iter().filter(|cell| cell.angle_deg == 0.0 && (cell.s_mm - s_mm).abs() < 1e-9 * s_mm);
        for found in at {
            let mut cells = vec![Cell::plain(node.to_string()), cell(found.rms_error)];
            cells.extend(found.remedied.iter().map(|value| cell(*value)));
            rows.push(Row { cells });
        }
    }
    Some(Table {
        caption: format!(
            "What clears it: root mean square error of {DRAWN_FORCE_N} N along the normal on the finger {} by linear least squares, then with remedies taken \
             one after the other. Errors of opposite sign hide each other, so taking one cause away can raise what is left; in the last \
             column that is noise. Grey above 10 %, dark above 25 %",
            truth_in_words(map)
        ),
        columns,
        rows,
        csv: Some(CSV.to_owned()),
    })
}
