//! What pressing objects says of sensing: a sentence, and a row a scene.

use super::{CSV, name_of};
use crate::check::worst;
use crate::experiments::contact_scene::samples::NoiseSamples;
use crate::experiments::contact_scene::study::{SceneStudy, StudiedStep};
use crate::report::dataset::{Columns, Format};
use crate::report::format::{Span, percent};
use crate::report::page::Table;

/// Scenes without friction and with it, and the contact that is sensed worst.
pub(super) fn verdict(scenes: &[SceneStudy]) -> Option<String> {
    let of =
        |friction: bool| worst_total(scenes.iter().filter(|scene| (scene.friction > 0.0) == friction)).map(percent);
    let smooth = of(false)?;
    let rough = of(true)
        .map_or(String::new(), |rough| format!(", with friction (only its coefficient is known) by up to {rough}"));
    let crowded = least_known(scenes).map_or(String::new(), |least| {
        let [low, high] = [f64::min, f64::max].map(|of| least.rms_errors_n.iter().copied().reduce(of).unwrap_or(0.0));
        format!(
            " Several contacts are sensed less well than their sum: at the end of the scene \"{}\" {} contacts err with noise by {low:.2} to \
             {high:.2} N each ({}, which carries {:.2} N, by {:.2} N), their total by {:.2} N.",
            least.scene,
            least.rms_errors_n.len(),
            least.name,
            least.true_n,
            least.rms_error_n,
            least.total_rms_error_n
        )
    });
    Some(format!(
        "In simulation, without noise, the sensed total of objects pressed onto the lattice errs by up to {smooth}{rough}.{crowded}"
    ))
}

/// A contact of the last step of a scene under noise, beside the others.
struct LeastKnown<'s> {
    scene: &'s str,
    name: String,
    true_n: f64,
    rms_error_n: f64,
    /// Of all contacts of the step.
    rms_errors_n: Vec<f64>,
    total_rms_error_n: f64,
}

/// The contact, among the last steps of all scenes, whose error under noise is the largest share of its force.
fn least_known(scenes: &[SceneStudy]) -> Option<LeastKnown<'_>> {
    let ends = scenes.iter().filter_map(|scene| Some((scene, scene.steps.last()?)));
    let contacts = ends.flat_map(|(scene, last)| {
        let felt = last.step.contacts.iter().filter(|seen| !seen.clamped).enumerate();
        felt.filter_map(move |(which, seen)| {
            let samples = last.samples.as_ref().filter(|samples| samples.answered > 0)?;
            let total = samples.sensed.len() - 1;
            let rms_errors_n: Vec<f64> = (0..total).map(|which| samples.rms_error_n(which)).collect();
            Some(LeastKnown {
                scene: &scene.name,
                name: name_of(seen),
                true_n: seen.normal_n,
                rms_error_n: samples.rms_error_n(which),
                rms_errors_n,
                total_rms_error_n: samples.rms_error_n(total),
            })
        })
    });
    contacts.max_by(|a, b| (a.rms_error_n / a.true_n).total_cmp(&(b.rms_error_n / b.true_n)))
}

/// Scene by scene: how near the total comes, whether forces balance, and what the intervals hold under noise.
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
        .page("imbalance", Format::Percent, |scene| {
            worst(scene.steps.iter().filter_map(|studied| studied.step.pressed.imbalance()))
        })
        .page("answered", Format::Plain, |scene| {
            let sum = |of: fn(&NoiseSamples) -> usize| samples(scene).map(of).sum::<usize>();
            format!("{} of {}", sum(|step| step.answered), sum(|step| step.taken))
        })
        .page("contact covered", Format::Plain, move |scene| covered(scene, contacts))
        .page("total covered", Format::Plain, move |scene| covered(scene, total))
        .table("Over all steps: largest error of the total and imbalance of forces without noise; noise samples answered, and held by the \
                stated 95 % intervals (least; refused count as not)", CSV, scenes)
}

fn samples(scene: &SceneStudy) -> impl Iterator<Item = &NoiseSamples> {
    scene.steps.iter().filter_map(|studied| studied.samples.as_ref())
}

/// Largest error of the sensed total over all steps without noise; `None` where nothing was sensed.
fn worst_total<'s>(scenes: impl IntoIterator<Item = &'s SceneStudy>) -> Option<f64> {
    let steps = scenes.into_iter().flat_map(|scene| &scene.steps);
    steps.filter_map(error_without_noise).map(f64::abs).reduce(f64::max)
}

/// Error of a step's total without noise, as a share of it; `None` where nothing was sensed.
pub(super) fn error_without_noise(step: &StudiedStep) -> Option<f64> {
    Some(step.clean.as_ref().ok()?.as_ref()?.total.relative_error())
}
