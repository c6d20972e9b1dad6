//! The first screen: what a gripper builder asks, each answered in a line from the numbers.

use super::causes;
use super::checks;
use super::format::{capitalised, list, percent, time};
use super::maps::small;
use super::page::Answer;
use super::trust::{Situation, situations};
use crate::check::Kind;
use crate::estimators::EstimatorId;
use crate::experiments::coverage::CoverageRow;
use crate::experiments::speed_error::recommendation::{LARGEST_BIAS_SIGMAS, recommended, ways};
use crate::experiments::speed_error::sensing::SENSED_N;
use crate::sampling::map::{Cell, CellState};
use crate::sampling::worst::TrustCounts;
use crate::settings::{CAMERA_FRAME_S, TRUSTED_ERROR};
use crate::study::Study;
use crate::truths::TruthId;

/// Regions of a finger of which less than this share is trusted are named.
const MOSTLY: f64 = 0.9;

/// The five answers; those that a scene gives no numbers for are left out.
pub(super) fn answers(study: &Study) -> Vec<Answer> {
    let situations = situations(study);
    let all = [
        ("Where can a force be trusted?", trusted(study, &situations)),
        ("Why not elsewhere?", why_not(study, &situations)),
        ("What should sense it?", use_what(study)),
        ("How sure is an answer?", how_sure(study)),
        ("Is the physics right?", Some(physics(study))),
    ];
    let said =
        |(question, answer): (&str, Option<String>)| Some(Answer { question: question.to_owned(), answer: answer? });
    all.into_iter().filter_map(said).collect()
}

/// What all of the page rests on.
pub(super) fn caveat(study: &Study) -> String {
    let noise = match study.noise_mm {
        0.0 => "without camera noise".to_owned(),
        noise_mm => format!("with {noise_mm} mm camera noise"),
    };
    let assumed = match study.is_paper {
        true => {
            let finger = study.finger.description();
            format!(
                " The finger's base width ({} mm) and depth ({} mm) are assumed: the paper gives them in a figure that was not at hand.",
                finger.base_width_mm, finger.depth_mm
            )
        }
        false => String::new(),
    };
    match &study.measured {
        None => {
            format!("All of this is simulation, {noise}; no measurement of a real finger stands behind it.{assumed}")
        }
        Some(_) => format!("All of this is simulation, {noise}, but for the section on measured images.{assumed}"),
    }
}

/// Shares of the cells in each situation, and the weakest regions of the first.
fn trusted(study: &Study, situations: &[Situation]) -> Option<String> {
    let [first, others @ ..] = situations else { return None };
    let share = |situation: &Situation| situation.all().share().map_or_else(|| "no part".to_owned(), percent);
    let others = others.iter().map(|other| format!("; in {} {}", share(other), other.in_words));
    Some(format!(
        "The mean error stays within {} under {} N in {} of {} positions and directions, contact and finger known{}. {}",
        percent(TRUSTED_ERROR),
        list(first.map.request.forces_n.iter(), ", "),
        share(first),
        first.all().cells,
        list(others, ""),
        weak_regions(study, first)
    ))
}

