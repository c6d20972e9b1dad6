//! What pressing objects says of sensing, in sentences.

use super::name_of;
use crate::check::worst;
use crate::experiments::contact_scene::samples::NoiseSamples;
use crate::experiments::contact_scene::study::SceneStudy;
use crate::report::format::{Span, percent};

/// Scenes without friction and with it, and the contact that is sensed worst.
pub(super) fn verdict(scenes: &[SceneStudy]) -> Option<String> {
    let worst_total = |with_friction: bool| {
        let scenes = scenes.iter().filter(|scene| (scene.friction > 0.0) == with_friction);
        let steps = scenes.flat_map(|scene| &scene.steps);
        let totals = steps.filter_map(|step| Some(step.clean.as_ref().ok()?.as_ref()?.total.relative_error().abs()));
        let totals: Vec<f64> = totals.collect();
        (!totals.is_empty()).then(|| percent(worst(totals)))
    };
    let smooth = worst_total(false)?;
    let rough = worst_total(true).map_or(String::new(), |rough| {
        format!(", and with friction, of which sensing knows the coefficient alone, by up to {rough}")
    });
    let smallest = least_known(scenes).map_or(String::new(), |least| {
        format!(
            " Single contacts are sensed worse: {} carries {:.2} N, and its sensed force scatters by {:.2} N.",
            least.name, least.true_n, least.rms_error_n
        )
    });
    Some(format!(
        "In simulation, with objects pressed onto the lattice, the sensed total errs by up to {smooth} without noise and friction{rough}.{smallest}"
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

/// One scene: how near the total comes, and what the intervals hold under noise.
pub(super) fn of_scene(scene: &SceneStudy) -> String {
    let mut sentences = Vec::new();
    if let Some(error) = &scene.stopped {
        sentences.push(format!("The scene ended after {} steps: {error}.", scene.steps.len()));
    }
    let clean: Vec<_> = scene.steps.iter().filter_map(|studied| studied.clean.as_ref().ok()?.as_ref()).collect();
    if clean.is_empty() {
        sentences.push("Nothing was sensed.".to_owned());
        return sentences.join(" ");
    }
    let total = worst(clean.iter().map(|sensed| sensed.total.relative_error().abs()));
    let balance = worst(scene.steps.iter().filter_map(|studied| studied.step.pressed.imbalance()));
    sentences.push(format!(
        "Without noise the sensed total is within {} of the true one at every step; contact forces balance those of the hand and \
         of the clamps within {balance:.0e} of their size.",
        percent(total)
    ));
    let sampled: Vec<&NoiseSamples> = scene.steps.iter().filter_map(|studied| studied.samples.as_ref()).collect();
    let sum = |of: &dyn Fn(&NoiseSamples) -> usize| sampled.iter().map(|samples| of(samples)).sum::<usize>();
    let coverages = |of: &dyn Fn(&NoiseSamples) -> std::ops::Range<usize>| {
        Span::of(sampled.iter().flat_map(|samples| of(samples).map(|which| samples.coverage(which))))
    };
    let contacts = coverages(&|samples| 0..samples.sensed.len() - 1);
    let total = coverages(&|samples| samples.sensed.len() - 1..samples.sensed.len());
    sentences.extend(contacts.zip(total).map(|(contacts, total)| format!(
        "Of {} noise samples of all steps, {} are answered. The stated 95 % intervals hold the true force of a contact in {} of all \
         samples (in {} where that is least), and the true total in {} ({}); refused samples count as not held.",
        sum(&|samples| samples.taken),
        sum(&|samples| samples.answered),
        percent(contacts.mean),
        percent(contacts.least),
        percent(total.mean),
        percent(total.least),
    )));
    if scene.friction > 0.0 {
        sentences.push(format!(
            "With friction ({}) forces lie anywhere in a cone of {:.1} deg around the normal; the intervals are widened by what the markers \
             leave open of that.",
            scene.friction,
            scene.friction.atan().to_degrees()
        ));
    }
    sentences.join(" ")
}
