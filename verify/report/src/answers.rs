//! First screen of the report: five questions of a gripper builder, each answered in one line from the results.

use super::format::{capitalised, list, percent};
use super::maps::small;
use super::page::Answer;
use super::trust::{Situation, situations};
use super::{causes, checks, measured, shapes};
use crate::prelude::*;
use finray_studies::check::Against;
use finray_studies::experiments::causes::ContactKnowledge;
use finray_studies::experiments::direction::DirectionStudy;
use finray_studies::experiments::speed_error::recommendation::{LARGEST_BIAS_SIGMAS, recommended, ways};
use finray_studies::settings::{CAMERA_FRAME_S, TWO_FORCES_N};
use minijinja::value::Serde;

/// A region of the finger is named as weak if its share of trusted cells (positions and directions) is below this.
const MOSTLY: f64 = 0.9;

/// The five answers; an answer is left out if the scene has no numbers for it.
pub(super) fn answers(study: &Study) -> Result<Vec<Answer>, ReportError> {
    let situations = situations(study);
    let all = [
        ("Where can a force be trusted?", say("answers.trusted", trusted(study, &situations))?),
        ("Why not elsewhere?", say("answers.why_not", why_not(study, &situations))?),
        ("What should sense it?", use_what(study)?),
        ("How sure is an answer?", say("answers.how_sure", how_sure(study))?),
        ("Is the physics right?", say("answers.physics", Some(physics(study)))?),
    ];
    let said =
        |(question, answer): (&str, Option<String>)| Some(Answer { question: question.to_owned(), answer: answer? });
    Ok(all.into_iter().filter_map(said).collect())
}

/// The verdict in a few lines: where, why not elsewhere, what to use then, how sure, and what of it is real.
pub(super) fn verdict(study: &Study) -> Vec<Answer> {
    let situations = situations(study);
    let lines = [
        ("Where", places(study, &situations)),
        ("Why not elsewhere", reasons(study, &situations)),
        ("Direction unknown", study.directions.as_ref().and_then(seeking)),
        ("How sure", sureness(study)),
        ("Checked", checked(study)),
        ("Real or simulated", Some(reality(study))),
    ];
    let line =
        |(question, answer): (&str, Option<String>)| Some(Answer { question: question.to_owned(), answer: answer? });
    lines.into_iter().filter_map(line).collect()
}

/// Shares of trusted cells, by situation.
fn places(study: &Study, situations: &[Situation]) -> Option<String> {
    let [known, others @ ..] = situations else { return None };
    let [least_n, .., most_n] = study.forces.of_maps_n();
    let other = |of: &Situation| Some(format!("; {}: {}", of.in_short, percent(of.all().share()?)));
    Some(format!(
        "Error within {} ({least_n} to {most_n} N) at {} of places and directions{}.",
        percent(TRUSTED_ERROR),
        percent(known.all().share()?),
        list(others.iter().filter_map(other), "")
    ))
}

/// Main reasons of failures, with the contact known and assumed.
fn reasons(study: &Study, situations: &[Situation]) -> Option<String> {
    let known = situations.first()?;
    let Failures { failed, by_noise } = failures(known);
    let (failed, by_model) = (failed.len(), failed.len() - by_noise);
    let known = match failed {
        0 => "Contact known: nothing fails.",
        _ if by_noise >= by_model => "Contact known: camera noise.",
        _ => "Contact known: error of the model.",
    };
    let assumed = situations.iter().find(|of| of.contact == ContactKnowledge::Assumed);
    let assumed = assumed.and_then(|of| causes::in_short(study, of.map.truth, of.contact));
    Some(assumed.map_or(known.to_owned(), |assumed| format!("{known} Contact assumed: {assumed}.")))
}

/// How often an unknown direction is found with the force.
fn seeking(directions: &DirectionStudy) -> Option<String> {
    let share = |force_n: f64| {
        let [identified, all] = directions.identified(force_n);
        (all > 0).then(|| format!("{} ({force_n} N)", percent(identified as f64 / all as f64)))
    };
    let shares: Vec<String> = directions.forces_n.into_iter().rev().filter_map(share).collect();
    (!shares.is_empty()).then(|| format!("Found with the force at {} of places and directions.", list(shares, ", ")))
}

