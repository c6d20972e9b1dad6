//! What the nonlinear estimator makes of camera noise: tables.

use super::page::{Block, Cell, Column, Row, Section, Shade, Table};
use super::sections::{self, text};
use super::tables::percent;
use crate::scatter::{ONE_FORCE_N, Scatter, ScatterRow, TWO_FORCES_N};
use crate::study::{NoiseStudy, Study};
use serde::Serialize;

pub(super) const CSV: &str = "noise.csv";

/// One quantity of one set of contacts, as it stands in the CSV.
#[derive(Serialize)]
pub(super) struct CsvRow {
    nodes: String,
    quantity: String,
    cases: usize,
    refused: usize,
    mean_error: f64,
    mean_error_bound: f64,
    scatter_over_bound: f64,
    bias_over_bound: f64,
    covered_by_one_sigma: f64,
    covered_by_1_96_sigma: f64,
}

/// A row for each force, and for the sum where there are several.
pub(super) fn csv_rows(noise: &NoiseStudy) -> impl Iterator<Item = CsvRow> {
    noise.single.iter().chain(&noise.pairs).flat_map(|row| {
        let nodes = row.nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        let forces = row.nodes.iter().zip(&row.forces).map(|(node, scatter)| (format!("force at {node}"), *scatter));
        let sum = (row.nodes.len() > 1).then(|| ("sum".to_owned(), row.sum));
        forces
            .chain(sum)
            .map(|(quantity, scatter)| CsvRow {
                nodes: nodes.clone(),
                quantity,
                cases: row.cases,
                refused: row.refused,
                mean_error: scatter.mean_error,
                mean_error_bound: scatter.mean_error_bound,
                scatter_over_bound: scatter.over_bound,
                bias_over_bound: scatter.bias_over_bound,
                covered_by_one_sigma: scatter.covered_by_one_sigma,
                covered_by_1_96_sigma: scatter.covered_by_two_sigma,
            })
            .collect::<Vec<_>>()
    })
}

pub(super) fn section(study: &Study) -> Option<Section> {
    let noise = study.noise.as_ref()?;
    let mut blocks = vec![
        text(format!(
            "Random forces along the normal ({} to {} N on one node, {} to {} N on each of two) bend the large-rotation \
             finger of the fine mesh; {} mm of noise is added to each coordinate, and the nonlinear estimator on four \
             elements a member senses the forces, {} times for each set of contacts. The bound is that of Cramer and Rao: no \
             unbiased estimator scatters less. The last two columns say how often the truth lies within one and within 1.96 \
             of the standard deviations that the estimator states; 68 and 95 % are meant. Chance alone moves a scatter by {}. \
             What the noise leaves open is refused and counts in no other column.",
            ONE_FORCE_N[0],
            ONE_FORCE_N[1],
            TWO_FORCES_N[0],
            TWO_FORCES_N[1],
            noise.noise_mm,
            noise.cases,
            percent(1.0 / (2.0 * noise.cases as f64).sqrt())
        )),
        Block::Table(single(&noise.single)),
    ];
    if !noise.pairs.is_empty() {
        blocks.extend(pair_figures(&noise.pairs).map(text));
        blocks.push(Block::Table(pairs(&noise.pairs)));
    }
    Some(sections::section("noise", "Nonlinear sensing", blocks))
}

/// Nothing where the finger carries no force of the range.
fn shown(row: &ScatterRow, text: impl Fn(&Scatter) -> String) -> String {
    match (row.cases, row.forces.first()) {
        (1.., Some(scatter)) => text(scatter),
        _ => "-".to_owned(),
    }
}

fn single(rows: &[ScatterRow]) -> Table {
    let row = |row: &ScatterRow| Row {
        cells: [
            row.nodes[0].to_string(),
            shown(row, |s| percent(s.mean_error)),
            shown(row, |s| percent(s.mean_error_bound)),
            shown(row, |s| format!("{:.2}", s.over_bound)),
            shown(row, |s| percent(s.covered_by_one_sigma)),
            shown(row, |s| percent(s.covered_by_two_sigma)),
            row.refused.to_string(),
        ]
        .map(Cell::plain)
        .into(),
    };
    Table {
        caption: "One contact: mean error of the sensed force by node".to_owned(),
        columns: [
            "node",
            "mean error",
            "at the bound",
            "scatter / bound",
            "within sigma",
            "within 1.96 sigma",
            "refused",
        ]
        .map(Column::numbers)
        .into(),
        rows: rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}

/// How near all pairs come to the bound, in words.
fn pair_figures(rows: &[ScatterRow]) -> Option<String> {
    let sensed: Vec<&ScatterRow> = rows.iter().filter(|row| row.cases > 0).collect();
    let quantities = || sensed.iter().flat_map(|row| row.forces.iter().chain([&row.sum]));
    let range = |of: fn(&Scatter) -> f64| {
        quantities().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let worst_sum = sensed.iter().max_by(|a, b| a.sum.mean_error.total_cmp(&b.sum.mean_error))?;
    let scatter = range(|s| s.over_bound);
    let covered = range(|s| s.covered_by_two_sigma).map(percent);
    Some(format!(
        "Two contacts at once, all {} pairs: forces and sums scatter by {:.2} to {:.2} bounds, and 1.96 stated sigma cover {} \
         to {} of the cases. The sum is sensed far better than its parts: at worst its mean error is {} (nodes {} and {}).",
        sensed.len(),
        scatter[0],
        scatter[1],
        covered[0],
        covered[1],
        percent(worst_sum.sum.mean_error),
        worst_sum.nodes[0],
        worst_sum.nodes[1]
    ))
}

fn pairs(rows: &[ScatterRow]) -> Table {
    let mut nodes: Vec<usize> = rows.iter().flat_map(|row| row.nodes.clone()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let cell = |first: usize, second: usize| {
        let Some(row) = rows.iter().find(|row| row.nodes == [first, second] && row.cases > 0) else {
            return Cell::plain("");
        };
        match row.mean_error() {
            error if error > 0.25 => Cell::shaded(percent(error), Shade::Dark),
            error if error > 0.10 => Cell::shaded(percent(error), Shade::Grey),
            error => Cell::plain(percent(error)),
        }
    };
    let seconds = nodes.get(1..).unwrap_or_default();
    let row = |&first: &usize| Row {
        cells: std::iter::once(Cell::plain(first.to_string()))
            .chain(seconds.iter().map(|&second| cell(first, second)))
            .collect(),
    };
    Table {
        caption: "Two contacts: mean error of the two forces by their nodes; grey above 10 %, dark above 25 %"
            .to_owned(),
        columns: std::iter::once("node".to_owned())
            .chain(seconds.iter().map(ToString::to_string))
            .map(Column::numbers)
            .collect(),
        rows: nodes.iter().take(nodes.len().saturating_sub(1)).map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}
