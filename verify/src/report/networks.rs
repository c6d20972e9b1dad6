//! The networks that ship, then how they are trained and how large they must be.

use super::page::{Block, Cell, Column, Row, Section, Table};
use super::sections::{self, text};
use super::table_two::{nodes_in_words, share_refused};
use super::tables::{error, verdict};
use super::{ReportError, curves, recipes};
use crate::check::Check;
use crate::experiments::networks::accuracy::{FORCES_N, NetworkStudy};
use crate::sampling::scatter::{Counts, Scatter, ScatterRow};
use crate::settings::ENOUGH_CASES;
use crate::study::Study;
use serde::Serialize;

pub(super) const CSV: &str = "networks.csv";
/// What [`PROMISES`](crate::experiments::networks::accuracy::PROMISES) say.
const PROMISED: &str = "; promised are 1.6 % for a single node, 4 % for each of two neighbours, 2 % for each of two nodes apart, 1 % \
                        for a sum";

/// One quantity of one set of contacts, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NetworkRow {
    /// Contact nodes, by spaces.
    pub nodes: String,
    /// `each force` or `sum`.
    pub quantity: &'static str,
    /// Standard deviation of one coordinate, mm.
    pub noise_mm: f64,
    /// Cases that were drawn.
    pub drawn: usize,
    /// Cases that the network answered; the mean is theirs.
    pub answered: usize,
    /// Cases that the network refused.
    pub refused: usize,
    /// Mean of |sensed / true - 1|.
    pub mean_error: Option<f64>,
    /// What an estimator that reaches the Cramer-Rao bound has as its mean error.
    pub mean_error_bound: Option<f64>,
    /// Share of forces within 1.96 stated standard deviations.
    pub covered_by_1_96_sigma: Option<f64>,
}

/// A row for the mean of the forces, and for their sum where there are several.
pub(super) fn rows(networks: &NetworkStudy) -> impl Iterator<Item = NetworkRow> {
    networks.rows.iter().flat_map(|row| {
        let quantity = |quantity, mean_error, mean_error_bound, covered_by_1_96_sigma| NetworkRow {
            nodes: nodes_in_words(&row.nodes, " "),
            quantity,
            noise_mm: row.noise_mm,
            drawn: row.drawn(),
            answered: row.cases,
            refused: row.refused,
            mean_error,
            mean_error_bound,
            covered_by_1_96_sigma,
        };
        let each = quantity("each force", row.mean_error(), row.mean_error_bound(), coverage(row));
        let [error, bound] = sum(row).map_or([None, None], |sum| [Some(sum.mean_error), bound(sum)]);
        let sum = sum(row).map(|_| quantity("sum", error, bound, None));
        [Some(each), sum].into_iter().flatten()
    })
}

/// The sum of several forces.
fn sum(row: &ScatterRow) -> Option<&Scatter> {
    row.sum.as_ref().filter(|_| row.nodes.len() > 1)
}

fn bound(scatter: &Scatter) -> Option<f64> {
    Some(scatter.bound?.mean_error_bound)
}

/// Share of all forces within 1.96 stated standard deviations.
fn coverage(row: &ScatterRow) -> Option<f64> {
    let shares: Option<Vec<f64>> = row.forces.iter().map(|force| Some(force.coverage?.two_sigma)).collect();
    shares.filter(|shares| !shares.is_empty()).map(|shares| shares.iter().sum::<f64>() / shares.len() as f64)
}

