//! What the nonlinear estimator makes of camera noise: tables.

use super::page::{Block, Cell, Column, Row, Section, Table};
use super::sections::{self, text};
use super::table_two::nodes_in_words;
use super::tables::percent;
use crate::experiments::noise::NoiseStudy;
use crate::sampling::scatter::{Scatter, ScatterRow};
use crate::settings::{ONE_FORCE_N, TWO_FORCES_N};
use crate::study::Study;
use serde::Serialize;

pub(super) const CSV: &str = "noise.csv";

/// One quantity of one set of contacts, as it stands in the CSV.
#[derive(Serialize)]
pub(super) struct CsvRow {
    nodes: String,
    quantity: String,
    drawn: usize,
    answered: usize,
    refused: usize,
    mean_error: f64,
    mean_error_bound: Option<f64>,
    scatter_over_bound: Option<f64>,
    bias_over_bound: Option<f64>,
    covered_by_one_sigma: Option<f64>,
    covered_by_1_96_sigma: Option<f64>,
}

/// A row for each force, and for the sum where there are several.
pub(super) fn csv_rows(noise: &NoiseStudy) -> impl Iterator<Item = CsvRow> {
    noise.single.iter().chain(&noise.promised).flat_map(|row| {
        let nodes = row.nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        let forces = row.nodes.iter().zip(&row.forces).map(|(node, scatter)| (format!("force at {node}"), *scatter));
        let sum = row.sum.filter(|_| row.nodes.len() > 1).map(|sum| ("sum".to_owned(), sum));
        forces
            .chain(sum)
            .map(|(quantity, scatter)| CsvRow {
                nodes: nodes.clone(),
                quantity,
                drawn: row.drawn(),
                answered: row.cases,
                refused: row.refused,
                mean_error: scatter.mean_error,
                mean_error_bound: scatter.bound.map(|bound| bound.mean_error_bound),
                scatter_over_bound: scatter.bound.map(|bound| bound.over_bound),
                bias_over_bound: scatter.bound.map(|bound| bound.bias_over_bound),
                covered_by_one_sigma: scatter.coverage.map(|covered| covered.one_sigma),
                covered_by_1_96_sigma: scatter.coverage.map(|covered| covered.two_sigma),
            })
            .collect::<Vec<_>>()
    })
}

pub(super) fn section(study: &Study) -> Option<Section> {
    let noise = study.noise.as_ref()?;
    let cases = noise.single.iter().map(ScatterRow::drawn).max().unwrap_or(1);
    let mut blocks = vec![
        text(format!(
            "Random forces along the normal ({} to {} N on one node, {} to {} N on each of two) bend the large-rotation \
             finger of the fine mesh; {} mm of noise is added to each coordinate, and the nonlinear estimator on four \
             elements a member senses the forces, {} times for each node. The bound is that of Cramer and Rao: no \
             unbiased estimator scatters less. The last two columns say how often the truth lies within one and within 1.96 \
             of the standard deviations that the estimator states; 68 and 95 % are meant. Chance alone moves a scatter by {}. \
             What the noise leaves open is refused: means and scatters are over the answered cases, so the counts stand beside them.",
            ONE_FORCE_N[0],
            ONE_FORCE_N[1],
            TWO_FORCES_N[0],
            TWO_FORCES_N[1],
            noise.noise_mm,
            cases,
            percent(1.0 / (2.0 * cases as f64).sqrt())
        )),
        Block::Table(single(&noise.single)),
    ];
    if !noise.promised.is_empty() {
        blocks.push(Block::Table(promised(&noise.promised)));
    }
    Some(sections::section("noise", "Nonlinear sensing", blocks))
}

/// Nothing where the finger carries no force of the range.
fn shown(row: &ScatterRow, text: impl Fn(&Scatter) -> Option<String>) -> String {
    row.forces.first().and_then(text).unwrap_or_else(|| "-".to_owned())
}

fn single(rows: &[ScatterRow]) -> Table {
    let row = |row: &ScatterRow| Row {
        cells: [
            row.nodes[0].to_string(),
            shown(row, |s| Some(percent(s.mean_error))),
            shown(row, |s| Some(percent(s.bound?.mean_error_bound))),
            shown(row, |s| Some(format!("{:.2}", s.bound?.over_bound))),
            shown(row, |s| Some(percent(s.coverage?.one_sigma))),
            shown(row, |s| Some(percent(s.coverage?.two_sigma))),
            row.drawn().to_string(),
            row.cases.to_string(),
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
            "drawn",
            "answered",
            "refused",
        ]
        .map(Column::numbers)
        .into(),
        rows: rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}

/// Two contacts: what is promised of four pairs.
fn promised(rows: &[ScatterRow]) -> Table {
    let row = |row: &ScatterRow| {
        let sum = row.sum;
        let cells = [
            nodes_in_words(&row.nodes, " and "),
            shown(row, |_| row.mean_error().map(percent)),
            shown(row, |_| row.mean_error_bound().map(percent)),
            shown(row, |_| Some(percent(sum?.mean_error))),
            shown(row, |_| Some(percent(sum?.bound?.mean_error_bound))),
            row.drawn().to_string(),
            row.cases.to_string(),
            row.refused.to_string(),
        ];
        Row { cells: cells.map(Cell::plain).into() }
    };
    let columns =
        ["nodes", "mean error of each", "at the bound", "of the sum", "at the bound", "drawn", "answered", "refused"];
    Table {
        caption: "Two contacts: neighbours and nodes apart".to_owned(),
        columns: columns.map(Column::numbers).into(),
        rows: rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}
