//! Comparison of the estimators: accuracy, coverage, requirements and cost in one table.

use super::format::{percent, time};
use super::maps::small;
use super::recorded;
use crate::prelude::*;
use finray_studies::experiments::coverage::CoverageRow;
use finray_studies::sampling::situation::Situation;
use finray_studies::settings::CAMERA_FRAME_S;

const CSV: &str = "coverage.csv";
const ESTIMATORS_CSV: &str = "estimators.csv";
/// Text on what stated intervals include, and on when an estimator warns.
const INTERVALS: &str = "Sigma, the stated standard deviation, includes the noise and the known error of the model: linearisation, mesh, training. An \
                         estimator warns if the measurement contradicts its model (chi-squared test, one false alarm in a hundred) or if its model errs by \
                         more than the noise. If the ends are softer than modelled, intervals miss the force too often, and often without a warning, \
                         because another force would give the modelled finger the same shape.";

/// Results of one estimator on the uniform finger.
struct Row<'s> {
    estimator: EstimatorId,
    /// The trusted share of the estimator's map with known contact.
    trust: Option<TrustShare>,
    coverage: Option<&'s CoverageRow>,
    /// Recorded time to compute one force from the displacements in an image, s; only for the paper's finger.
    seconds: Option<f64>,
}

fn rows(study: &Study) -> impl Iterator<Item = Row<'_>> {
    EstimatorId::ALL.iter().map(move |&estimator| {
        // The overview of maps has the same coarse grid of cells, so overview and table state the same shares.
        let map = small(study, TruthId::Corotational, estimator, study.noise_mm > 0.0);
        let of = |row: &&CoverageRow| {
            row.truth == TruthId::Corotational && row.estimator == estimator && row.situation() == Situation::default()
        };
        Row {
            estimator,
            trust: map.map(|map| map.trust(&study.finger)),
            coverage: study.coverage.iter().find(of),
            seconds: recorded::seconds(estimator).filter(|_| study.is_paper),
        }
    })
}

fn columns<'s>() -> Columns<'s, Row<'s>> {
    let share = |row: &Row| row.trust.and_then(|trust| trust.share());
    Columns::<Row>::new()
        .file("estimator", |row| row.estimator.name())
        .file("cells", |row| row.trust.map(|trust| trust.cells))
        .file("share_trusted", share)
        .file("share_without_warning", |row| Some(row.coverage?.share_without_warning()))
        .file("covered_without_warning", |row| row.coverage?.covered_without_warning)
        .file("seconds", |row| row.seconds)
        .page("estimator", Format::Words, |row| row.estimator.label())
        .page("trusted share", Format::Percent, share)
        .page("answers without a warning", Format::Percent, |row| Some(row.coverage?.share_without_warning()))
        .page("of answers without a warning: force in the 95 % interval", Format::Percent, |row| {
            row.coverage?.covered_without_warning
        })
        .page("time per frame", Format::Plain, |row| row.seconds.map(time))
        .page("needs", Format::Words, |row| row.estimator.needs())
        .page("refuses", Format::Words, |row| row.estimator.refuses())
        .page("senses unseen contacts", Format::Words, |row| row.estimator.unseen_contacts())
}

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::new(ESTIMATORS_CSV, &columns(), rows(study)), Dataset::records(CSV, &study.coverage)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let [least_n, .., most_n] = study.forces.of_maps_n();
    let networks = match study.is_paper {
        true => {
            ". Networks sense only forces along the normal at contact nodes; forces at node 13 are sensed by the network that was trained for all \
             contact nodes"
        }
        false => "",
    };
    let caption = format!("Uniform finger, contact known, worst force of {least_n} to {most_n} N{networks}");
    let mut blocks = vec![Block::Table(columns().table(caption, ESTIMATORS_CSV, rows(study)))];
    if !study.coverage.is_empty() {
        blocks.push(details("How often stated intervals hold", intervals(study)));
    }
    Ok(Some(Section::new("estimators", "Four estimators side by side", blocks).saying(says(study))))
}

/// Sentences on the recommended estimator, and on the time per force of the fastest and the slowest estimator. `None` if the slowest estimator takes
/// at least a tenth of the time between two frames.
fn says(study: &Study) -> Option<String> {
    let times: Vec<f64> = rows(study).filter_map(|row| row.seconds).collect();
    let [fastest, slowest] = [f64::min, f64::max].map(|of| times.iter().copied().reduce(of));
    let (fastest, slowest) = (fastest?, slowest?);
    let share = slowest / CAMERA_FRAME_S;
    let (fastest, slowest, frame_ms) = (time(fastest), time(slowest), 1e3 * CAMERA_FRAME_S);
    (share < 0.1).then(|| {
        format!(
            "Choose by error and interval, not by time: sensing a force takes {fastest} to {slowest} \
                (medians), at most {} of the {frame_ms:.0} ms between two frames at 25 Hz. Finding the nodes in an \
                image takes longer.",
            percent(share)
        )
    })
}

/// Coverage of the stated intervals by true finger and estimator.
fn intervals(study: &Study) -> Vec<Block> {
    let of_samples = |row: &CoverageRow, count: usize| count as f64 / row.samples.max(1) as f64;
    let columns = Columns::<&CoverageRow>::new()
        .page("finger", Format::Words, |row| row.truth.label())
        .page("estimator", Format::Words, |row| row.estimator.label())
        .page("known and seen", Format::Words, |row| row.situation().to_string())
        .page("no warning", Format::Percent, |row| of_samples(row, row.without_warning))
        .page("covered", Format::Percent, |row| row.covered_without_warning)
        .page("warned", Format::Percent, |row| of_samples(row, row.warned))
        .page("covered", Format::Percent, |row| row.covered_with_warning)
        .page("refused", Format::Percent, |row| of_samples(row, row.refused))
        .page("samples", Format::Plain, |row| row.samples);
    let caption = "Shares of noise samples answered without and with a warning. Covered: share of these answers whose 95 % interval contains the \
                   true force";
    vec![Block::Table(columns.table(caption, CSV, &study.coverage)), text(INTERVALS)]
}
