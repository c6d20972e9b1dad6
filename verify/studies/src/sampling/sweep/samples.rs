//! Noise samples of a sweep. All cells share them, so that sensors and cells can be compared; a grid of leaning directions, whose cells also show the
//! coverage of intervals, has its own samples in each block.

use super::Grid;
use crate::sampling::noise::Noise;
use finray_model::Finger;
use std::ops::Range;

/// Number of random numbers that are drawn once and kept: 2 MB, 5600 samples of the paper's finger. Further samples are drawn again for each block.
const KEPT: usize = 1 << 18;
/// Number of samples that a block processes together.
const AT_ONCE: usize = 256;

/// Displacement noise of every marker coordinate, in standard deviations.
pub(super) struct NoiseSamples {
    seed: u64,
    /// Number of coordinates of a sample: two for each marker.
    pub(super) coordinates: usize,
    samples: usize,
    /// Whether each block has its own samples.
    is_by_block: bool,
    /// Noise of the first samples that all blocks share, one sample after the other.
    kept: Vec<f64>,
}

impl NoiseSamples {
    pub(super) fn new(grid: &Grid, finger: &Finger) -> NoiseSamples {
        let coordinates = 2 * finger.marked_nodes().len();
        let samples = grid.noise_samples.max(1);
        let is_by_block = grid.is_leaning;
        let mut noise = NoiseSamples { seed: grid.seed, coordinates, samples, is_by_block, kept: Vec::new() };
        if !is_by_block {
            noise.kept = noise.drawn(0, 0..samples.min((KEPT / coordinates.max(1)).max(1)));
        }
        noise
    }

    /// Number of samples at a noise level (mm). Without noise all samples are equal, so one suffices.
    pub(super) fn samples(&self, noise_mm: f64) -> usize {
        if noise_mm == 0.0 { 1 } else { self.samples }
    }

    /// Passes all samples of a block to `look` in groups. `look` receives the index of the group's first sample and the noise of the group's samples,
    /// one sample after the other.
    pub(super) fn each(&self, block: usize, mut look: impl FnMut(usize, &[f64])) {
        for first in (0..self.samples).step_by(AT_ONCE) {
            let numbers = first..self.samples.min(first + AT_ONCE);
            match self.kept.get(numbers.start * self.coordinates..numbers.end * self.coordinates) {
                Some(kept) => look(first, kept),
                None => look(first, &self.drawn(block, numbers)),
            }
        }
    }

    fn drawn(&self, block: usize, samples: Range<usize>) -> Vec<f64> {
        let mut noise = Noise::of_stream(self.seed, if self.is_by_block { block as u64 } else { 0 });
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
