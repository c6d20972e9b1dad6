//! First screen of the report: questions of a gripper builder, each answered in one line from the results.

mod in_full;

pub(super) use in_full::answers;

use super::format::{capitalised, list, percent, percent_two_digits};
use super::trust::{SOFTER, Situation, of_known, situations};
use super::{checks, measured};
use crate::prelude::*;
use finray_model::finger::FingerDescription;
use finray_studies::check::Kind;
use finray_studies::experiments::coverage::CoverageRow;
use finray_studies::sampling::situation::{ContactKnowledge, HiddenMarkers};

/// The verdict in a few lines: where forces can be trusted, what would help, why forces fail elsewhere, coverage of intervals, checks, and real
/// images.
pub(super) fn verdict(study: &Study) -> Vec<[String; 2]> {
    let situations = situations(study);
    given([
        ("Where", places(study, &situations)),
        ("What helps", what_helps(&situations)),
        ("Why not elsewhere", reasons(study, &situations)),
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

/// Trusted shares with all markers visible and the position unknown, on the modelled finger, by what is known of the direction; then of a known contact.
fn places(study: &Study, situations: &[Situation]) -> Option<String> {
    let [least_n, .., most_n] = study.forces.of_maps_n();
    let share = |of: &Situation| Some(format!("{} {}", of.name, percent(of.trust().share()?)));
    let is_first = |of: &&Situation| {
        let knowledge = of.map.situation;
        let is_told = matches!(knowledge.contact, ContactKnowledge::Misjudged | ContactKnowledge::Position);
        knowledge.hidden == HiddenMarkers::None && !is_told && of.name != SOFTER
    };
    let shares: Vec<String> = situations.iter().filter(is_first).filter_map(share).collect();
    (!shares.is_empty()).then(|| {
        format!(
            "Positions and directions with a mean error within {} ({least_n} to {most_n} N): {}.",
            percent(TRUSTED_ERROR),
            list(shares, "; ")
        )
    })
}

/// The knowledge that raises the share of an unknown contact most.
fn what_helps(situations: &[Situation]) -> Option<String> {
    let unknown = situations.first().filter(|of| of.map.situation.contact == ContactKnowledge::Nothing)?;
    let helps =
        |of: &&Situation| matches!(of.map.situation.contact, ContactKnowledge::Friction | ContactKnowledge::Position);
    let share = |of: &Situation| of.trust().share();
    let by_share = |a: &&Situation, b: &&Situation| share(a).unwrap_or(0.0).total_cmp(&share(b).unwrap_or(0.0));
    let best = situations.iter().filter(helps).max_by(by_share)?;
    let (from, to) = (share(unknown)?, share(best)?);
    Some(match to > from {
        true => {
            format!("{}: {} instead of {}.", capitalised(&best.name), percent(to), percent(from))
        }
        false => {
            "A less noisy camera, more markers or larger forces; neither friction nor position alone helps.".to_owned()
        }
    })
}

/// Main reasons why sensed forces fail, with a known contact and with an assumed contact.
fn reasons(study: &Study, situations: &[Situation]) -> Option<String> {
    let (failed, by_noise) = failures(of_known(study, situations)?);
    let (failed, by_model) = (failed.len(), failed.len() - by_noise);
    let known = match failed {
        0 => "Contact known: nothing fails.",
        _ if by_noise >= by_model => "Contact known: camera noise.",
        _ => "Contact known: error of the model.",
    };
    let assumed = situations.iter().find(|of| of.is_misjudged);
    let assumed = assumed.and_then(|of| of.failed_by_direction(study));
    let assumed = assumed.map(|share| {
        format!(" With a wrong contact, the main cause is its direction in {} of the failing cells.", percent(share))
    });
    Some(format!("{known}{}", assumed.unwrap_or_default()))
}

/// Coverage of the nonlinear estimator's intervals on a true finger, for what it knows of the contact, with all markers visible.
fn coverage(study: &Study, truth: TruthId, contact: ContactKnowledge) -> Option<&CoverageRow> {
    let situation = finray_studies::sampling::situation::Situation { contact, ..Default::default() };
    let is_asked = |row: &&CoverageRow| row.truth == truth && row.situation() == situation;
    study.coverage.iter().filter(is_asked).find(|row| row.estimator == EstimatorId::Nonlinear)
}

/// Coverage of intervals without a warning.
fn sureness(study: &Study) -> Option<String> {
    let of = |truth, contact| coverage(study, truth, contact)?.covered_without_warning.map(percent);
    let known = of(TruthId::Corotational, ContactKnowledge::Known)?;
    let unknown = of(TruthId::Corotational, ContactKnowledge::Nothing);
    let softer = of(TruthId::Twin, ContactKnowledge::Known);
    let others = [("contact unknown", unknown), ("softer ends", softer)];
    let others = others.into_iter().filter_map(|(name, share)| Some(format!("{name}: {}", share?)));
    let others = list(others, "; ");
    let others = if others.is_empty() { others } else { format!(" ({others})") };
    Some(format!("95 % intervals without a warning contain the force in {known}{others}."))
}

/// Number of passed checks against other programs.
fn checked(study: &Study) -> Option<String> {
    let counts = checks::counted(study).into_iter().find(|tally| tally.kind == Kind::External)?;
    Some(format!("{} of {} checks against other programs pass.", counts.passed, counts.all))
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
