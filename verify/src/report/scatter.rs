//! Nonlinear sensing under camera noise, against the Cramer-Rao bound.

use super::dataset::{Columns, Dataset, Format};
use super::format::{Span, list, nodes_in_words, percent};
use super::page::{Block, Section, text};
use super::{ReportError, Results};
use crate::experiments::noise::NoiseStudy;
use crate::sampling::scatter::{Counts, Scatter, ScatterRow};
use crate::settings::{ONE_FORCE_N, TWO_FORCES_N};

const CSV: &str = "noise.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    // A row for each force, and for the sum where there are several.
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
    let cases = noise.single.iter().map(ScatterRow::drawn).max().unwrap_or(1);
    let mut blocks = vec![text(format!(
        "Random forces along the normal ({} to {} N on one node, {} to {} N on each of two) bend the co-rotational \
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
    ))];
    // No force of the range may be carried at a node.
    let first = |row: &ScatterRow| row.forces.first().copied();
    let single = Columns::<&ScatterRow>::new()
        .page("node", Format::Plain, |row| row.nodes[0])
        .page("mean error", Format::Percent, move |row| Some(first(row)?.mean_error))
        .page("at the bound", Format::Percent, move |row| Some(first(row)?.bound?.mean_error_bound))
        .page("scatter / bound", Format::Fixed(2), move |row| Some(first(row)?.bound?.over_bound))
        .page("within sigma", Format::Percent, move |row| Some(first(row)?.coverage?.one_sigma))
        .page("within 1.96 sigma", Format::Percent, move |row| Some(first(row)?.coverage?.two_sigma));
    let pairs = Columns::<&ScatterRow>::new()
        .page("nodes", Format::Plain, |row| nodes_in_words(&row.nodes))
        .page("mean error of each", Format::Percent, |row| row.mean_error())
        .page("at the bound", Format::Percent, |row| row.mean_error_bound())
        .page("of the sum", Format::Percent, |row| Some(row.sum?.mean_error))
        .page("at the bound", Format::Percent, |row| Some(row.sum?.bound?.mean_error_bound));
    let one = "One contact: mean error of the sensed force by node";
    blocks.push(Block::Table(with_counts(single).table(one, CSV, &noise.single)));
    if !noise.checked.is_empty() {
        let two = "Two contacts: neighbours and nodes apart";
        blocks.push(Block::Table(with_counts(pairs).table(two, CSV, &noise.checked)));
    }
    Ok(Some(Section::new("noise", "Nonlinear sensing", blocks).saying(in_words(noise))))
}

fn with_counts<'s>(columns: Columns<'s, &'s ScatterRow>) -> Columns<'s, &'s ScatterRow> {
    columns.page("drawn", Format::Plain, |row| row.drawn()).page("answered", Format::Plain, |row| row.cases).page(
        "refused",
        Format::Plain,
        |row| row.refused,
    )
}

/// The range of the mean errors over the nodes.
fn in_words(noise: &NoiseStudy) -> Option<String> {
    let range = |rows: &[ScatterRow]| Some(Span::of(rows.iter().filter_map(ScatterRow::mean_error))?.range());
    let pairs = range(&noise.pairs)
        .map_or_else(String::new, |pairs| format!(", two contacts with {pairs} each ({})", Counts::of(&noise.pairs)));
    Some(format!(
        "With {} mm noise the nonlinear estimator senses one contact along the normal with a mean error of {} ({}){pairs}, by \
         its position.",
        noise.noise_mm,
        range(&noise.single)?,
        Counts::of(&noise.single)
    ))
}
