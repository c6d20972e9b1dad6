//! The paper's Table I: its errors by node beside ours, for each direction that its weights may have had.

use super::dataset::{Columns, Dataset, Format};
use super::format::{Span, list, percent};
use super::page::{Block, Figure, Section, details};
use super::words::{paragraph, say};
use super::{ReportError, Results, drawings};
use crate::claims::criteria::accounts_for;
use crate::experiments::table_one::{TableOne, TableOneRow, WEIGHTS_G};
use crate::settings::TRUSTED_ERROR;
use minijinja::{Value, context};

const CSV: &str = "table_one.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    // A row a weight.
    let rows = study.tables_one.iter().flat_map(|table| table.rows.iter().map(move |row| (table, row)));
    let rows = rows.flat_map(|(table, row)| (0..row.errors.len().min(WEIGHTS_G.len())).map(move |i| (table, row, i)));
    let weights = Columns::<(&TableOne, &TableOneRow, usize)>::new()
        .file("angle_deg", |(table, ..)| table.angle_deg)
        .file("node", |(_, row, _)| row.node)
        .file("weight_g", |(.., weight)| WEIGHTS_G[*weight])
        .file("error", |(_, row, weight)| row.errors[*weight])
        .file("mean_error", |(_, row, _)| row.mean_error)
        .file("paper_mean_error", |(_, row, _)| row.paper_mean_error)
        .file("modulus_factor", |(table, ..)| table.modulus_factor);
    let by_node = Dataset::records(CSV, &study.tables_one).summary_alone();
    vec![by_node, Dataset::new(CSV, &weights, rows).csv_alone()]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let tables = &study.tables_one;
    let Some(first) = tables.first() else { return Ok(None) };
    let Some(factors) = Span::of(tables.iter().map(|table| table.modulus_factor)) else { return Ok(None) };
    let columns = Columns::<usize>::new()
        .page("node", Format::Plain, |i| first.rows[*i].node)
        .page("paper", Format::Error, |i| first.rows[*i].paper_mean_error)
        .each(tables, |columns, table| {
            let heading = format!("ours, {} deg", table.angle_deg);
            columns.page(heading, Format::Error, |i| table.rows[*i].mean_error)
        });
    let blocks = vec![
        paragraph("table_one.about", context! { factors => factors.ends() })?,
        Block::Figure(Figure::wide(
            drawings::table_one(tables)?,
            "Mean error over six weights: measured in the paper, and by geometric nonlinearity alone.",
            CSV,
        )),
        details(
            "Every direction",
            vec![Block::Table(columns.table("Mean error by loaded node", CSV, 0..first.rows.len()))],
        ),
    ];
    Ok(Some(
        Section::new("table-one", "The paper's Table I", blocks).saying(say("table_one.says", Some(in_words(first)))?),
    ))
}

/// How much of the paper's large errors geometric nonlinearity gives.
fn in_words(table: &TableOne) -> Value {
    let large = table.rows.iter().filter(|row| row.paper_mean_error > TRUSTED_ERROR);
    let (most, less): (Vec<_>, Vec<_>) = large.partition(|row| accounts_for(&[(row.mean_error, row.paper_mean_error)]));
    let [most, less] = [most, less].map(|rows| {
        let rows = rows.iter().map(|row| (row.node, percent(row.paper_mean_error), percent(row.mean_error)));
        list(rows.map(|(node, paper, ours)| format!("node {node} (paper {paper}, ours {ours})")), ", ")
    });
    context! { most, less }
}