pub(super) fn section(study: &Study) -> Result<Option<Section>, ReportError> {
    let mut blocks = Vec::new();
    if let Some(networks) = &study.networks {
        blocks.push(text(format!(
            "Networks that answer in microseconds ship with finray for eleven single nodes and four pairs of the paper's \
             finger. Trained on large rotations and camera noise, they sense the large-rotation finger of the fine mesh here: \
             forces of {} to {} N along the normal, {} mm of noise. The bound is that of Cramer and Rao; covered is how often \
             a force lies within 1.96 of the standard deviations that the network states (95 % are meant).",
            FORCES_N[0], FORCES_N[1], networks.noise_mm
        )));
        blocks.push(Block::Table(table(networks)));
    }
    if let Some(two) = &study.table_two {
        blocks.extend(recipes::blocks(&study.records.recipes, two));
    }
    blocks.extend(curves::blocks(&study.records.curves)?);
    Ok((!blocks.is_empty()).then(|| sections::section("networks", "The sensing network", blocks)))
}

/// How near the networks come to the bound, and whether they keep their promises.
pub(super) fn words(networks: &NetworkStudy) -> Option<String> {
    let errors = |forces: usize| {
        let of_so_many = networks.rows.iter().filter(|row| row.nodes.len() == forces);
        let errors: Vec<f64> = of_so_many.filter_map(ScatterRow::mean_error).collect();
        let low = errors.iter().copied().reduce(f64::min)?;
        Some([low, errors.into_iter().fold(low, f64::max)].map(percent))
    };
    let ([low, high], [low_pair, high_pair]) = (errors(1)?, errors(2)?);
    let over = networks.rows.iter().filter_map(|row| Some((row.mean_error()? / row.mean_error_bound()?, row)));
    let (most, worst) = over.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let sums = networks.rows.iter().filter_map(|row| Some(sum(row)?.mean_error)).fold(0.0, f64::max);
    let checks = networks.checks();
    let kept = checks.iter().filter(|check| check.passes()).count();
    let promises = match checks.len() {
        0 => String::new(),
        all => format!(" {kept} of {all} tolerances of accuracy hold."),
    };
    Some(format!(
        "The networks that ship err by {low} to {high} for one force, by {low_pair} to {high_pair} for each of two, and by no \
         more than {} for their sum ({}): at most {most:.2} times the bound (node{} {}).{promises}",
        percent(sums),
        Counts::of(&networks.rows),
        if worst.nodes.len() > 1 { "s" } else { "" },
        nodes_in_words(&worst.nodes, " and ")
    ))
}

/// In percent, with as many digits as tell an error from its bound.
fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

/// The same, shaded as all errors are.
fn shaded(share: f64) -> Cell {
    Cell { text: percent(share), ..error(share) }
}

fn table(networks: &NetworkStudy) -> Table {
    let promised = !networks.checks().is_empty();
    let shown = |share: Option<f64>| Cell::plain(share.map_or_else(String::new, percent));
    let row = |row: &ScatterRow| {
        let mut cells = vec![
            Cell::plain(nodes_in_words(&row.nodes, ", ")),
            Cell::plain(row.drawn().to_string()),
            row.mean_error().map_or_else(|| Cell::plain("-"), shaded),
            shown(row.mean_error_bound()),
            sum(row).map_or_else(|| Cell::plain(""), |sum| shaded(sum.mean_error)),
            shown(sum(row).and_then(bound)),
            Cell::plain(coverage(row).map_or_else(String::new, |share| format!("{:.1} %", 100.0 * share))),
            Cell::plain(share_refused([row])),
        ];
        if promised {
            let kept = networks.checks_of(row).iter().all(Check::passes);
            cells.push(verdict(kept, ["kept", "broken"]));
        }
        Row { cells }
    };
    let promise = promised.then(|| Column::words("promise"));
    let promises = if promised { PROMISED } else { "" };
    let few = promised && networks.rows.iter().any(|row| row.drawn() < ENOUGH_CASES);
    let few = if few { " (here and three standard errors, for few cases)" } else { "" };
    Table {
        caption: format!("Mean error of the networks that ship{promises}{few}"),
        columns: [Column::words("nodes")]
            .into_iter()
            .chain(
                ["cases drawn", "each force", "bound", "sum", "bound of sum", "covered", "refused"]
                    .map(Column::numbers),
            )
            .chain(promise)
            .collect(),
        rows: networks.rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}
