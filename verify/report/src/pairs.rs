//! Two contacts at once: pairs of nodes at which both forces can be trusted, and the reason why neighbouring nodes are difficult.

use super::drawings::percent_classes;
use super::format::{list, range_of};
use crate::prelude::*;
use finray_studies::experiments::noise::NoiseStudy;
use finray_studies::settings::TWO_FORCES_N;

const CSV: &str = "pairs.csv";
const EACH: &str = "Mean error of each force, %";
const SUM: &str = "Mean error of the sum of both forces, %";
/// Height of the matrix, px, at which its cells are about square.
const MATRIX_HEIGHT: f64 = 480.0;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let rows = study.noise.iter().flat_map(|noise| {
        let estimators = [&noise.pairs, &noise.linear_pairs];
        estimators.into_iter().flat_map(|rows| rows.iter().zip(noise.condition_numbers.iter().copied()))
    });
    let columns = Columns::<(&ScatterRow, f64)>::new()
        .file("nodes", |(row, _)| list(&row.nodes, " "))
        .file("estimator", |(row, _)| row.estimator.name())
        .file("noise_mm", |(row, _)| row.noise_mm)
        .file("drawn", |(row, _)| row.drawn())
        .file("answered", |(row, _)| row.cases)
        .file("refused", |(row, _)| row.refused)
        .file("mean_error", |(row, _)| row.mean_error())
        .file("mean_error_bound", |(row, _)| row.mean_error_bound())
        .file("over_bound", |(row, _)| worse_over_bound(row))
        .file("sum_mean_error", |(row, _)| Some(row.sum?.mean_error))
        .file("sum_over_bound", |(row, _)| Some(row.sum?.bound?.over_bound))
        .file("condition_number", |(_, condition_number)| *condition_number);
    vec![Dataset::new(CSV, &columns, rows)]
}

/// Ratio of root mean square error to Cramer-Rao bound, dimensionless. Of the ratios of the two forces of a pair, the larger is returned.
fn worse_over_bound(row: &ScatterRow) -> Option<f64> {
    row.forces.iter().filter_map(|force: &Scatter| Some(force.bound?.over_bound)).reduce(f64::max)
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(noise) = study.noise.as_ref().filter(|noise| !noise.pairs.is_empty()) else { return Ok(None) };
    let mut blocks = vec![text(about(noise, study.checked_forces().scaled(TWO_FORCES_N)))];
    blocks.extend([trusted(noise), neighbours(noise)].into_iter().flatten().map(text));
    let each = |row: &ScatterRow| row.mean_error().map(|error| 100.0 * error);
    let sum = |row: &ScatterRow| row.sum.map(|sum| 100.0 * sum.mean_error);
    let figures = [(EACH, matrix(noise, EACH, each)?), (SUM, matrix(noise, SUM, sum)?)];
    let caption =
        "by the two contact nodes. Above the diagonal: nonlinear estimator; below the diagonal: least squares.";
    let figures = figures.map(|(what, svg)| Figure::narrow(svg, format!("{what}, {caption}"), CSV));
    blocks.push(Block::Figures(figures.into()));
    Ok(Some(Section::new("pairs", "Two contacts at once", blocks)))
}

/// Text on the forces, cases and noise of the pairs.
fn about(NoiseStudy { pairs, noise_mm, .. }: &NoiseStudy, forces_n: [f64; 2]) -> String {
    let cases = |of: fn(usize, usize) -> usize| pairs.iter().map(ScatterRow::drawn).reduce(of).unwrap_or(0);
    let cases = match [usize::min, usize::max].map(cases) {
        [least, most] if least == most => least.to_string(),
        [least, most] => format!("{least} to {most}"),
    };
    let forces_n = list(forces_n, " to ");
    format!(
        "Forces of {forces_n} N act along the normal at two contact nodes of the uniform finger, in {cases} cases per pair, with {noise_mm} mm noise."
    )
}

