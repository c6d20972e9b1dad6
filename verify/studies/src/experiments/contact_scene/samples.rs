//! Noise samples of one step, from which the coverage of the stated intervals is estimated.

use crate::prelude::*;
use crate::sampling::noise::Noise;
use finray_contact::press::{ContactScene, SceneStep, SensedForce, SensedStep};

/// Forces sensed from many noise samples of one step, with noise on markers and contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseSamples {
    /// Number of samples.
    pub taken: usize,
    /// Number of answered samples.
    pub answered: usize,
    /// Sensed forces, one list for each contact that is not clamped, and a last list for the total. Refused samples are omitted.
    pub sensed: Vec<Vec<SensedForce>>,
}

impl NoiseSamples {
    /// Senses `taken` samples with noise of `noise_mm` (mm) and with seeds from `first_seed` upwards. `None` if `taken` is 0, or no contact deforms
    /// the finger.
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

    /// Number of samples whose stated 95 % interval contains the true force; `which` is the index of a contact, or the last index for the total.
    /// Refused samples do not count.
    pub fn covered(&self, which: usize) -> usize {
        self.sensed[which].iter().filter(|force| force.standardised_error().abs() <= TWO_SIDED_95).count()
    }

    /// Share of all samples whose stated 95 % interval contains the true force; `which` is the index of a contact, or the last index for the total.
    pub fn coverage(&self, which: usize) -> f64 {
        self.covered(which) as f64 / self.taken as f64
    }

    /// Root mean square force error, N; `which` is the index of a contact, or the last index for the total.
    pub fn rms_error_n(&self, which: usize) -> f64 {
        self.root_mean_square(which, |force| force.sensed_n - force.true_n)
    }

    /// Root mean square of the stated standard deviations, N; `which` is the index of a contact, or the last index for the total.
    pub fn rms_sigma_n(&self, which: usize) -> f64 {
        self.root_mean_square(which, |force| force.sigma_n)
    }

    fn root_mean_square(&self, which: usize, of: impl Fn(&SensedForce) -> f64) -> f64 {
        rms(self.sensed[which].iter().map(of)).unwrap_or(f64::NAN)
    }
}
