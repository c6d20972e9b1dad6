//! The shipped networks, their training, and the network size that is needed.

use super::format::{NOTHING, error_as, list, percent_with, share_refused, verdict};
use super::trainings;
use crate::prelude::*;
use finray_studies::experiments::networks::accuracy::{FORCES_N, NetworkStudy};
use finray_studies::settings::ENOUGH_CASES;
use finray_studies::statistics::mean;

const CSV: &str = "networks.csv";
pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    // One row for the mean of the forces, and one for their sum if there are several.
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
    std::iter::once(Dataset::new(CSV, &columns, rows)).chain(trainings::datasets(&study.records)).collect()
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
        let numbers = context! { forces_n => FORCES_N, noise_mm => networks.noise_mm };
        blocks.push(paragraph("networks.about", numbers)?);
        blocks.push(details("By contact", vec![Block::Table(table(networks))]));
    }
    blocks.extend(trainings::blocks(&study.records)?);
    let says = say("networks.says", study.networks.as_ref().and_then(in_words))?;
    Ok((!blocks.is_empty()).then(|| Section::new("networks", "The sensing network", blocks).saying(says)))
}

/// Numbers for the sentence on the networks' errors relative to the bound, and on the tolerances that hold.
fn in_words(networks: &NetworkStudy) -> Option<Value> {
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
    let sum = sums.max_by(|a, b| a.0.total_cmp(&b.0));
    let checks = networks.checks();
    Some(context! {
        one => errors(1)?,
        two => errors(2)?,
        counts => Counts::of(&networks.rows).to_string(),
        most,
        nodes => worst.nodes.clone(),
        sum => sum.map(|(most, row)| context! { most, nodes => row.nodes.clone() }),
        kept => checks.iter().filter(|check| check.passes()).count(),
        tolerances => checks.len(),
    })
}

fn table(networks: &NetworkStudy) -> Table {
    let checked = !networks.checks().is_empty();
    let shaded = |share: Option<f64>| match share {
        Some(share) => error_as(percent_with(share, 2), share),
        None => Cell::plain(NOTHING),
    };
    let few = checked && networks.rows.iter().any(|row| row.drawn() < ENOUGH_CASES);
    let caption = match few {
        true => "Mean error; with few cases, tolerances are wider by three standard errors",
        false => "Mean error; covered: within 1.96 stated standard deviations (95 % are meant)",
    };
    let columns = Columns::<&ScatterRow>::new()
        .page("nodes", Format::Words, |row| list(&row.nodes, ", "))
        .cells(Column::numbers("each force"), move |row| shaded(row.mean_error()))
        .page("bound", Format::PercentFixed(2), |row| row.mean_error_bound())
        .cells(Column::numbers("sum"), move |row| shaded(sum(row).map(|sum| sum.mean_error)))
        .page("its bound", Format::PercentFixed(2), |row| bound(sum(row)?))
        .page("covered", Format::PercentFixed(1), |row| coverage(row))
        .page("refused", Format::Plain, |row| share_refused([*row]));
    let kept = |row: &&ScatterRow| verdict(networks.checks_of(row).iter().all(Check::passes), ["kept", "broken"]);
    let columns = match checked {
        true => columns.cells(Column::words("tolerance"), kept),
        false => columns,
    };
    columns.table(caption, CSV, &networks.rows)
}
