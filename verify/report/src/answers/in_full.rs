//! The reader's five questions with their full answers.

use super::{coverage, given};
use crate::format::{capitalised, list, percent};
use crate::maps::small;
use crate::prelude::*;
use crate::trust::{Situation, of_known, situations};
use crate::{causes, checks, shapes};
use finray_studies::check::Tally;
use finray_studies::experiments::coverage::CoverageRow;
use finray_studies::sampling::situation::ContactKnowledge;
use finray_studies::statistics::mean;

/// A region of the finger is named as weak if its share of trusted cells (positions and directions) is below this.
const MOSTLY: f64 = 0.9;

/// The five answers; an answer is left out if the scene has no numbers for it.
pub(crate) fn answers(study: &Study) -> Vec<[String; 2]> {
    let situations = situations(study);
    given([
        ("Where can a force be trusted?", trusted(study, &situations)),
        ("Why not elsewhere?", why_not(study, &situations)),
        ("What should sense it?", use_what(study)),
        ("How sure is an answer?", how_sure(study)),
        ("Is the physics right?", Some(physics(study))),
    ])
}

/// Text that states the trusted share in each situation, and which regions are weakest with a known contact.
fn trusted(study: &Study, situations: &[Situation]) -> Option<String> {
    let known = of_known(study, situations)?;
    let share = |of: &Situation| Some(format!("{} ({})", percent(of.trust().share()?), of.name));
    let unknown =
        situations.first().and_then(|of| Some(format!(" {}: {}.", capitalised(&of.name), of.weighed(study)?)));
    let unknown = unknown.unwrap_or_default();
    let shares: Vec<String> = situations.iter().filter_map(share).collect();
    let missing = match known.trust() {
        TrustShare { without_equilibrium: 0, .. } => String::new(),
        TrustShare { without_equilibrium, cells, .. } => format!(
            " With the contact known, the finger has no equilibrium under at least one of these forces in {without_equilibrium} of {cells} cells, which \
             count in no share."
        ),
    };
    let weakest = match &weak_regions(study, known)[..] {
        [] => "With the contact known, no region is clearly weaker than the others.".to_owned(),
        weak => format!("Weakest regions with the contact known: {}.", weak.join(", ")),
    };
    Some(format!(
        "The mean error stays within {} for forces of {} N in these shares of the positions and of the directions that friction allows: \
         {}.{unknown}{missing} {weakest}",
        percent(TRUSTED_ERROR),
        list(&known.map.request.forces_n, ", "),
        list(shares, "; "),
    ))
}

