//! The paper's Table I: its errors by node beside ours, for each direction that its weights may have had.

use super::dataset::{Columns, Dataset, Format};
use super::format::{list, percent};
use super::page::{Block, Figure, Section, text};
use super::{ReportError, Results, drawings};
use crate::claims::criteria::accounts_for;
use crate::experiments::table_one::{TableOne, TableOneRow, WEIGHTS_G};
use crate::settings::TRUSTED_ERROR;

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
    let factors = tables.iter().map(|table| format!("{:.4} at {} deg", table.modulus_factor, table.angle_deg));
    let columns = Columns::<usize>::new()
        .page("node", Format::Plain, |i| first.rows[*i].node)
        .page("paper", Format::Error, |i| first.rows[*i].paper_mean_error)
        .each(tables, |columns, table| {
            let heading = format!("ours, {} deg", table.angle_deg);
            columns.page(heading, Format::Error, |i| table.rows[*i].mean_error)
        });
    let blocks = vec![
        text(format!(
            "The paper hangs weights of 50 to 300 g (g = 9.80665 m/s^2) on single nodes and senses them with the linear model, \
             whose Young's modulus is calibrated first on nodes 17, 19 and 21 (eq. (11)). Here the true finger is the \
             co-rotational finger without noise. The paper says that the weights pull vertically, not how the finger lies: \
             several directions are assumed (10.9 deg is vertical for a level finger axis). Calibrated modulus over the true \
             one: {}.",
            list(factors, ", ")
        )),
        Block::Figure(Figure {
            svg: drawings::table_one(tables)?,
            caption: "Mean error at six nodes: the paper's measurement and what geometric nonlinearity alone would cause.".to_owned(),
            csv: Some(CSV.to_owned()),
            wide: true,
        }),
        Block::Table(columns.table(
            "Mean error of the sensed force over six weights (50 to 300 g) by loaded node; grey above 10 %, dark above 25 %, as in the \
             paper's Table I",
            CSV,
            0..first.rows.len(),
        )),
    ];
    Ok(Some(Section::new("table-one", "The paper's Table I", blocks).saying([in_words(first)])))
}

/// How much of the paper's large errors geometric nonlinearity gives.
fn in_words(table: &TableOne) -> String {
    let large = table.rows.iter().filter(|row| row.paper_mean_error > TRUSTED_ERROR);
    let (most, less): (Vec<_>, Vec<_>) = large.partition(|row| accounts_for(&[(row.mean_error, row.paper_mean_error)]));
    let in_words = |row: &&TableOneRow| {
        format!("node {} (paper {}, ours {})", row.node, percent(row.paper_mean_error), percent(row.mean_error))
    };
    let [most, less] = [most, less].map(|rows| list(rows.iter().map(in_words), ", "));
    let head = "In simulation, geometric nonlinearity alone gives";
    match (most.as_str(), less.as_str()) {
        ("", less) => format!(
            "{head} less than half of the paper's large errors in Table I: {less}. What else causes them is not found out here."
        ),
        (most, "") => format!("{head} most of the paper's large errors in Table I: {most}."),
        (most, less) => {
            format!("{head} most of the paper's large errors in Table I at {most}, less than half at {less}.")
        }
    }
}
