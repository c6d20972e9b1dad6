//! Noise samples of a sweep. All cells share them, so that sensors and cells can be compared; a grid of leaning directions, whose cells also show the
//! coverage of intervals, has its own samples for each cell.

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
    /// Number of coordinates of a measurement: two for each marker.
    coordinates: usize,
    /// Number of random numbers of a sample: the coordinates of one measurement that all cells share, or those of one measurement for each force.
    length: usize,
    samples: usize,
    /// Whether each cell has its own samples.
    is_by_cell: bool,
    /// Noise of the first samples that all blocks share, one sample after the other.
    kept: Vec<f64>,
}

impl NoiseSamples {
    pub(super) fn new(grid: &Grid, finger: &Finger) -> NoiseSamples {
        let coordinates = 2 * finger.marked_nodes().len();
        let samples = grid.noise_samples.max(1);
        let is_by_cell = grid.is_leaning;
        let length = coordinates * if is_by_cell { grid.forces_n.len() } else { 1 };
        let mut noise = NoiseSamples { seed: grid.seed, coordinates, length, samples, is_by_cell, kept: Vec::new() };
        if !is_by_cell {
            noise.kept = noise.drawn(0, 0..samples.min((KEPT / length.max(1)).max(1)));
        }
        noise
    }

    /// Number of samples at a noise level (mm). Without noise all samples are equal, so one suffices.
    pub(super) fn samples(&self, noise_mm: f64) -> usize {
        if noise_mm == 0.0 { 1 } else { self.samples }
    }

    /// The noise of each measurement under the force with index `force`, in a group of samples.
    pub(super) fn of_force<'n>(
        &self,
        force: usize,
        group: &'n [f64],
    ) -> impl ExactSizeIterator<Item = &'n [f64]> + use<'n> {
        let (from, coordinates) = (if self.is_by_cell { force * self.coordinates } else { 0 }, self.coordinates);
        group.chunks_exact(self.length).map(move |sample| &sample[from..][..coordinates])
    }

    /// Passes all samples of a block to `look` in groups. `look` receives the index of the group's first sample and the random numbers of the group's
    /// samples, one sample after the other.
    pub(super) fn each(&self, block: usize, mut look: impl FnMut(usize, &[f64])) {
        for first in (0..self.samples).step_by(AT_ONCE) {
            let numbers = first..self.samples.min(first + AT_ONCE);
            match self.kept.get(numbers.start * self.length..numbers.end * self.length) {
                Some(kept) => look(first, kept),
                None => look(first, &self.drawn(block, numbers)),
            }
        }
    }

    fn drawn(&self, block: usize, samples: Range<usize>) -> Vec<f64> {
        let mut noise = Noise::of_stream(self.seed, if self.is_by_cell { block as u64 } else { 0 });
        let mut numbers = Vec::with_capacity(samples.len() * self.length);
        for sample in samples {
            noise.go_to(sample as u64);
            numbers.extend(noise.standard_normals(self.length));
        }
        numbers
    }
}

#[cfg(test)]
#[path = "../../../tests/units/samples.rs"]
mod tests;