/// Matrix of one quantity of every pair: the nonlinear estimator above the diagonal, least squares below it.
fn matrix(noise: &NoiseStudy, title: &str, value: impl Fn(&ScatterRow) -> Option<f64>) -> Result<String, FigureError> {
    let mut nodes: Vec<usize> = noise.pairs.iter().flat_map(|row| row.nodes.clone()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let cell = |row: usize, column: usize| {
        let (rows, pair) = match row < column {
            true => (&noise.pairs, [nodes[row], nodes[column]]),
            false => (&noise.linear_pairs, [nodes[column], nodes[row]]),
        };
        rows.iter().find(|row| row.nodes == pair).and_then(&value)
    };
    let names: Vec<String> = nodes.iter().map(ToString::to_string).collect();
    let at: Vec<f64> = (0..nodes.len()).map(|n| n as f64).collect();
    // The positions are reversed, because rows of a map are numbered from the bottom.
    let down: Vec<f64> = at.iter().rev().copied().collect();
    let values = (0..nodes.len()).map(|row| (0..nodes.len()).map(|column| cell(row, column)).collect()).collect();
    let cells = vec![Some(Cells::new(&at, &down, values))];
    let alt = format!("{title}, for every pair of contact nodes, by the nonlinear estimator and by least squares.");
    let y = Axis::categories("nonlinear, by contact nodes", names.iter().rev().cloned().collect());
    let x = Axis::linear("least squares, by contact nodes").with_ticks([]);
    let frame = Frame::half(title, alt).with_plot_height(MATRIX_HEIGHT);
    Map {
        top: Some(Axis::categories("", names)),
        written: Some(two_digits),
        blank: |row, column| row == column,
        ..Map::new(frame, [x, y], percent_classes(), cells)
    }
    .svg()
}

/// A number with two significant digits, to fit into a cell: 0.62, 2.4, 47.
fn two_digits(value: f64) -> String {
    match value {
        value if value < 0.995 => format!("{value:.2}"),
        value if value < 9.95 => format!("{value:.1}"),
        value => format!("{value:.0}"),
    }
}

/// Sentence on pairs that can be trusted.
fn trusted(NoiseStudy { pairs, linear_pairs, .. }: &NoiseStudy) -> Option<String> {
    let sums = |rows: &[ScatterRow]| Some(range_of(Span::of(rows.iter().filter_map(|row| Some(row.sum?.mean_error)))?));
    let bad = pairs.iter().filter(|row| !row.is_within(TRUSTED_ERROR)).map(|row| list(&row.nodes, " and "));
    let which = match &bad.collect::<Vec<_>>()[..] {
        [] => "every pair".to_owned(),
        bad => format!("all pairs but {}", bad.join(", ")),
    };
    let within = linear_pairs.iter().filter(|row| row.is_within(TRUSTED_ERROR)).count();
    Some(format!(
        "With the nonlinear estimator, both forces of {which} can be trusted to 10 % (sums err by {}; {}). Least squares stays within 10 % at {within} of {} \
         pairs (sums: {}; {}). A refused case counts as an error of 100 %.",
        sums(pairs)?,
        Counts::of(pairs),
        pairs.len(),
        sums(linear_pairs)?,
        Counts::of(linear_pairs)
    ))
}

/// Sentence on the errors of neighbouring nodes.
fn neighbours(noise: &NoiseStudy) -> Option<String> {
    let pairs = || noise.pairs.iter().zip(&noise.condition_numbers);
    // Errors and condition numbers of the pairs whose difference of node numbers satisfies `wanted`.
    let apart = |wanted: fn(usize) -> bool| {
        let of = pairs().filter(move |(row, _)| wanted(row.nodes[1] - row.nodes[0]));
        let errors = range_of(Span::of(of.clone().filter_map(|(row, _)| row.mean_error()))?);
        Some((errors, Span::of(of.map(|(_, condition)| *condition))?.ends()))
    };
    let (near_errors, [near_least, near_most]) = apart(|steps| steps == 1)?;
    let (far_errors, [far_least, far_most]) = apart(|steps| steps > 2)?;
    let over = |rows: &[ScatterRow]| Some(Span::of(rows.iter().filter_map(worse_over_bound))?.ends());
    let cases = noise.pairs.iter().map(ScatterRow::drawn).min()?;
    let chance = 100.0 / (2.0 * cases as f64).sqrt();
    let ([least, most], [linear_least, linear_most]) = (over(&noise.pairs)?, over(&noise.linear_pairs)?);
    Some(format!(
        "Forces at neighbouring nodes bend the finger almost equally. The difference of the two shapes is {near_least:.1} to {near_most:.1} times smaller \
         than their common part (three or more nodes apart: {far_least:.1} to {far_most:.1}), so each force errs by {near_errors} instead of {far_errors}. \
         The nonlinear estimator errs by {least:.2} to {most:.2} times the Cramer-Rao bound (root mean square; random sampling alone varies this ratio \
         by {chance:.0} %), least squares by {linear_least:.1} to {linear_most:.0} times this bound."
    ))
}
