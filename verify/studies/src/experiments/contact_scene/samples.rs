//! Noise samples of one step: how often the stated intervals hold the true forces.

use super::{ContactScene, SceneStep, SensedForce, SensedStep};
use crate::prelude::*;
use crate::sampling::noise::Noise;

/// Many noise samples of one step, of markers and contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseSamples {
    /// How many were taken.
    pub taken: usize,
    /// How many were answered.
    pub answered: usize,
    /// For each contact that is not clamped, and last for the total: what was sensed in the samples that were answered.
    pub sensed: Vec<Vec<SensedForce>>,
}

impl NoiseSamples {
    /// Takes a number of samples, each from a seed of its own beginning with `first_seed`; `None` where nothing can be felt.
    pub fn take(
        scene: &ContactScene,
        step: &SceneStep,
        noise_mm: f64,
        taken: usize,
        first_seed: u64,
    ) -> Option<NoiseSamples> {
        let contacts = step.contacts.iter().filter(|contact| !contact.clamped).count();
        if contacts == 0 || taken == 0 {
            return None;
        }
        let sample = |n: usize| {
            let mut noise = Noise::new(first_seed + n as u64);
            scene.sense(step, noise_mm, || noise.standard_normal()).ok().flatten()
        };
        let answers: Vec<SensedStep> = (0..taken).into_par_iter().filter_map(sample).collect();
        let force = |which: usize| {
            move |answer: &SensedStep| answer.contacts.get(which).map_or(answer.total, |contact| contact.force)
        };
        let sensed = (0..=contacts).map(|which| answers.iter().map(force(which)).collect()).collect();
        Some(NoiseSamples { taken, answered: answers.len(), sensed })
    }

    /// Samples whose stated interval of 95 % holds the true force, of a contact or the total (the last). A refused sample holds nothing.
    pub fn covered(&self, which: usize) -> usize {
        self.sensed[which].iter().filter(|force| force.standardised_error().abs() <= TWO_SIDED_95).count()
    }

    /// The same as a share of all that were taken.
    pub fn coverage(&self, which: usize) -> f64 {
        self.covered(which) as f64 / self.taken as f64
    }

    /// Root mean square of the errors, N: of a contact, or the total (the last).
    pub fn rms_error_n(&self, which: usize) -> f64 {
        self.root_mean_square(which, |force| force.sensed_n - force.true_n)
    }

    /// Root mean square of the stated standard deviations, N.
    pub fn rms_sigma_n(&self, which: usize) -> f64 {
        self.root_mean_square(which, |force| force.sigma_n)
    }

    fn root_mean_square(&self, which: usize, of: impl Fn(&SensedForce) -> f64) -> f64 {
        rms(self.sensed[which].iter().map(of)).unwrap_or(f64::NAN)
    }
}
