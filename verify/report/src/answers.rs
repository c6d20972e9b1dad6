//! First screen of the report: questions of a gripper builder, each answered in one line from the results.

mod in_full;

pub(super) use in_full::answers;

use super::format::{capitalised, list, percent, percent_two_digits};
use super::trust::{SOFTER, Situation, situations};
use super::{changes, checks, measured};
use crate::prelude::*;
use finray_model::finger::FingerDescription;
use finray_studies::check::Kind;
use finray_studies::experiments::coverage::CoverageRow;
use finray_studies::sampling::situation::{ContactKnowledge, HiddenMarkers};

/// The first answer: the trusted share of the contact of which least is known, and the meaning, mean error and limit of this share.
pub(super) fn headline(study: &Study) -> [String; 2] {
    let situations = situations(study);
    let Some(first) = situations.first() else { return ["-".to_owned(), "no force was mapped.".to_owned()] };
    let share = first.trust().share().map_or_else(|| "-".to_owned(), percent);
    let cause =
        first.weighed(study).map_or_else(String::new, |weighed| format!(" {}.", capitalised(&weighed.to_string())));
    let error = first.map.summary(None).mean_error.map(|error| format!(" Mean error of answers: {}", percent(error)));
    let limit = first.limit(study).map(|limit| format!("limited by {limit}"));
    let last = match (error, limit) {
        (Some(error), Some(limit)) => format!("{error}; {limit}."),
        (Some(only), None) => format!("{only}."),
        (None, limit) => {
            format!(" No force is answered{}.", limit.map_or_else(String::new, |limit| format!(", {limit}")))
        }
    };
    let means = format!(
        "of positions and directions trusted, {}: mean error within {} for {} N.{cause}{last}",
        first.name,
        percent(TRUSTED_ERROR),
        list(study.forces.of_maps_n(), ", ")
    );
    [share, means]
}

/// The verdict in a few lines: how the share grows with knowledge, what would help, coverage of intervals, checks, and real images.
pub(super) fn verdict(study: &Study) -> Vec<[String; 2]> {
    let situations = situations(study);
    given([
        ("With more known", known_more(&situations)),
        ("What to change", changes::most(study)),
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

/// Trusted shares with all markers visible on the modelled finger, by what more is known than in the first situation.
fn known_more(situations: &[Situation]) -> Option<String> {
    let share = |of: &Situation| Some(format!("{} {}", of.name, percent(of.trust().share()?)));
    let is_more = |of: &&Situation| {
        let knowledge = of.map.situation;
        let is_less = matches!(knowledge.contact, ContactKnowledge::Misjudged | ContactKnowledge::Nothing);
        knowledge.hidden == HiddenMarkers::None && !is_less && of.name != SOFTER
    };
    let shares: Vec<String> = situations.iter().skip(1).filter(is_more).filter_map(share).collect();
    (!shares.is_empty()).then(|| format!("{}.", capitalised(&list(shares, "; "))))
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
    Some(format!("Unwarned 95 % intervals hold the force in {known}{others}."))
}

/// Number of passed checks against other programs.
fn checked(study: &Study) -> Option<String> {
    let counts = checks::counted(study).into_iter().find(|tally| tally.kind == Kind::External)?;
    Some(format!("{} of {} against other programs pass.", counts.passed, counts.all))
}

/// Results of measured images of a real finger, or the statement that there are none.
fn reality(study: &Study) -> String {
    let Some(measured::Outcome { images, known, error, within, forces, .. }) =
        study.measured.as_ref().and_then(measured::outcome)
    else {
        let noise = (study.noise_mm > 0.0).then(|| format!("camera noise {} mm", study.noise_mm));
        let stiffness = study.stiffness_error;
        let stiffness = (stiffness.share() > 0.0).then(|| format!("stiffness error {stiffness}"));
        let assumed: Vec<String> = noise.into_iter().chain(stiffness).collect();
        return match assumed.is_empty() {
            true => "Simulation only.".to_owned(),
            false => format!("Simulation only. {}.", capitalised(&list(assumed, "; "))),
        };
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
