//! Errors of the nonlinear estimator under camera noise, compared with the Cramer-Rao bound.

use super::drawings::{Line, by_contact};
use super::format::{list, range_of};
use crate::prelude::*;
use finray_studies::experiments::noise::NoiseStudy;
use finray_studies::settings::{ONE_FORCE_N, TWO_FORCES_N};

const CSV: &str = "noise.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    // Each set of contacts has one row per force, and a row for the sum of the forces if several forces act.
    let quantities = |row: &'s ScatterRow| {
        let forces = row.nodes.iter().zip(&row.forces).map(|(node, scatter)| (format!("force at {node}"), *scatter));
        let sum = row.sum.filter(|_| row.nodes.len() > 1).map(|sum| ("sum".to_owned(), sum));
        forces.chain(sum).map(move |(quantity, scatter)| (row, quantity, scatter))
    };
    let rows = study.noise.iter().flat_map(|noise| noise.single.iter().chain(&noise.checked)).flat_map(quantities);
    let columns = Columns::<(&ScatterRow, String, Scatter)>::new()
        .file("nodes", |(row, ..)| list(&row.nodes, " "))
        .file("quantity", |(_, quantity, _)| quantity.clone())
        .file("drawn", |(row, ..)| row.drawn())
        .file("answered", |(row, ..)| row.cases)
        .file("refused", |(row, ..)| row.refused)
        .file("mean_error", |(.., scatter)| scatter.mean_error)
        .file("mean_error_bound", |(.., scatter)| Some(scatter.bound?.mean_error_bound))
        .file("scatter_over_bound", |(.., scatter)| Some(scatter.bound?.over_bound))
        .file("bias_over_bound", |(.., scatter)| Some(scatter.bound?.bias_over_bound))
        .file("covered_by_one_sigma", |(.., scatter)| Some(scatter.coverage?.one_sigma))
        .file("covered_by_1_96_sigma", |(.., scatter)| Some(scatter.coverage?.two_sigma));
    vec![Dataset::new(CSV, &columns, rows).csv_alone()]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(noise) = &study.noise else { return Ok(None) };
    let forces_n = [ONE_FORCE_N, TWO_FORCES_N].map(|range_n| study.checked_forces().scaled(range_n));
    let mut blocks = vec![text(about(&noise.single, forces_n))];
    let title = format!("Error of a force along the normal, {} mm noise", noise.noise_mm);
    let alt = format!("{title}, by contact node, beside the mean error at the Cramer-Rao bound.");
    let rows: Vec<(String, &ScatterRow)> = noise.single.iter().rev().map(|row| (list(&row.nodes, ", "), row)).collect();
    // A row contains no force if the finger has no equilibrium at the node of this row under any force of the range.
    let lines: [Line<&ScatterRow>; 2] = [
        ("nonlinear estimator", |row| Some(100.0 * row.forces.first()?.mean_error)),
        ("at the bound", |row| Some(100.0 * row.forces.first()?.bound?.mean_error_bound)),
    ];
    if let Some(svg) = by_contact(Frame::full(title, alt), "mean error, %", &rows, &lines)? {
        blocks.push(Block::Figure(Figure::wide(
            svg,
            "These errors are for one force. The page Maps shows pairs of forces.",
            CSV,
        )));
    }
    Ok(Some(Section::new("noise", "Force error from camera noise", blocks).saying(says(noise))))
}

/// Forces, cases and bound. `forces_n` has the range of a single force, and the range of each of two forces, N.
fn about(single: &[ScatterRow], forces_n: [[f64; 2]; 2]) -> String {
    let cases = single.iter().map(ScatterRow::drawn).max().unwrap_or(1);
    let [one_n, two_n] = forces_n.map(|range_n| list(range_n, " to "));
    format!(
        "Random forces ({one_n} N on one node, {two_n} N on each of two) on the uniform finger, {cases} cases per node. The bound is the Cramer-Rao bound; \
         95 % of the forces should lie within 1.96 sigma. Means are over answered cases."
    )
}

/// Sentence on the range of the mean errors over the nodes.
fn says(NoiseStudy { noise_mm, single, pairs, .. }: &NoiseStudy) -> Option<String> {
    let errors = |rows: &[ScatterRow]| {
        let errors = range_of(Span::of(rows.iter().filter_map(ScatterRow::mean_error))?);
        Some(format!("{errors} ({})", Counts::of(rows)))
    };
    let one = errors(single)?;
    let two = errors(pairs).map_or_else(String::new, |two| format!(", and each of two forces with {two}"));
    Some(format!(
        "With {noise_mm} mm noise the nonlinear estimator senses a force along the normal with a mean error of {one}{two}. The \
         error depends on the position."
    ))
}