/// Coverage of intervals without a warning.
fn sureness(study: &Study) -> Option<String> {
    let of = |truth| {
        let row = study.coverage.iter().find(|row| row.truth == truth && row.estimator == EstimatorId::Nonlinear)?;
        row.covered_without_warning
    };
    let known =
        format!("Without a warning, {} of the 95 % intervals contain the force", percent(of(TruthId::Corotational)?));
    Some(match of(TruthId::Twin) {
        Some(softer) => format!("{known}; with softer base and tip {}.", percent(softer)),
        None => format!("{known}."),
    })
}

/// Checks against other programs.
fn checked(study: &Study) -> Option<String> {
    let counts = checks::counted(study).into_iter().find(|tally| tally.against == Against::OtherPrograms)?;
    Some(format!("{} of {} checks against other programs pass.", counts.passed, counts.all))
}

/// What was measured on a real finger.
fn reality(study: &Study) -> String {
    let Some(measured::Outcome { images, known, error, within, forces, .. }) =
        study.measured.as_ref().and_then(measured::outcome)
    else {
        return "Simulation: no real finger was measured.".to_owned();
    };
    format!(
        "{images} images with measured forces ({known}): mean error {}, {within} of {forces} intervals hold. All else is simulation.",
        percent(error)
    )
}

/// The assumptions that hold for the whole page.
pub(super) fn caveat(study: &Study) -> Result<String, ReportError> {
    let finger = study.finger.description();
    let numbers = context! {
        noise_mm => study.noise_mm, measured => study.measured.as_ref().and_then(measured::outcome).map(Serde), is_paper => study.is_paper,
        base_width_mm => finger.base_width_mm, depth_mm => finger.depth_mm,
    };
    Ok(say("answers.caveat", Some(numbers))?.unwrap_or_default())
}

/// Numbers of trusted cells and of cells with an equilibrium in each situation, and the weakest regions in the first situation.
fn trusted(study: &Study, situations: &[Situation]) -> Option<Value> {
    let [first, others @ ..] = situations else { return None };
    let counts = |situation: &Situation| {
        let counts = situation.all();
        context! { trusted => counts.trusted, carried => counts.carried(), share => counts.share() }
    };
    let other = |other: &Situation| context! { in_words => other.in_words.as_str(), ..counts(other) };
    Some(context! {
        within => TRUSTED_ERROR,
        forces_n => first.map.request.forces_n.clone(),
        not_carried => first.all().without_equilibrium,
        known => counts(first),
        others => others.iter().map(other).collect::<Vec<_>>(),
        weak => weak_regions(study, first),
    })
}

/// A region of the finger: its name, and whether it contains a position (share of the plate length) and direction (degrees).
type Region = (&'static str, fn(f64, f64) -> bool);

/// The two regions with the smallest trusted shares, smallest first.
fn weak_regions(study: &Study, situation: &Situation) -> Vec<Value> {
    const REGIONS: [Region; 5] = [
        ("the tenth of the plate next to the base", |s, _| s < 0.1),
        ("the tenth next to the tip", |s, _| s > 0.9),
        ("forces turned more than 45 deg to the base", |_, angle| angle < -45.0),
        ("forces turned more than 45 deg to the tip", |_, angle| angle > 45.0),
        ("the rest", |s, angle| (0.1..=0.9).contains(&s) && angle.abs() <= 45.0),
    ];
    let share = |(name, holds): &Region| Some((situation.counts(&study.finger, holds).share()?, *name));
    let mut weak: Vec<(f64, &str)> = REGIONS.iter().filter_map(share).filter(|(share, _)| *share < MOSTLY).collect();
    weak.sort_by(|a, b| a.0.total_cmp(&b.0));
    weak.into_iter().take(2).map(|(share, name)| context! { share, name }).collect()
}

/// Cells of a map that answer with an error above the trusted one.
struct Failures<'s> {
    failed: Vec<&'s MapCell>,
    /// How many of them fail by camera noise rather than by a wrong model.
    by_noise: usize,
}

