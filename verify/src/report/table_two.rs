//! The paper's Table II, by finger, noise and estimator; the paper's own network beside them, as recorded.

mod rows;
mod words;

use super::dataset::{Columns, Dataset, Format};
use super::format::{NOTHING, Span, error, error_as, list, nodes_in_words, share_of_counts, share_refused};
use super::page::{Block, Cell, Column, Section, Table, text};
use super::{ReportError, Results};
use crate::estimators::EstimatorId;
use crate::experiments::networks::paper::{OverSeeds, PAPER_RECIPES, quantities, recorded};
use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{CASES_WITHOUT_FIT, CONTACT_GROUPS, ContactGroup, FORCES_N, MOST_FITS, TableTwo};
use crate::truths::TruthId;

const CSV: &str = "table_two.csv";
/// Errors below this are shown as none: no reader asks for a millionth of a percent.
const ROUNDING: f64 = 1e-8;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![rows::dataset(study)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(two) = &study.table_two else { return Ok(None) };
    let groups = CONTACT_GROUPS
        .map(|group| format!("{} ({})", group.name, list(group.sets.iter().map(|set| nodes_in_words(set)), "; ")));
    let mut blocks = vec![text(format!(
        "The paper grasps sensor modules with its gripper, senses with its network and lists mean errors over the tests at the nodes that \
         sec. V-C names: {}. Here a simulated finger whose model is known is sensed at the same nodes, {} times for each set of contacts, all \
         estimators from the same noise samples: forces of {} to {} N along the normal, nodes and directions known. Shown is the mean \
         error of a force over the sets of a column and, behind it, of the sum of both, over the cases that were answered; how many \
         were refused stands beside. The bound is that of Cramer and Rao. The nonlinear estimator takes its time and senses the first \
         {} cases of each set; of the linear finger, which it does not fit, {}. \"network\" is that which ships for these contacts, trained \
         on the co-rotational finger. \"Network of the paper\" is trained as in sec. IV-A, on noise-free cases of the linear finger, and \
         recorded: mean over the seeds, least and greatest in brackets; the paper does not say how displacements are scaled, so two \
         ways are. Its records are of {}.",
        groups.join(", "),
        two.cases,
        FORCES_N[0],
        FORCES_N[1],
        two.cases.min(MOST_FITS),
        two.cases.min(CASES_WITHOUT_FIT),
        words::recorded_at(&study.records.recipes)
    ))];
    blocks.extend(words::linear(two).map(text));
    blocks.extend(
        PAPER_RECIPES
            .iter()
            .filter_map(|recipe| words::papers(&study.records.recipes, recipe, study.noise_mm))
            .map(text),
    );
    blocks.push(Block::Table(table(two, &study.records.recipes)));
    Ok(Some(Section::new("table-two", "The paper's Table II", blocks)))
}

/// How a recipe of the paper is called in tables.
fn paper_network(recipe: &str) -> String {
    let scaling = if recipe == PAPER_RECIPES[0] { "largest" } else { "spread" };
    format!("network of the paper, scaled by the {scaling}")
}

/// Fingers and levels of noise with records.
pub(super) fn recorded_settings(records: &[RecipeRow]) -> Vec<(TruthId, f64)> {
    let mut settings = Vec::new();
    for truth in [TruthId::Linear, TruthId::Corotational] {
        let mut levels: Vec<f64> = records.iter().filter(|row| row.truth == truth).map(|row| row.noise_mm).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        settings.extend(levels.into_iter().map(|noise_mm| (truth, noise_mm)));
    }
    settings
}

/// Finger, noise and estimator of the rows that were computed, by finger, then noise.
fn settings(two: &TableTwo) -> Vec<(TruthId, f64, EstimatorId)> {
    let mut all: Vec<(TruthId, f64, EstimatorId)> = Vec::new();
    for finger in &two.fingers {
        let mut of_finger: Vec<(TruthId, f64, EstimatorId)> = Vec::new();
        for row in &finger.rows {
            let setting = (finger.truth, row.noise_mm, row.estimator);
            if !of_finger.contains(&setting) {
                of_finger.push(setting);
            }
        }
        of_finger.sort_by(|a, b| a.1.total_cmp(&b.1));
        all.extend(of_finger);
    }
    all
}

