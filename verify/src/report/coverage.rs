//! How sure: stated intervals against the truth, by finger and estimator.

use super::dataset::{Columns, Dataset, Format};
use super::page::{Block, Section, text};
use super::{ReportError, Results};
use crate::experiments::coverage::CoverageRow;

const CSV: &str = "coverage.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, &study.coverage)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    if study.coverage.is_empty() {
        return Ok(None);
    }
    let of_samples = |row: &CoverageRow, count: usize| count as f64 / row.samples.max(1) as f64;
    let columns = Columns::<&CoverageRow>::new()
        .page("finger", Format::Words, |row| row.truth.label())
        .page("estimator", Format::Words, |row| row.estimator.label())
        .page("no warning", Format::Percent, |row| of_samples(row, row.without_warning))
        .page("covered", Format::Percent, |row| row.covered_without_warning)
        .page("warned", Format::Percent, |row| of_samples(row, row.warned))
        .page("covered", Format::Percent, |row| row.covered_with_warning)
        .page("refused", Format::Percent, |row| of_samples(row, row.refused))
        .page("samples", Format::Plain, |row| row.samples);
    let table = columns.table(
        "Share of noise samples that are answered without and with a warning, and how many of these have the true force within 1.96 \
         sigma (covered): one force of 0.5 to 3 N, over positions and directions, for networks and softer ends over nodes along the normal",
        CSV,
        &study.coverage,
    );
    let words = "A stated sigma holds what noise does and what is known of the model's own error: of linearisation (from the estimated \
                 forces), of the mesh, of the network's training. An estimator warns where the measurement contradicts its model under \
                 the stated noise (chi-squared test, one false alarm in a hundred), or where its model errs by more than the noise. 95 % \
                 is meant on the co-rotational finger. On a finger with softer ends, of which no estimator knows, \
                 intervals do not hold, and in many a sample no warning says so, as its shape is one that another force gives the finger \
                 as described: sigma says how sure a force is if the finger is what the scene says.";
    Ok(Some(Section::new("coverage", "How sure: stated intervals", vec![text(words), Block::Table(table)])))
}
