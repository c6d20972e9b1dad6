//! The shipped networks, their training, and the network size that is needed.

use super::drawings::{Line, one_and_two};
use super::format::{list, percent_with};
use super::trainings;
use crate::prelude::*;
use finray_studies::experiments::networks::accuracy::{FORCES_N, NetworkStudy};
use finray_studies::statistics::mean;

const CSV: &str = "networks.csv";
pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    // Each set of contacts has a row for the mean of the forces, and a row for the sum of the forces if several forces act.
    let quantities = |row: &'s ScatterRow| [Some((row, None)), sum(row).map(|sum| (row, Some(sum)))];
    let rows = study.networks.iter().flat_map(|networks| &networks.rows).flat_map(quantities).flatten();
    let columns = Columns::<(&ScatterRow, Option<&Scatter>)>::new()
        .file("nodes", |(row, _)| list(&row.nodes, " "))
        .file("quantity", |(_, sum)| if sum.is_some() { "sum" } else { "each force" })
        .file("noise_mm", |(row, _)| row.noise_mm)
        .file("drawn", |(row, _)| row.drawn())
        .file("answered", |(row, _)| row.cases)
        .file("refused", |(row, _)| row.refused)
        .file("mean_error", |(row, sum)| sum.map_or_else(|| row.mean_error(), |sum| Some(sum.mean_error)))
        .file("mean_error_bound", |(row, sum)| sum.map_or_else(|| row.mean_error_bound(), bound))
        .file("covered_by_1_96_sigma", |(row, sum)| if sum.is_some() { None } else { coverage(row) });
    std::iter::once(Dataset::new(CSV, &columns, rows)).chain(trainings::datasets(study)).collect()
}

/// Errors of the sum of several forces; `None` for a single force.
fn sum(row: &ScatterRow) -> Option<&Scatter> {
    row.sum.as_ref().filter(|_| row.nodes.len() > 1)
}

fn bound(scatter: &Scatter) -> Option<f64> {
    Some(scatter.bound?.mean_error_bound)
}

/// Share of all forces that lie within 1.96 stated standard deviations.
fn coverage(row: &ScatterRow) -> Option<f64> {
    let shares: Option<Vec<f64>> = row.forces.iter().map(|force| Some(force.coverage?.two_sigma)).collect();
    mean(shares?)
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let mut blocks = Vec::new();
    if let Some(networks) = &study.networks {
        blocks.push(text(about(networks.noise_mm)));
        blocks.push(errors(networks)?);
    }
    blocks.extend(trainings::blocks(study)?);
    let says = study.networks.as_ref().and_then(says);
    Ok((!blocks.is_empty()).then(|| Section::new("networks", "The sensing network", blocks).saying(says)))
}

/// Text on what the networks were trained on, and on what they sense.
fn about(noise_mm: f64) -> String {
    let forces_n = list(FORCES_N, " to ");
    format!(
        "The networks are for eleven single nodes and four pairs of nodes of the paper's finger. They sense \
            {forces_n} N along the normal with {noise_mm} mm noise. They were trained on the uniform finger, and are \
            tested here on the uniform finger."
    )
}

/// Sentence on the networks' errors relative to the bound, and on the tolerances that hold.
fn says(networks: &NetworkStudy) -> Option<String> {
    // Two decimals distinguish an error from its bound.
    let percent = |share| percent_with(share, 2);
    let errors = |forces: usize| {
        let of_so_many = networks.rows.iter().filter(|row| row.nodes.len() == forces);
        let span = Span::of(of_so_many.filter_map(ScatterRow::mean_error))?;
        Some(format!("{} to {}", percent(span.least), percent(span.greatest)))
    };
    let over = networks.rows.iter().filter_map(|row| Some((row.mean_error()? / row.mean_error_bound()?, row)));
    let (most, worst) = over.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let sums = networks.rows.iter().filter_map(|row| Some((sum(row)?.mean_error / bound(sum(row)?)?, row)));
    let sum = sums.max_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(String::new, |(most, row)| {
        format!(
            ", and the sum of two forces by at most {most:.2} times its bound (nodes {})",
            list(&row.nodes, " and ")
        )
    });
    let checks = networks.checks();
    let kept = checks.iter().filter(|check| check.passes()).count();
    let tolerances = match checks.len() {
        0 => String::new(),
        tolerances => format!(" {kept} of {tolerances} checks against these bounds pass."),
    };
    let (one, two, counts) = (errors(1)?, errors(2)?, Counts::of(&networks.rows));
    let (plural, nodes) = (if worst.nodes.len() > 1 { "s" } else { "" }, list(&worst.nodes, " and "));
    Some(format!(
        "The shipped networks err by {one} for one force and by {two} for each of two forces ({counts}). Each force errs by at most {most:.2} times \
         its Cramer-Rao bound (node{plural} {nodes}){sum}.{tolerances}"
    ))
}

/// Charts of the errors and their bounds, by contact.
fn errors(networks: &NetworkStudy) -> Result<Block, FigureError> {
    let rows = networks.rows.iter().rev().map(|row| (list(&row.nodes, ", "), row)).collect();
    let lines: [Line<&ScatterRow>; 4] = [
        ("each force", |row| Some(100.0 * row.mean_error()?)),
        ("its bound", |row| Some(100.0 * row.mean_error_bound()?)),
        ("sum", |row| Some(100.0 * sum(row)?.mean_error)),
        ("bound of the sum", |row| Some(100.0 * bound(sum(row)?)?)),
    ];
    one_and_two("Shipped networks", "mean error, %", rows, &lines, CSV)
}
