//! Noise samples, which every cell of a sweep sees alike.

use super::Grid;
use crate::sampling::noise::Noise;
use finray_model::Finger;
use std::ops::Range;

/// Numbers that are drawn once and kept, 2 MB: 5600 samples of the paper's finger. What is beyond them is drawn anew for
/// each block, so that the memory of a sweep does not grow with its samples.
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

    /// Hands all samples to `look`, some at a time: the number of the first one, and their coordinates one after the
    /// other.
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
mod tests {
    use super::*;
    use finray_model::Scene;

    /// Samples that are kept, drawn on their own or with others before them are the same.
    #[test]
    fn a_sample_does_not_depend_on_what_is_kept() {
        let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the paper's scene").finger;
        let (positions_mm, angles_deg) = Grid::grid(&finger, 12, 90.0);
        let grid = Grid {
            positions_mm,
            angles_deg,
            forces_n: vec![1.0],
            noise_levels_mm: vec![0.1],
            noise_samples: 6000,
            seed: 3,
        };
        let all = |noise: &NoiseSamples| {
            let mut all = Vec::new();
            noise.each(|first, samples| {
                assert_eq!(all.len(), first * noise.coordinates());
                all.extend_from_slice(samples);
            });
            all
        };
        let mut noise = NoiseSamples::new(&grid, &finger);
        let seen = all(&noise);
        assert_eq!(seen.len(), 6000 * noise.coordinates());
        assert!(noise.kept.len() < seen.len(), "not all are kept");
        noise.kept.truncate(noise.coordinates());
        assert!(all(&noise) == seen);
        assert!(noise.drawn(5999..6000) == seen[5999 * noise.coordinates()..]);
        assert_eq!((noise.samples(0.1), noise.samples(0.0)), (6000, 1));
    }
}
