//! First screen of the report: questions of a gripper builder, each answered in one line from the results.

mod in_full;

pub(super) use in_full::answers;

use super::format::{list, percent, percent_two_digits};
use super::trust::{Situation, situations};
use super::{checks, measured};
use crate::prelude::*;
use finray_model::finger::FingerDescription;
use finray_studies::check::Kind;
use finray_studies::experiments::coverage::CoverageRow;
use finray_studies::experiments::direction::DirectionStudy;

/// The verdict in a few lines: where forces can be trusted, why forces fail elsewhere, how well an unknown direction is identified, coverage of
/// intervals, checks, and real images.
pub(super) fn verdict(study: &Study) -> Vec<[String; 2]> {
    let situations = situations(study);
    given([
        ("Where", places(study, &situations)),
        ("Why not elsewhere", reasons(study, &situations)),
        ("Direction uncertain", study.directions.as_ref().and_then(seeking)),
        ("How sure", sureness(study)),
        ("Checked", checked(study)),
        ("Reality", Some(reality(study))),
    ])
}

/// The questions that have an answer.
fn given<const N: usize>(all: [(&str, Option<String>); N]) -> Vec<[String; 2]> {
    let given = |(question, answer): (&str, Option<String>)| Some([question.to_owned(), answer?]);
    all.into_iter().filter_map(given).collect()
}

/// Shares of trusted cells, by situation.
fn places(study: &Study, situations: &[Situation]) -> Option<String> {
    let [known, others @ ..] = situations else { return None };
    let [least_n, .., most_n] = study.forces.of_maps_n();
    let share = |of: &Situation| Some(format!("{} {}", of.in_short, percent(of.all().share()?)));
    let shares = std::iter::once(known).chain(others).filter_map(share);
    Some(format!(
        "Positions and directions with a mean error within {} ({least_n} to {most_n} N): {}.",
        percent(TRUSTED_ERROR),
        list(shares, "; ")
    ))
}

/// Main reasons why sensed forces fail, with a known contact and with an assumed contact.
fn reasons(study: &Study, situations: &[Situation]) -> Option<String> {
    let known = situations.first()?;
    let (failed, by_noise) = failures(known);
    let (failed, by_model) = (failed.len(), failed.len() - by_noise);
    let known = match failed {
        0 => "Contact known: nothing fails.",
        _ if by_noise >= by_model => "Contact known: camera noise.",
        _ => "Contact known: error of the model.",
    };
    let assumed = situations.iter().find(|of| of.is_assumed);
    let assumed = assumed.and_then(|of| of.failed_by_direction(study));
    let assumed = assumed.map(|share| {
        format!(
            " With a wrong contact, the main cause is its direction in {} of the failing cells, and its position in the \
            others.",
            percent(share)
        )
    });
    Some(format!("{known}{}", assumed.unwrap_or_default()))
}

/// Share of the cells in which an unknown direction is identified together with the force.
fn seeking(directions: &DirectionStudy) -> Option<String> {
    let share = |force_n: f64| {
        let [identified, all] = directions.identified(force_n);
        (all > 0).then(|| format!("{} ({force_n} N)", percent(identified as f64 / all as f64)))
    };
    let shares: Vec<String> = directions.forces_n.into_iter().rev().filter_map(share).collect();
    let found = list(&shares, ", ");
    let seek = match directions.is_normal_better() {
        true => {
            format!(
                "With little friction, assume the normal. Otherwise estimate the direction, which is identifiable \
                    in {found} of the cells."
            )
        }
        false => format!(
            "Estimate the direction together with the force: the direction is identifiable in {found} of the cells."
        ),
    };
    (!shares.is_empty()).then_some(seek)
}

/// Coverage of the nonlinear estimator's intervals on a true finger.
fn coverage(study: &Study, truth: TruthId) -> Option<&CoverageRow> {
    study.coverage.iter().find(|row| row.truth == truth && row.estimator == EstimatorId::Nonlinear)
}

/// Coverage of intervals without a warning.
fn sureness(study: &Study) -> Option<String> {
    let of = |truth| coverage(study, truth)?.covered_without_warning;
    let known =
        format!("95 % intervals without a warning contain the force in {}", percent(of(TruthId::Corotational)?));
    Some(match of(TruthId::Twin) {
        Some(softer) => format!("{known}; with softer ends, in {}.", percent(softer)),
        None => format!("{known}."),
    })
}

/// Number of passed checks against other programs.
fn checked(study: &Study) -> Option<String> {
    let counts = checks::counted(study).into_iter().find(|tally| tally.kind == Kind::External)?;
    Some(format!("{} of {} solver checks against other programs pass.", counts.passed, counts.all))
}

/// Results of measured images of a real finger, or the statement that there are none.
fn reality(study: &Study) -> String {
    let Some(measured::Outcome { images, known, error, within, forces, .. }) =
        study.measured.as_ref().and_then(measured::outcome)
    else {
        return "Simulation only.".to_owned();
    };
    format!(
        "{images} images with measured forces ({known}): mean error {}, {within} of {forces} intervals contain the force. \
         All other results are simulated.",
        percent(error)
    )
}

/// The assumptions that hold for the whole page.
pub(super) fn caveat(study: &Study) -> String {
    let noise = match study.noise_mm {
        0.0 => "without camera noise".to_owned(),
        noise_mm => format!("with {noise_mm} mm camera noise"),
    };
    let reality = match study.measured.as_ref().and_then(measured::outcome) {
        None => format!("Simulation only, {noise}; no real finger was measured."),
        Some(measured::Outcome { images, known, error, within, forces, objects }) => {
            let objects = if objects.is_empty() { String::new() } else { format!(" (objects {})", objects.join(", ")) };
            let error = percent_two_digits(error);
            format!(
                "Measured: the contact force in {images} images{objects}. Sensed forces ({known}) differ from the measured force by {error} on \
                 average. {within} of {forces} 95 % intervals contain the measured force. Everything outside the section on measured images is \
                 simulation, {noise}."
            )
        }
    };
    if !study.is_paper {
        return reality;
    }
    let FingerDescription { base_width_mm, depth_mm, .. } = study.finger.description();
    format!(
        "{reality} The finger's base width ({base_width_mm} mm) and depth ({depth_mm} mm) are assumed, because the paper gives them only in a figure that \
         was not available."
    )
}

/// The answered cells of the situation's map whose error is above the trusted limit, and the number of these cells in which the spread due to noise
/// exceeds the bias.
fn failures<'s>(situation: &Situation<'s>) -> (Vec<&'s MapCell>, usize) {
    let is_wrong = |cell: &&MapCell| cell.state() == CellState::Answered && cell.is_above(TRUSTED_ERROR) == Some(true);
    let failed: Vec<&MapCell> = situation.map.cells.iter().filter(is_wrong).collect();
    let by_noise = failed.iter().filter(|cell| cell.spread > cell.bias.map(f64::abs)).count();
    (failed, by_noise)
}
