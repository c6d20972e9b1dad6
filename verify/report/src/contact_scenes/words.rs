//! Sentences on the sensing of pressed objects, and a table with one row per scene.

use super::{CSV, name_of};
use crate::format::{list, percent};
use crate::prelude::*;
use finray_studies::experiments::contact_scene::samples::NoiseSamples;
use finray_studies::experiments::contact_scene::study::{SceneStudy, StrainOfScene, StudiedStep};

/// Text on how the scenes are computed, and on how their forces are sensed.
pub(super) const ABOUT: &str = "In simulation, an object is pressed onto a finger of beams, in quasi-static equilibrium. The contact forces of \
    this finger are the true forces. The engine rapier, started near each equilibrium with a finger of rigid bodies \
    and springs, must come to rest there (page Checks). The nonlinear estimator receives the noisy \
    displacements of the key nodes and of points on both outlines. The estimator also receives which parts touch, and \
    the coefficient of friction as a bound on the angle of the force.";

/// Sentence on the errors in scenes without friction and with friction, and on the contact with the largest relative error.
pub(super) fn verdict(scenes: &[SceneStudy]) -> Option<String> {
    let of =
        |friction: bool| worst_total(scenes.iter().filter(|scene| (scene.friction > 0.0) == friction)).map(percent);
    let smooth = of(false)?;
    let rough = of(true).map(|rough| format!(", and by up to {rough} with friction (only its coefficient is known)"));
    Some(format!(
        "In simulation, without noise, the sensed total force of objects pressed onto the finger errs by up to {smooth} without friction{}.{}{}",
        rough.unwrap_or_default(),
        least_known(scenes).unwrap_or_default(),
        beyond_limits(scenes)
    ))
}

/// Sentence on the scenes in which a strain exceeds the limit of the beam model; empty without such a scene.
fn beyond_limits(scenes: &[SceneStudy]) -> String {
    let beyond = |scene: &SceneStudy| {
        let StrainOfScene { strain, limit } = scene.largest_strain.filter(|at| at.strain > at.limit)?;
        Some(format!("\"{}\" (strain {}, limit {})", scene.name, percent(strain), percent(limit)))
    };
    let beyond: Vec<String> = scenes.iter().filter_map(beyond).collect();
    match beyond.is_empty() {
        true => String::new(),
        false => format!(" Scenes that exceed the strain limit of the beam model: {}.", list(beyond, ", ")),
    }
}

/// Sentence on the contact with the largest relative error under noise among the last steps of all scenes, and on the other contacts in the same
/// step.
fn least_known(scenes: &[SceneStudy]) -> Option<String> {
    let ends = scenes.iter().filter_map(|scene| Some((scene, scene.steps.last()?)));
    let contacts = ends.flat_map(|(scene, last)| {
        let felt = last.step.contacts.iter().filter(|seen| !seen.clamped).enumerate();
        felt.filter_map(move |(which, seen)| {
            let samples = last.samples.as_ref().filter(|samples| samples.answered > 0)?;
            Some((samples.rms_error_n(which) / seen.normal_n, which, scene, seen, samples))
        })
    });
    let (_, which, scene, seen, samples) = contacts.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let contacts = samples.sensed.len() - 1;
    let [low_n, high_n] = Span::of((0..contacts).map(|which| samples.rms_error_n(which)))?.ends();
    let [error_n, total_n] = [which, contacts].map(|which| samples.rms_error_n(which));
    let (scene, name, true_n) = (&scene.name, name_of(seen), seen.normal_n);
    Some(format!(
        " Several contacts are sensed less accurately than their sum. At the end of the scene \"{scene}\", with noise, the forces of {contacts} \
         contacts err by {low_n:.2} to {high_n:.2} N each, and their total by {total_n:.2} N. The contact with the largest relative error \
         ({name}, {true_n:.2} N) errs by {error_n:.2} N."
    ))
}

/// Table with one row per scene: error of the total force, imbalance of forces, and coverage of the intervals under noise.
pub(super) fn by_scene(scenes: &[SceneStudy]) -> Table {
    type Which = fn(&NoiseSamples) -> std::ops::Range<usize>;
    let covered = move |scene: &&SceneStudy, which: Which| {
        let of_step = |step: &NoiseSamples| which(step).map(|which| step.coverage(which)).collect::<Vec<_>>();
        let span = Span::of(samples(scene).flat_map(of_step))?;
        Some(format!("{} ({})", percent(span.mean), percent(span.least)))
    };
    let contacts: Which = |step| 0..step.sensed.len() - 1;
    let total: Which = |step| step.sensed.len() - 1..step.sensed.len();
    Columns::<&SceneStudy>::new()
        .page("scene", Format::Words, |scene| scene.name.clone())
        .page("friction", Format::Plain, |scene| scene.friction)
        .page("error of total", Format::Percent, |scene| worst_total([*scene]))
        .page("largest strain", Format::Percent, |scene| scene.largest_strain.map(|at| at.strain))
        .page("imbalance", Format::Percent, |scene| {
            worst(scene.steps.iter().filter_map(|studied| studied.step.pressed.imbalance()))
        })
        .page("answered", Format::Plain, |scene| {
            let sum = |of: fn(&NoiseSamples) -> usize| samples(scene).map(of).sum::<usize>();
            format!("{} of {}", sum(|step| step.answered), sum(|step| step.taken))
        })
        .page("contact covered", Format::Plain, move |scene| covered(scene, contacts))
        .page("total covered", Format::Plain, move |scene| covered(scene, total))
        .table(
            "Values over all steps. Without noise: largest error of the total and largest imbalance of forces. With \
            noise: answered samples, and coverage of the 95 % intervals (in brackets: the lowest coverage of a step). \
            A refused sample counts as not covered",
            CSV,
            scenes,
        )
}

fn samples(scene: &SceneStudy) -> impl Iterator<Item = &NoiseSamples> {
    scene.steps.iter().filter_map(|studied| studied.samples.as_ref())
}

/// Largest relative error of the sensed total force over all steps without noise; `None` if no step was sensed.
fn worst_total<'s>(scenes: impl IntoIterator<Item = &'s SceneStudy>) -> Option<f64> {
    let steps = scenes.into_iter().flat_map(|scene| &scene.steps);
    steps.filter_map(error_without_noise).map(f64::abs).reduce(f64::max)
}

/// Relative error of the total force that was sensed in a step without noise; `None` if the step was not sensed.
pub(super) fn error_without_noise(step: &StudiedStep) -> Option<f64> {
    Some(step.clean.as_ref().ok()?.as_ref()?.total.relative_error())
}
