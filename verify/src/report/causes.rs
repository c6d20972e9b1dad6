//! Why sensing fails: maps of the largest cause, what each costs along the finger, and what clears it.

mod drawings;
mod rows;

pub use rows::{CauseRow, CauseSummary};
pub(super) use rows::{rows, summaries};

use self::drawings::{line_figure, map_figure};
use super::ReportError;
use super::page::{Block, Cell, Column, Figure, Row, Section, Table};
use super::sections::{section as section_of, text};
use super::tables::{error, percent};
use crate::causes::{
    Cause, CauseCell, CauseMap, ContactKnowledge, DIRECTION_OFF_DEG, PLACE_OFF_MM, Practice, REMEDIES,
};
use crate::explain::Explanation;
use crate::study::{DRAWN_FORCE_N, Study};
use finray_model::Finger;
use finray_model::finger::Plate;

pub(super) const CSV: &str = "causes.csv";
/// Directions that count as pressing, degrees from the normal.
const PRESSING_DEG: f64 = 20.0;
/// Share of the plate's length at either end that counts as near it: two stretches of the paper's finger.
const NEAR_AN_END: f64 = 1.0 / 6.0;

/// Cells of a map that are looked at together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Region {
    Base,
    Middle,
    Tip,
    All,
}

impl Region {
    const ENDS_AND_MIDDLE: [Region; 3] = [Region::Base, Region::Middle, Region::Tip];
    const ALL: [Region; 4] = [Region::Base, Region::Middle, Region::Tip, Region::All];

    fn name(self) -> &'static str {
        match self {
            Region::Base => "near the base",
            Region::Middle => "middle",
            Region::Tip => "near the tip",
            Region::All => "all",
        }
    }

    /// Whether a place (mm from the base) and direction (degrees) are within, on a plate of this length.
    fn covers(self, length_mm: f64, s_mm: f64, angle_deg: f64) -> bool {
        let along = s_mm / length_mm;
        let pressing = angle_deg.abs() <= PRESSING_DEG;
        match self {
            Region::Base => pressing && along <= NEAR_AN_END,
            Region::Middle => pressing && along > NEAR_AN_END && along < 1.0 - NEAR_AN_END,
            Region::Tip => pressing && along >= 1.0 - NEAR_AN_END,
            Region::All => true,
        }
    }
}

/// Shares of the mean square error over a region, largest first, over cells that are answered with each cause switched off.
struct Shares {
    rms_error: f64,
    by_cause: Vec<(Cause, f64)>,
}

impl Shares {
    fn of(finger: &Finger, map: &CauseMap, force_n: f64, region: Region) -> Option<Shares> {
        let length_mm = finger.plate_length_mm(Plate::Front);
        let complete = |cell: &&CauseCell| {
            cell.force_n == force_n
                && region.covers(length_mm, cell.s_mm, cell.angle_deg)
                && cell.shares.iter().all(Option::is_some)
        };
        let cells: Vec<(f64, &CauseCell)> =
            map.cells.iter().filter(complete).filter_map(|cell| Some((cell.rms_error?.powi(2), cell))).collect();
        let total: f64 = cells.iter().map(|(square, _)| square).sum();
        if cells.is_empty() || total == 0.0 {
            return None;
        }
        let share = |i: usize| cells.iter().map(|(square, cell)| square * cell.shares[i].unwrap_or(0.0)).sum::<f64>();
        let mut by_cause: Vec<_> = map.causes.iter().enumerate().map(|(i, cause)| (*cause, share(i) / total)).collect();
        by_cause.sort_by(|a, b| b.1.total_cmp(&a.1));
        Some(Shares { rms_error: (total / cells.len() as f64).sqrt(), by_cause })
    }

    /// The largest share; `None` if every cause hides others.
    fn largest(&self) -> Option<(Cause, f64)> {
        self.by_cause.first().copied().filter(|(_, share)| *share > 0.0)
    }

    fn without(&self, share: f64) -> f64 {
        self.rms_error * (1.0 - share).max(0.0).sqrt()
    }
}

/// What limits sensing near the base, in the middle and near the tip, in one sentence.
pub(super) fn verdict(study: &Study) -> Option<String> {
    let map = find(study, "twin", Practice::LeastSquares, ContactKnowledge::Known)
        .or_else(|| find(study, "corotational", Practice::LeastSquares, ContactKnowledge::Known))?;
    let part = |region: Region| {
        let shares = Shares::of(&study.finger, map, DRAWN_FORCE_N, region)?;
        let (cause, share) = shares.largest()?;
        Some(format!(
            "{} {} ({} of error, {} without it)",
            cause.name(),
            region.name().replace("middle", "in the middle"),
            percent(shares.rms_error),
            percent(shares.without(share))
        ))
    };
    let parts: Vec<String> = Region::ENDS_AND_MIDDLE.into_iter().filter_map(part).collect();
    if parts.is_empty() {
        return None;
    }
    let finger = match map.truth {
        "twin" => "a finger that is softer at both ends, as the paper's seems to be",
        _ => "this finger",
    };
    let assumed = find(study, map.truth, Practice::LeastSquares, ContactKnowledge::Assumed)
        .and_then(|map| Shares::of(&study.finger, map, DRAWN_FORCE_N, Region::Middle)?.largest())
        .map_or_else(String::new, |(cause, _)| {
            format!("; where a contact is only assumed, a {} costs most in the middle", cause.name())
        });
    Some(format!("What limits linear sensing of {DRAWN_FORCE_N} N on {finger}: {}{assumed}.", parts.join(", ")))
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
             turns from the one it assumes); the modulus is calibrated from weights by the model that senses; zones of lower modulus \
             are not known to it.",
        )),
        Block::Table(by_region(study)),
    ];
    blocks.extend(mechanism(study).map(text));
    let figures: Vec<Figure> = drawn(study).map(|map| map_figure(study, map)).collect::<Result<_, _>>()?;
    blocks.push(Block::Figures { figures });
    let lines: Vec<Option<Figure>> = along(study).map(line_figure).collect::<Result<_, _>>()?;
    blocks.push(Block::Figures { figures: lines.into_iter().flatten().collect() });
    blocks.extend(remedies(study).map(Block::Table));
    Ok(Some(section_of("causes", "Why sensing fails", blocks)))
}