fn failures<'s>(situation: &Situation<'s>) -> Failures<'s> {
    let is_wrong = |cell: &&MapCell| cell.state() == CellState::Answered && cell.is_above(TRUSTED_ERROR) == Some(true);
    let failed: Vec<&MapCell> = situation.map.cells.iter().filter(is_wrong).collect();
    let by_noise = failed.iter().filter(|cell| cell.spread > cell.bias.map(f64::abs)).count();
    Failures { failed, by_noise }
}

/// The main cause of the failing cells in each situation.
fn why_not(study: &Study, situations: &[Situation]) -> Option<Value> {
    let [known, others @ ..] = situations else { return None };
    let Failures { failed, by_noise } = failures(known);
    let least_n = known.map.request.forces_n.first().copied().unwrap_or_default();
    let other = |situation: &Situation| {
        let failed = |is_turned: bool| {
            let counts = situation.counts(&study.finger, |_, angle_deg| (angle_deg != 0.0) == is_turned);
            counts.share().map(|trusted| 1.0 - trusted)
        };
        context! {
            name => capitalised(situation.name),
            failed_turned => failed(true),
            failed_along => failed(false),
            along => causes::largest_by_region(study, situation.map.truth, situation.contact),
        }
    };
    Some(context! {
        failed => failed.len(),
        by_noise => 2 * by_noise >= failed.len(),
        most => by_noise.max(failed.len() - by_noise),
        small => failed.iter().filter(|cell| cell.force_n == least_n).count(),
        least_n,
        situations => others.iter().map(other).collect::<Vec<_>>(),
    })
}

/// The recommended estimator, with its mean error and its time.
fn use_what(study: &Study) -> Result<Option<String>, ReportError> {
    let Some(way) = recommended(&study.speed_error) else {
        let numbers =
            context! { forces_n => study.checked_forces().scaled(TWO_FORCES_N), sigmas => LARGEST_BIAS_SIGMAS };
        return say("answers.no_setting", (!ways(&study.speed_error).is_empty()).then_some(numbers));
    };
    // The time of a first answer, without a previous answer to start from, counts if it was measured separately.
    let slowest = way.cold.unwrap_or(way.one);
    let numbers = context! {
        estimator => way.one.estimator.map_or(way.one.model.as_str(), |estimator| estimator.label()),
        mesh => way.one.mesh(),
        error => way.one.error,
        seconds => way.one.seconds,
        is_warm => way.cold.is_some(),
        within_seconds => slowest.seconds_95,
        is_fast => slowest.seconds_95.unwrap_or(slowest.seconds) < CAMERA_FRAME_S,
        frame_ms => 1e3 * CAMERA_FRAME_S,
        trusted => TRUSTED_ERROR,
        linear => linear(study),
    };
    say("answers.setting", Some(numbers))
}

/// Share of the cells in which least squares is trusted.
fn linear(study: &Study) -> Option<f64> {
    let map = small(study, TruthId::Corotational, EstimatorId::LeastSquares, study.noise_mm > 0.0)?;
    TrustCounts::of(&map.worst()).share()
}

/// Coverage of the stated 95 % intervals, on the uniform finger and on the finger with softer ends.
fn how_sure(study: &Study) -> Option<Value> {
    let of = |truth| {
        let row = study.coverage.iter().find(|row| row.truth == truth && row.estimator == EstimatorId::Nonlinear)?;
        let share = |part: usize| part as f64 / row.samples.max(1) as f64;
        let shares = context! { share_without => share(row.without_warning), share_warned => share(row.warned) };
        Some(context! { ..shares, ..Value::from(Serde(row)) })
    };
    Some(context! { known => of(TruthId::Corotational)?, softer => of(TruthId::Twin) })
}

/// Numbers of passed checks, and the limits of the beam model that the drawn shapes exceed.
fn physics(study: &Study) -> Value {
    let counts = checks::counted(study).into_iter();
    let counts =
        counts.map(|tally| context! { passed => tally.passed, all => tally.all, against => tally.against.in_words() });
    let limits = shapes::beyond_limits(study);
    let is_measured = study.measured.is_some();
    context! { kinds => counts.collect::<Vec<_>>(), limits, force_n => study.forces.drawn_n(), is_measured }
}
