//! What pressing objects says of sensing: a sentence, and a row a scene.

use super::{CSV, name_of};
use crate::check::worst;
use crate::experiments::contact_scene::samples::NoiseSamples;
use crate::experiments::contact_scene::study::SceneStudy;
use crate::report::dataset::{Columns, Format};
use crate::report::format::{Span, percent};
use crate::report::page::Table;
use crate::settings::GROSS_ERROR;

/// Scenes without friction and with it, and the contact that is sensed worst.
pub(super) fn verdict(scenes: &[SceneStudy]) -> Option<String> {
    let of =
        |friction: bool| worst_total(scenes.iter().filter(|scene| (scene.friction > 0.0) == friction)).map(percent);
    let smooth = of(false)?;
    let rough = of(true)
        .map_or(String::new(), |rough| format!(", with friction (only its coefficient is known) by up to {rough}"));
    let smallest = least_known(scenes).map_or(String::new(), |least| {
        let head = match least.rms_error_n > GROSS_ERROR * least.true_n {
            true => "Small contacts are sensed badly",
            false => "Single contacts are sensed worse",
        };
        format!(
            " {head}: {} carries {:.2} N and errs with noise by about {:.2} N.",
            least.name, least.true_n, least.rms_error_n
        )
    });
    Some(format!(
        "In simulation, without noise, the sensed total of objects pressed onto the lattice errs by up to {smooth}{rough}.{smallest}"
    ))
}

/// A contact of the last step of a scene under noise.
struct LeastKnown {
    name: String,
    true_n: f64,
    rms_error_n: f64,
}

/// The contact, among the last steps of all scenes, whose error under noise is the largest share of its force.
fn least_known(scenes: &[SceneStudy]) -> Option<LeastKnown> {
    let ends = scenes.iter().filter_map(|scene| Some((scene, scene.steps.last()?)));
    let contacts = ends.flat_map(|(scene, last)| {
        let felt = last.step.contacts.iter().filter(|seen| !seen.clamped).enumerate();
        felt.filter_map(move |(which, seen)| {
            let samples = last.samples.as_ref().filter(|samples| samples.answered > 0)?;
            let name = format!("{} in the scene \"{}\"", name_of(seen), scene.name);
            Some(LeastKnown { name, true_n: seen.normal_n, rms_error_n: samples.rms_error_n(which) })
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
    let totals = steps.filter_map(|step| Some(step.clean.as_ref().ok()?.as_ref()?.total.relative_error().abs()));
    totals.reduce(f64::max)
}
