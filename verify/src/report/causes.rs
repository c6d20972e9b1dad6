//! Why sensing fails: maps of the largest cause, what each costs along the finger, and what clears it.

mod drawings;
mod rows;
mod shares;

use self::drawings::{clearing, line_figure, map_figure};
use self::shares::{Region, Shares};
use super::dataset::{Columns, Dataset, Format};
use super::format::{Span, error, error_as, percent};
use super::page::{Block, Cell, Column, Figure, Section, Table, text};
use super::{ReportError, Results, verdict};
use crate::experiments::causes::{
    Cause, CauseCell, CauseMap, ContactKnowledge, DIRECTION_OFF_DEG, POSITION_OFF_MM, Practice, REMEDIES,
};
use crate::experiments::explain::Explanation;
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;
use crate::truths::TruthId;
use finray_model::NodeId;
use finray_model::finger::Plate;

const CSV: &str = "causes.csv";
/// The finger at hand among the true fingers.
const OWN: TruthId = TruthId::Corotational;
/// The finger that is fitted to the paper's Table I.
const FITTED: TruthId = TruthId::Twin;

/// What limits sensing of the finger at hand near the base, in the middle and near the tip, in one sentence. A fitted finger, whose soft
/// ends were put in, is not asked.
pub(super) fn in_short(study: &Study) -> Option<String> {
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

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![rows::by_cell(study), rows::by_region(study)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    if study.causes.is_empty() {
        return Ok(None);
    }
    let mut blocks = vec![
        text(format!(
            "Each cause of error is switched off in turn, the others left as they are; its share is the part of the mean square \
             error that goes away. Shares need not add up to one: errors that point the same way grow when squared, and one that \
             hides another has a negative share. Where a contact is assumed, its position is {POSITION_OFF_MM} mm off to either side (the \
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
    // At the head of the page stands the largest cause, where causes were sought.
    let says = in_short(study).and_then(|_| verdict::limit(study));
    Ok(Some(Section::new("causes", "Why sensing fails", blocks).saying(says)))
}

fn find(study: &Study, truth: TruthId, practice: Practice, contact: ContactKnowledge) -> Option<&CauseMap> {
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

/// The maps over position and direction, those of the finger at hand first.
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
    let cell = |map: &CauseMap, region: Region| {
        let Some(shares) = Shares::of(&study.finger, map, DRAWN_FORCE_N, region) else {
            return Cell::plain("refused");
        };
        let why = match shares.largest() {
            Some(largest) => format!("{}, {}", largest.cause.name(), shares.without(&largest)),
            None => "each hides others".to_owned(),
        };
        let refused = match shares.cells - shares.answered {
            0 => String::new(),
            refused => format!("; refused at {refused} of {} positions", shares.cells),
        };
        error_as(format!("{}: {why}{refused}", percent(shares.rms_error)), shares.rms_error)
    };
    Columns::<&CauseMap>::new()
        .page("finger, contact", Format::Words, |map| format!("{}, {}", truth_in_words(map), map.contact.name()))
        .page("sensed by", Format::Words, |map| estimator_in_words(map))
        .each(Region::ENDS_AND_MIDDLE, |columns, region| {
            columns.cells(Column::words(region.name()), move |map| cell(map, region))
        })
        .table(
            format!(
                "Root mean square error at {DRAWN_FORCE_N} N along the normal, the cause with the largest share of its square, and the error \
                 without that cause. Near an end: within a sixth of the plate's length. Grey above 10 %, dark above 25 %"
            ),
            CSV,
            own_first(study),
        )
}

/// What the finger's mechanics have to do with it: how well force, position and direction are identifiable.
fn mechanism(study: &Study) -> Option<String> {
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let mean = |region: Region, of: fn(&Explanation) -> Option<f64>| {
        let cells = study.explanations.cells.iter();
        let cells = cells.filter(|cell| region.covers(length_mm, cell.s_mm, cell.angle_deg));
        Some(percent(Span::of(cells.filter_map(of))?.mean))
    };
    let by_region = |of: fn(&Explanation) -> Option<f64>| -> Option<String> {
        let part = |region: &Region| Some(format!("{} {}", mean(*region, of)?, region.in_words()));
        let parts: Option<Vec<String>> = Region::ENDS_AND_MIDDLE.iter().map(part).collect();
        Some(parts?.join(", "))
    };
    let noise = by_region(|cell| cell.bound).filter(|_| study.noise_mm > 0.0).map_or_else(String::new, |noise| {
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
        "For the nonlinear estimator, to first order, a position that is 1 mm off changes the force by {}, a direction that is 1 deg off by \
         {}.{noise} (Means at {DRAWN_FORCE_N} N along the normal, finger as described.){ends}",
        by_region(|cell| cell.error_per_mm)?,
        by_region(|cell| cell.error_per_deg)?
    ))
}

/// Error at the nodes as remedies are taken one after the other.
fn remedies(study: &Study) -> Option<Table> {
    let map = find(study, OWN, Practice::LeastSquares, ContactKnowledge::Assumed)?;
    let finger = &study.finger;
    let rows = finger.contact_nodes().filter_map(|node| Some((node, finger.front_position_mm(node)?)));
    let rows = rows.flat_map(|(node, s_mm)| {
        let at = map.cells.iter().filter(move |cell| cell.angle_deg == 0.0 && (cell.s_mm - s_mm).abs() < 1e-9 * s_mm);
        at.map(move |cell| (node, cell))
    });
    let shaded = |share: Option<f64>| share.map_or_else(|| Cell::plain("refused"), error);
    let columns = Columns::<(NodeId, &CauseCell)>::new()
        .page("node", Format::Plain, |(node, _)| node.to_string())
        .cells(Column::numbers("as it is"), move |(_, cell)| shaded(cell.rms_error))
        .each(REMEDIES.iter().enumerate(), |columns, (taken, (name, _))| {
            let remedied = move |(_, cell): &(NodeId, &CauseCell)| shaded(cell.remedied.get(taken).copied().flatten());
            columns.cells(Column::numbers(format!("+ {name}")), remedied)
        });
    let caption = format!(
        "What clears it: root mean square error of {DRAWN_FORCE_N} N along the normal on the finger {} by linear least squares, then with remedies taken \
         one after the other. Errors of opposite sign hide each other, so taking one cause away can raise the rest; in the last \
         column that is noise. Grey above 10 %, dark above 25 %",
        truth_in_words(map)
    );
    Some(columns.table(caption, CSV, rows))
}