/// A region of the finger: its name, and whether it contains a position (share of the plate length) and direction (degrees).
type Region = (&'static str, fn(f64, f64) -> bool);

/// The two regions with the smallest trusted shares, smallest first, each with its share.
fn weak_regions(study: &Study, situation: &Situation) -> Vec<String> {
    const REGIONS: [Region; 5] = [
        ("the tenth of the plate next to the base", |s, _| s < 0.1),
        ("the tenth of the plate next to the tip", |s, _| s > 0.9),
        ("forces turned more than 20 deg towards the base", |_, angle| angle < -20.0),
        ("forces turned more than 20 deg towards the tip", |_, angle| angle > 20.0),
        ("the rest", |s, angle| (0.1..=0.9).contains(&s) && angle.abs() <= 20.0),
    ];
    let share = |(name, holds): &Region| Some((situation.trust_in(&study.finger, holds).share()?, *name));
    let mut weak: Vec<(f64, &str)> = REGIONS.iter().filter_map(share).filter(|(share, _)| *share < MOSTLY).collect();
    weak.sort_by(|a, b| a.0.total_cmp(&b.0));
    weak.into_iter().take(2).map(|(share, name)| format!("{name} (trusted in {})", percent(share))).collect()
}

/// The main cause of the failing cells with a known contact, and in each other situation.
fn why_not(study: &Study, situations: &[Situation]) -> Option<String> {
    let known = of_known(study, situations)?;
    let others = situations.iter().filter(|other| other.name != known.name);
    let others = others.filter_map(|situation| failing(study, situation));
    let by_direction = situations.iter().find(|of| of.is_misjudged).and_then(|of| of.failed_by_direction(study));
    let by_direction = by_direction.map_or_else(String::new, |share| {
        format!(" With a wrong contact, the main cause is its direction in {} of the failing cells.", percent(share))
    });
    Some(format!("{}{}{by_direction}", failing_if_known(known), list(others, "")))
}

/// Sentence that says whether noise or the model's error dominates in the failing cells, with contact and finger known.
fn failing_if_known(known: &Situation) -> String {
    let (failed, by_noise) = known.failures();
    if failed.is_empty() {
        return "With contact and finger known, no sensed force fails.".to_owned();
    }
    let least_n = known.map.request.forces_n.first().copied().unwrap_or_default();
    let small = failed.iter().filter(|cell| cell.force_n == least_n).count();
    let (failed, by_model) = (failed.len(), failed.len() - by_noise);
    let (cause, most) = match by_noise >= by_model {
        true => ("camera noise outweighs the model's error", by_noise),
        false => ("the model's error outweighs camera noise", by_model),
    };
    format!(
        "With contact and finger known, {cause} in {most} of the {failed} sensed forces that fail; {small} of these {failed} are \
         forces of {least_n} N."
    )
}

/// Shares of failing cells for forces off the normal and for forces along the normal, and the main causes of failure along the normal. `None` if no
/// cell off the normal, or no cell along the normal, has an equilibrium.
fn failing(study: &Study, situation: &Situation) -> Option<String> {
    let failed = |is_turned: bool| {
        let trust = situation.trust_in(&study.finger, |_, angle_deg| (angle_deg != 0.0) == is_turned);
        trust.share().map(|trusted| percent(1.0 - trusted))
    };
    let (name, turned, along) = (capitalised(&situation.name), failed(true)?, failed(false)?);
    let why = if situation.is_misjudged { format!("; {}", causes::largest_by_region(study)) } else { String::new() };
    Some(format!(
        " {name}: {turned} of the forces off the normal fail, and {along} of the forces along the normal{why}."
    ))
}

/// The mean error of the nonlinear estimator along the normal, and the trusted cells of least squares.
fn use_what(study: &Study) -> Option<String> {
    let map = |estimator| small(study, TruthId::Corotational, estimator, study.noise_mm > 0.0);
    let nonlinear = map(EstimatorId::Nonlinear)?;
    let along = nonlinear.cells.iter().filter(|cell| cell.angle_deg == 0.0);
    let error = percent(mean(along.filter_map(|cell| cell.mean_error))?);
    let linear = map(EstimatorId::LeastSquares).and_then(|map| map.trust(&study.finger).share());
    let linear = linear.map_or_else(String::new, |linear| {
        let [trusted, linear] = [TRUSTED_ERROR, linear].map(percent);
        format!(" Least squares: mean error within {trusted} in a share of {linear}.")
    });
    let forces_n = list(&nonlinear.request.forces_n, ", ");
    Some(format!(
        "The nonlinear estimator has a mean error of {error} for forces of {forces_n} N along the normal.{linear}"
    ))
}

/// Coverage of the stated 95 % intervals, on the uniform finger and on the finger with softer ends.
fn how_sure(study: &Study) -> Option<String> {
    let known = coverage(study, TruthId::Corotational, ContactKnowledge::Known)?;
    let CoverageRow { refused, samples, covered_without_warning, covered_with_warning, .. } = known;
    let without = covered_without_warning.map_or_else(|| "none".to_owned(), percent);
    let with =
        covered_with_warning.map(|covered| format!(" and in {} of the answers with a warning", percent(covered)));
    let softer = coverage(study, TruthId::Twin, ContactKnowledge::Known).and_then(how_sure_if_softer);
    let unknown = coverage(study, TruthId::Corotational, ContactKnowledge::Nothing).and_then(how_sure_if_unknown);
    Some(format!(
        "With contact and finger known, the 95 % intervals of the nonlinear estimator contain the force in \
            {without} of the answers without a warning{} ({refused} of {samples} samples refused).{}{}",
        with.unwrap_or_default(),
        unknown.unwrap_or_default(),
        softer.unwrap_or_default()
    ))
}

/// Coverage of the intervals with an unknown contact.
fn how_sure_if_unknown(unknown: &CoverageRow) -> Option<String> {
    let CoverageRow { refused, warned, samples, covered_without_warning, .. } = unknown;
    let covered = percent((*covered_without_warning)?);
    Some(format!(
        " With an unknown contact, they contain it in {covered} ({refused} of {samples} samples refused, {warned} answered with a warning)."
    ))
}

/// Coverage of the intervals on the finger with softer ends.
fn how_sure_if_softer(softer: &CoverageRow) -> Option<String> {
    let (share, samples) = (percent(softer.share_without_warning()), softer.samples);
    let covered = percent(softer.covered_without_warning?);
    let warned = percent(softer.warned as f64 / samples.max(1) as f64);
    let with = softer.covered_with_warning;
    let with = with.map_or_else(String::new, |with| {
        format!(", and the intervals of answers with a warning ({warned} of the samples) in {}", percent(with))
    });
    Some(format!(
        " If the ends are softer than modelled, the intervals of answers without a warning ({share} of {samples} samples) contain the force in {covered} \
         of the cases{with}. Warnings therefore do not detect a wrong model reliably."
    ))
}

/// Numbers of passed checks, and the limits of the beam model that the drawn shapes exceed.
fn physics(study: &Study) -> String {
    let passed = checks::counted(study).into_iter();
    let passed = passed.map(|Tally { kind, passed, all }| format!("{passed} of {all} {}", kind.in_words()));
    let limits = shapes::beyond_limits(study);
    let beyond = match limits.is_empty() {
        true => String::new(),
        false => format!(
            " At {} N along the normal the beam model is beyond its limits: {}. The errors on this page do not include these effects.",
            study.forces.drawn_n(),
            limits.join("; ")
        ),
    };
    let tested = match study.measured {
        Some(_) => "tested only by the section on measured images",
        None => "not tested here",
    };
    format!(
        "Solvers and estimators pass {} checks. {}{beyond} Whether a real finger bends as beams do is {tested}.",
        list(passed, ", "),
        checks::beam_theory_in_short(study)
    )
}