fn find<'s>(study: &'s Study, truth: &str, practice: Practice, contact: ContactKnowledge) -> Option<&'s CauseMap> {
    let is = |map: &&CauseMap| map.truth == truth && map.practice == practice && map.contact == contact;
    study.causes.iter().find(is)
}

/// The maps over place and direction, those with zones first.
fn drawn(study: &Study) -> impl Iterator<Item = &CauseMap> {
    let of = |truth: &'static str| {
        study.causes.iter().filter(move |map| map.truth == truth && map.request.angles_deg.len() > 1)
    };
    of("twin").chain(of("corotational"))
}

/// The maps whose causes are drawn along the normal.
fn along(study: &Study) -> impl Iterator<Item = &CauseMap> {
    drawn(study)
        .filter(|map| map.contact == ContactKnowledge::Known)
        .chain(study.causes.iter().filter(|map| map.practice == Practice::Network))
}

fn truth_in_words(map: &CauseMap) -> &'static str {
    if map.truth == "twin" { "softer at both ends" } else { "as described" }
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
                Some((cause, share)) => format!("{}, {} without it", cause.name(), percent(shares.without(share))),
                None => "each hides others".to_owned(),
            };
            Cell { text: format!("{}: {why}", rms.text), ..rms }
        };
        let what = format!("{}, {}", truth_in_words(map), map.contact.name());
        let cells = [what, estimator_in_words(map).to_owned()].map(Cell::plain);
        Row { cells: cells.into_iter().chain(Region::ENDS_AND_MIDDLE.map(region)).collect() }
    };
    Table {
        caption: format!(
            "Root mean square error at {DRAWN_FORCE_N} N within {PRESSING_DEG} deg of the normal, the cause with the largest share of its \
             square, and the error without that cause. Near an end: within a sixth of the plate's length. Grey above 10 %, dark above \
             25 %"
        ),
        columns,
        rows: study.causes.iter().map(of_map).collect(),
        csv: Some(CSV.to_owned()),
    }
}

/// What the finger's mechanics have to do with it: how strongly the markers tell a force, its place and its direction.
fn mechanism(study: &Study) -> Option<String> {
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let mean = |region: Region, of: fn(&Explanation) -> Option<f64>| {
        let cells = study.explanations.cells.iter();
        let values: Vec<f64> =
            cells.filter(|cell| region.covers(length_mm, cell.s_mm, cell.angle_deg)).filter_map(of).collect();
        (!values.is_empty()).then(|| percent(values.iter().sum::<f64>() / values.len() as f64))
    };
    let list = |of: fn(&Explanation) -> Option<f64>| -> Option<String> {
        let parts: Option<Vec<String>> = Region::ENDS_AND_MIDDLE
            .iter()
            .map(|region| Some(format!("{} {}", mean(*region, of)?, region.name().replace("middle", "in the middle"))))
            .collect();
        Some(parts?.join(", "))
    };
    let noise = list(|cell| cell.bound).filter(|_| study.noise_mm > 0.0);
    let noise = noise
        .map_or_else(String::new, |noise| format!(" Noise of {} mm leaves {noise} to any estimator.", study.noise_mm));
    Some(format!(
        "Why at the ends: a force near the clamp moves the finger little, and the more the farther out it acts, so a place 1 mm off \
         changes what is sensed by {}, and whatever gives way at the clamp looks like force; near the tip the force acts where \
         the plates are short and bend most of themselves, so their own modulus decides, and that of the rest does not. Per degree of \
         wrong direction it is {}.{noise} (Means at {DRAWN_FORCE_N} N within {PRESSING_DEG} deg of the normal, finger as described.)",
        list(|cell| cell.error_per_mm)?,
        list(|cell| cell.error_per_deg)?
    ))
}

/// Error at the nodes as remedies are taken one after the other.
fn remedies(study: &Study) -> Option<Table> {
    let map = find(study, "twin", Practice::LeastSquares, ContactKnowledge::Assumed)
        .or_else(|| find(study, "corotational", Practice::LeastSquares, ContactKnowledge::Assumed))?;
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
             one after the other. Grey above 10 %, dark above 25 %; what is left in the last column is noise.",
            truth_in_words(map)
        ),
        columns,
        rows,
        csv: Some(CSV.to_owned()),
    })
}
