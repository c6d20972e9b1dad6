//! Noise samples, which every cell of a sweep sees alike.

use super::Grid;
use crate::sampling::noise::Noise;
use finray_model::Finger;
use std::ops::Range;

/// Numbers drawn once and kept, 2 MB: 5600 samples of the paper's finger. What is beyond is drawn anew for each block.
const KEPT: usize = 1 << 18;
/// Samples that a block looks at together, drawn into the same room.
const AT_ONCE: usize = 256;

/// Displacement noise of every marker coordinate, in units of the noise.
pub(super) struct NoiseSamples {
    seed: u64,
    /// Numbers a sample: two for each marker.
    coordinates: usize,
    samples: usize,
    /// The first samples.
    kept: Vec<f64>,
}

impl NoiseSamples {
    pub(super) fn new(grid: &Grid, finger: &Finger) -> NoiseSamples {
        let coordinates = 2 * finger.marked_nodes().len();
        let samples = grid.noise_samples.max(1);
        let mut noise = NoiseSamples { seed: grid.seed, coordinates, samples, kept: Vec::new() };
        noise.kept = noise.drawn(0..samples.min((KEPT / coordinates.max(1)).max(1)));
        noise
    }

    /// Number of samples at a level of noise: without noise all are the same.
    pub(super) fn samples(&self, noise_mm: f64) -> usize {
        if noise_mm == 0.0 { 1 } else { self.samples }
    }

    /// Hands all samples to `look`, some at a time: the first one's number, and their coordinates one after the other.
    pub(super) fn each(&self, mut look: impl FnMut(usize, &[f64])) {
        for first in (0..self.samples).step_by(AT_ONCE) {
            let numbers = first..self.samples.min(first + AT_ONCE);
            match self.kept.get(numbers.start * self.coordinates..numbers.end * self.coordinates) {
                Some(kept) => look(first, kept),
                None => look(first, &self.drawn(numbers)),
            }
        }
    }

    /// Numbers of one sample.
    pub(super) fn coordinates(&self) -> usize {
        self.coordinates
    }

    fn drawn(&self, samples: Range<usize>) -> Vec<f64> {
        let mut noise = Noise::new(self.seed);
        let mut numbers = Vec::with_capacity(samples.len() * self.coordinates);
        for sample in samples {
            noise.go_to(sample as u64);
            numbers.extend(noise.standard_normals(self.coordinates));
        }
        numbers
    }
}

#[cfg(test)]
#[path = "../../../tests/units/samples.rs"]
mod tests;