fn span(over: &OverSeeds) -> Span {
    Span { mean: over.mean, least: over.least, greatest: over.greatest }
}

/// A line of the page's table.
struct Line {
    finger: &'static str,
    noise: String,
    sensed_by: String,
    /// By group: each force, and the sum where there are several.
    cells: Vec<Cell>,
    refused: String,
}

/// By group and quantity, in the order of the columns.
fn by_group<T>(of: impl Fn(&ContactGroup, &'static str) -> T) -> Vec<T> {
    let of_group =
        |group: &ContactGroup| quantities(group).map(|(quantity, _)| of(group, quantity)).collect::<Vec<_>>();
    CONTACT_GROUPS.iter().flat_map(of_group).collect()
}

/// A line for the paper, then one for each finger, noise and estimator; a bound where there is noise.
fn table(two: &TableTwo, records: &[RecipeRow]) -> Table {
    let paper = |group: &ContactGroup, quantity| match quantity {
        "sum" => group.paper_sum,
        _ => Some(group.paper_force),
    };
    let mut lines = vec![Line {
        finger: "the paper's gripper",
        noise: NOTHING.to_owned(),
        sensed_by: EstimatorId::Network.label().to_owned(),
        cells: by_group(|group, quantity| error_or_rounding(paper(group, quantity))),
        refused: String::new(),
    }];
    let settings = settings(two);
    for level in settings.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (truth, noise_mm, _) = level[0];
        let line = |sensed_by: &str, cells, refused| {
            let (finger, noise) = (truth.label(), noise_mm.to_string());
            Line { finger, noise, sensed_by: sensed_by.to_owned(), cells, refused }
        };
        for recipe in PAPER_RECIPES {
            let of = |group: &ContactGroup, quantity| recorded(records, recipe, truth, noise_mm, group, quantity);
            let found: Vec<OverSeeds> = CONTACT_GROUPS.iter().filter_map(|group| of(group, "each force")).collect();
            let cells = by_group(|group, quantity| match of(group, quantity) {
                None => Cell::plain("not recorded"),
                Some(over) => error_as(span(&over).in_words(), over.mean),
            });
            let refused = share_of_counts(found.iter().map(|over| [over.refused, over.answered]));
            let name = paper_network(recipe) + " (recorded)";
            lines.extend((!found.is_empty()).then(|| line(&name, cells, refused)));
        }
        for (i, &(.., estimator)) in level.iter().enumerate() {
            let found = |group: &ContactGroup| two.group(group, truth, noise_mm, estimator);
            // The bound is the same beside all estimators; the first one saw all cases.
            if noise_mm > 0.0 && i == 0 {
                let cells = by_group(|group, quantity| {
                    let of = found(group);
                    error_or_rounding(of.and_then(|of| if quantity == "sum" { of.sum_bound } else { of.force_bound }))
                });
                lines.push(line("bound", cells, String::new()));
            }
            let cells = by_group(|group, quantity| {
                error_or_rounding(found(group).and_then(|of| if quantity == "sum" { of.sum } else { Some(of.force) }))
            });
            lines.push(line(estimator.label(), cells, share_refused(two.of(truth, noise_mm, estimator))));
        }
    }
    let headings = by_group(|group, quantity| if quantity == "sum" { quantity } else { group.name });
    Columns::<Line>::new()
        .page("finger", Format::Words, |line| line.finger)
        .page("noise, mm", Format::Words, |line| line.noise.clone())
        .page("sensed by", Format::Words, |line| line.sensed_by.clone())
        .each(headings.into_iter().enumerate(), |columns, (i, heading)| {
            columns.cells(Column::numbers(heading), move |line| line.cells[i].clone())
        })
        .page("refused", Format::Plain, |line| line.refused.clone())
        .table(
            format!(
                "Mean error of each force and of the sum, forces of {} to {} N, mean over the paper's contact sets; grey above 10 %, dark above \
                 25 %",
                FORCES_N[0], FORCES_N[1]
            ),
            CSV,
            lines,
        )
}

/// An error that may be missing, or nothing but rounding.
pub(super) fn error_or_rounding(share: Option<f64>) -> Cell {
    match share {
        None => Cell::plain(NOTHING),
        Some(rounding) if rounding < ROUNDING => Cell::plain("0 %"),
        Some(share) => error(share),
    }
}
