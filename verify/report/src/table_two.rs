//! The paper's Table II by true finger, noise and estimator, with recorded results of the paper's network.

mod gripper;
mod rows;
pub mod words;

use super::drawings::error_bars;
use super::format::{NOTHING, error, error_as, share_of_counts, span_in_words};
use crate::prelude::*;
use finray_studies::experiments::networks::paper::{PAPER_RECIPES, quantities, recorded};
use finray_studies::experiments::networks::records::RecipeRow;
use finray_studies::experiments::table_two::{CONTACT_GROUPS, ContactGroup, TableTwo};

const CSV: &str = "table_two.csv";
/// Relative errors below this are rounding and shown as 0.
const ROUNDING: f64 = 1e-8;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![rows::dataset(study), gripper::dataset(study)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(two) = &study.table_two else { return Ok(None) };
    let records = &study.records.recipes;
    let mut blocks = vec![text(words::about(two.cases))];
    let caption = format!("Errors measured in the paper, and errors in simulation with {} mm noise.", study.noise_mm);
    blocks.push(Block::Figure(Figure::wide(drawing(two, records, study.noise_mm)?, caption, CSV)));
    blocks.extend(words::linearisation(two, study.noise_mm).map(text));
    blocks.push(details("By estimator", vec![Block::Table(table(two, records, study.noise_mm))]));
    blocks.extend(study.modules.as_ref().map(gripper::blocks).transpose()?.into_iter().flatten());
    let says = [words::papers(records, study.noise_mm), words::ours(two, study.noise_mm)].into_iter().flatten();
    Ok(Some(Section::new("table-two", "The paper's Table II", blocks).saying(says)))
}

/// Bar chart of the five errors in the paper's Table II, and of the same errors on the co-rotational finger.
fn drawing(two: &TableTwo, records: &[RecipeRow], noise_mm: f64) -> Result<String, FigureError> {
    let truth = TruthId::Corotational;
    let bars = |label: String, hue, of: &dyn Fn(&ContactGroup, &'static str) -> Option<f64>| {
        error_bars(label, hue, by_group(|group, quantity| of(group, quantity)))
    };
    let estimated = |n: usize, estimator: EstimatorId| {
        let of = |group: &ContactGroup, quantity| estimated(two, (truth, noise_mm, estimator), group, quantity);
        bars(estimator.label().to_owned(), Hue::nth(n), &of)
    };
    let recorded = PAPER_RECIPES.iter().enumerate().map(|(n, recipe)| {
        bars(paper_network(recipe), Hue::nth(n), &|group, quantity| {
            Some(recorded(records, recipe, truth, noise_mm, group, quantity)?.errors.mean)
        })
    });
    let paper = bars("paper, measured".to_owned(), Hue::NEUTRAL, &of_paper);
    let ours = [estimated(2, EstimatorId::LeastSquares), estimated(3, EstimatorId::Nonlinear)];
    let names = by_group(|group, quantity| match group.paper_sum {
        Some(_) => format!("{}: {}", group.name, quantity.trim_end_matches(" force")),
        None => group.name.to_owned(),
    });
    let alt = "Mean error of each force and of the sum: in the paper's Table II, for the recorded trainings of the \
            paper's network, and for our estimators.";
    let axes = [Axis::categories("contact nodes", names), Axis::linear("mean error, %")];
    let all = std::iter::once(paper).chain(recorded).chain(ours).filter(|bars| bars.values.iter().any(Option::is_some));
    Chart::of_bars(Frame::full("Table II: one force, two neighbours, two nodes apart", alt), axes, all.collect()).svg()
}

/// Mean error for a true finger, noise level (mm) and estimator.
fn estimated(two: &TableTwo, of: (TruthId, f64, EstimatorId), group: &ContactGroup, quantity: &str) -> Option<f64> {
    two.group(group, of.0, of.1, of.2).and_then(|errors| of_quantity(quantity, errors.force, errors.sum))
}

fn of_paper(group: &ContactGroup, quantity: &'static str) -> Option<f64> {
    of_quantity(quantity, group.paper_force, group.paper_sum)
}

fn of_quantity(quantity: &str, force: f64, sum: Option<f64>) -> Option<f64> {
    if quantity == "sum" { sum } else { Some(force) }
}

