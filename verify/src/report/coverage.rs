//! How sure: stated intervals against the truth, by finger and estimator.

use super::page::{Block, Cell, Column, Row, Section, Table};
use super::sections::{self, text};
use super::tables::percent;
use crate::experiments::coverage::CoverageRow;
use crate::study::Study;

pub(super) const CSV: &str = "coverage.csv";

pub(super) fn section(study: &Study) -> Option<Section> {
    let rows = &study.coverage;
    if rows.is_empty() {
        return None;
    }
    let row = |row: &CoverageRow| {
        let share = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), percent);
        let of_samples = |count: usize| percent(count as f64 / row.samples.max(1) as f64);
        let cells = [
            row.truth.clone(),
            row.estimator.clone(),
            of_samples(row.without_warning),
            share(row.covered_without_warning),
            of_samples(row.warned),
            share(row.covered_with_warning),
            of_samples(row.refused),
            row.samples.to_string(),
        ];
        Row { cells: cells.map(Cell::plain).into() }
    };
    let numbers = ["no warning", "covered", "warned", "covered", "refused", "samples"];
    let table = Table {
        caption: "Share of noise samples that are answered without and with a warning, and how many of these have the true force within 1.96 \
                  sigma (covered): one force of 0.5 to 3 N, over positions and directions, for networks and softer ends over nodes along the normal".to_owned(),
        columns: ["finger", "estimator"].map(Column::words).into_iter().chain(numbers.map(Column::numbers)).collect(),
        rows: rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    };
    let words = "A stated sigma holds what noise does and what is known of the model's own error: of linearisation (from the estimated \
                 forces), of the mesh, of the network's training. An estimator warns where the measurement contradicts its model under \
                 the stated noise (chi-squared test, one false alarm in a hundred), or where its model errs by more than the noise. 95 % \
                 is meant on the co-rotational finger. On a finger with softer ends, of which no estimator knows, \
                 intervals do not hold, and in many a sample no warning says so, as its shape is one that another force gives the finger \
                 as described: sigma says how sure a force is if the finger is what the scene says.";
    Some(sections::section("coverage", "How sure: stated intervals", vec![text(words), Block::Table(table)]))
}