/// A part of the finger: its name, and what belongs to it, by position over the plate's length and direction in degrees.
type Region = (&'static str, fn(f64, f64) -> bool);

/// The regions in which most fails, worst first.
fn weak_regions(study: &Study, situation: &Situation) -> String {
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
    let named: Vec<String> =
        weak.iter().take(2).map(|(share, name)| format!("{name} (trusted in {})", percent(*share))).collect();
    match named.is_empty() {
        true => "No part of the known finger falls behind.".to_owned(),
        false => format!("Weakest of the known finger: {}.", list(named, ", ")),
    }
}

/// The main reason in each situation.
fn why_not(study: &Study, situations: &[Situation]) -> Option<String> {
    let known = situations.first()?;
    let failed: Vec<&Cell> = known
        .map
        .cells
        .iter()
        .filter(|cell| cell.state() == CellState::Answered && cell.is_above(TRUSTED_ERROR) == Some(true))
        .collect();
    let by_noise = failed.iter().filter(|cell| cell.spread > cell.bias.map(f64::abs)).count();
    let mut reasons = Vec::new();
    if failed.is_empty() {
        reasons.push("With all known nothing fails.".to_owned());
    } else {
        let (cause, count) = match 2 * by_noise >= failed.len() {
            true => ("camera noise outweighs the model's error", by_noise),
            false => ("the model's error outweighs camera noise", failed.len() - by_noise),
        };
        let least = known.map.request.forces_n.first().copied().unwrap_or_default();
        let small = failed.iter().filter(|cell| cell.force_n == least).count();
        reasons.push(format!(
            "All known: {cause} in {count} of the {} cases that fail ({small} of them at {least} N).",
            failed.len()
        ));
    }
    for situation in &situations[1..] {
        let failed =
            || situation.cells.iter().filter(|cell| !cell.is_trusted && cell.state != CellState::WithoutEquilibrium);
        let turned = failed().filter(|cell| cell.angle_deg != 0.0).count();
        let along = causes::largest_by_region(study, situation.map.truth, situation.contact);
        let along = along.map_or_else(String::new, |along| format!("; {along}"));
        reasons.push(format!(
            "{}: {turned} of the {} cells that fail are off the normal{along}.",
            capitalised(situation.name),
            failed().count()
        ));
    }
    Some(list(reasons, " "))
}

/// Which estimator to run.
fn use_what(study: &Study) -> Option<String> {
    let [low, high] = SENSED_N;
    let Some(way) = recommended(&study.speed_error) else {
        return (!ways(&study.speed_error).is_empty()).then(|| {
            format!(
                "No setting that was timed senses {low} to {high} N along the normal with a model error within {LARGEST_BIAS_SIGMAS} standard \
                 deviations of the noise: finer meshes than these are needed."
            )
        });
    };
    let slowest =
        [Some(way.one), way.cold].into_iter().flatten().map(|point| point.seconds_95.unwrap_or(point.seconds));
    let share = slowest.fold(0.0, f64::max) / CAMERA_FRAME_S;
    let enough = if share < 1.0 { "so a faster one gains nothing at that rate" } else { "which is too slow" };
    Some(format!(
        "The {} estimator, its model on {}: mean error {} along the normal. It takes {} a frame, 95 % of cold starts within {} of the {:.0} ms \
         between frames at 25 Hz, {enough}.{}",
        way.one.estimator.map_or(way.one.model.as_str(), |estimator| estimator.label()),
        way.one.mesh(),
        percent(way.one.error),
        time(way.one.seconds),
        percent(share),
        1e3 * CAMERA_FRAME_S,
        linear(study)
    ))
}

/// What linear sensing misses.
fn linear(study: &Study) -> String {
    let map = small(study, TruthId::Corotational, EstimatorId::LeastSquares, study.noise_mm > 0.0);
    let share = map.and_then(|map| TrustCounts::of(&map.worst()).share());
    share.map_or_else(String::new, |share| {
        format!(" Least squares: within {} in {} of the cells.", percent(TRUSTED_ERROR), percent(share))
    })
}

/// How often stated intervals hold, and where they do not.
fn how_sure(study: &Study) -> Option<String> {
    let of =
        |truth| study.coverage.iter().find(move |row| row.truth == truth && row.estimator == EstimatorId::Nonlinear);
    let known = of(TruthId::Corotational)?;
    let mut said = format!(
        "All known: the 95 % intervals of the nonlinear estimator hold the force in {} of the answers without a warning",
        known.covered_without_warning.map_or_else(|| "none".to_owned(), percent)
    );
    if let Some(covered) = known.covered_with_warning {
        said += &format!(" and {} of those with a warning", percent(covered));
    }
    said += &format!(" ({} of {} samples refused).", known.refused, known.samples);
    let silent = |row: &CoverageRow| {
        let held = percent(row.covered_without_warning?);
        let warned = row.covered_with_warning.map_or_else(String::new, |covered| {
            format!(", with one ({}) in {}", share_of(row.warned, row.samples), percent(covered))
        });
        Some(format!(
            " Softer ends: without a warning ({} of {} samples) they hold in {held}{warned}: a wrong model is not seen reliably.",
            share_of(row.without_warning, row.samples),
            row.samples
        ))
    };
    Some(said + &of(TruthId::Twin).and_then(silent).unwrap_or_default())
}

fn share_of(part: usize, whole: usize) -> String {
    percent(part as f64 / whole.max(1) as f64)
}

/// What was verified, and what was not.
fn physics(study: &Study) -> String {
    let tallies = checks::counted(study);
    let counts = tallies.map(|tally| {
        let against = match tally.kind {
            Kind::External => "against other programs",
            Kind::Analytical => "against closed forms and literature",
            Kind::Internal => "of our own",
        };
        format!("{} of {} {against}", tally.passed, tally.all)
    });
    format!(
        "Solvers and estimators pass {} checks. Whether a real finger bends as beams do is not tested here.",
        list(counts, ", ")
    )
}