/// Name of one of the paper's training recipes in tables.
fn paper_network(recipe: &str) -> String {
    format!("network of the paper, displacements scaled by the {}", scaling(recipe))
}

fn scaling(recipe: &str) -> &'static str {
    if recipe == PAPER_RECIPES[0] { "largest" } else { "spread" }
}

/// True fingers and noise levels (mm) for which records exist.
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

/// True finger, noise (mm) and estimator of the computed rows, ordered by finger, then noise.
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

/// One value per group and quantity, in the order of the columns.
fn by_group<T>(of: impl Fn(&ContactGroup, &'static str) -> T) -> Vec<T> {
    let of_group =
        |group: &ContactGroup| quantities(group).map(|(quantity, _)| of(group, quantity)).collect::<Vec<_>>();
    CONTACT_GROUPS.iter().flat_map(of_group).collect()
}

/// A row of the page's table: its name, its errors by group and quantity, and the share of refused cases.
type Line = (String, Vec<Cell>, String);

/// Table with noise: the paper, its recorded network, the estimators and the Cramer-Rao bound; then least squares on the linear finger. The CSV file has
/// all other rows.
fn table(two: &TableTwo, records: &[RecipeRow], noise_mm: f64) -> Table {
    let truth = TruthId::Corotational;
    let mut lines = Vec::new();
    for recipe in PAPER_RECIPES {
        let of = |group: &ContactGroup, quantity| recorded(records, recipe, truth, noise_mm, group, quantity);
        let cells = by_group(|group, quantity| match of(group, quantity) {
            None => Cell::plain("not recorded"),
            Some(over) => error_as(span_in_words(over.errors), over.errors.mean),
        });
        let counts = CONTACT_GROUPS.iter().filter_map(|group| of(group, "each force"));
        lines.push((paper_network(recipe), cells, share_of_counts(counts.map(|over| [over.refused, over.answered]))));
    }
    let line = |truth: TruthId, estimator: EstimatorId, name: &str| {
        let cells = by_group(|group, of| error_or_rounding(estimated(two, (truth, noise_mm, estimator), group, of)));
        let counts = two.of(truth, noise_mm, estimator).map(|row| [row.refused, row.cases]);
        (name.to_owned(), cells, share_of_counts(counts))
    };
    let here = settings(two).into_iter().filter(|(of, noise, _)| (*of, *noise) == (truth, noise_mm));
    lines.extend(here.map(|(.., estimator)| line(truth, estimator, estimator.label())));
    // The Cramer-Rao bound is the same for all estimators; the bound is read from an estimator that answered all cases.
    let bounds = by_group(|group, quantity| {
        let of = two.group(group, truth, noise_mm, EstimatorId::LeastSquares);
        error_or_rounding(of.and_then(|of| if quantity == "sum" { of.sum_bound } else { of.force_bound }))
    });
    lines.push(("Cramer-Rao bound".to_owned(), bounds, String::new()));
    lines.push(line(TruthId::Linear, EstimatorId::LeastSquares, "least squares, linear finger"));
    by_estimator("Mean error of each force and of the sum", CSV, lines)
}

/// Table of the errors of the paper and of each estimator by group, in the paper's order.
fn by_estimator(title: &str, csv: &'static str, lines: Vec<Line>) -> Table {
    let measured = by_group(|group, of| error_or_rounding(of_paper(group, of)));
    let paper = ("the paper, measured".to_owned(), measured, String::new());
    let headings = by_group(|group, quantity| if quantity == "sum" { quantity } else { group.name });
    Columns::<Line>::new()
        .page("sensed by", Format::Words, |(name, ..)| name.clone())
        .each(headings.into_iter().enumerate(), |columns, (i, heading)| {
            columns.cells(heading, Format::Plain, move |(_, cells, _)| cells[i].clone())
        })
        .page("refused", Format::Plain, |(.., refused)| refused.clone())
        .table(title, csv, std::iter::once(paper).chain(lines))
}

/// Cell of an error that may be missing, or that is only rounding.
fn error_or_rounding(share: Option<f64>) -> Cell {
    match share {
        None => Cell::plain(NOTHING),
        Some(rounding) if rounding < ROUNDING => Cell::plain("0 %"),
        Some(share) => error(share),
    }
}
