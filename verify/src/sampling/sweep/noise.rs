//! Noise pictures, which every cell of a sweep sees alike.

use super::Grid;
use finray_model::Finger;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::ops::Range;

/// Words of the random stream for each picture, more than it takes: a picture does not depend on those before it.
const WORDS: u128 = 1 << 24;
/// Numbers that are drawn once and kept, 2 MB: 5600 pictures of the paper's finger. What is beyond them is drawn anew for
/// each block, so that the memory of a sweep does not grow with its pictures.
const KEPT: usize = 1 << 18;
/// Pictures that a block looks at together, drawn into the same room.
const AT_ONCE: usize = 256;

/// Displacement noise of every marker coordinate, in units of the noise.
pub(super) struct Noise {
    seed: u64,
    /// Numbers a picture: two for each marker.
    coordinates: usize,
    pictures: usize,
    /// The first pictures.
    kept: Vec<f64>,
}

impl Noise {
    pub(super) fn new(grid: &Grid, finger: &Finger) -> Noise {
        let coordinates = 2 * finger.free_nodes().len();
        let pictures = grid.noise_pictures.max(1);
        let mut noise = Noise { seed: grid.seed, coordinates, pictures, kept: Vec::new() };
        noise.kept = noise.drawn(0..pictures.min((KEPT / coordinates.max(1)).max(1)));
        noise
    }

    /// Number of pictures at a level of noise: without noise all are the same.
    pub(super) fn pictures(&self, noise_mm: f64) -> usize {
        if noise_mm == 0.0 { 1 } else { self.pictures }
    }

    /// Hands all pictures to `look`, some at a time: the number of the first one, and their coordinates one after the
    /// other.
    pub(super) fn each(&self, mut look: impl FnMut(usize, &[f64])) {
        for first in (0..self.pictures).step_by(AT_ONCE) {
            let numbers = first..self.pictures.min(first + AT_ONCE);
            match self.kept.get(numbers.start * self.coordinates..numbers.end * self.coordinates) {
                Some(kept) => look(first, kept),
                None => look(first, &self.drawn(numbers)),
            }
        }
    }

    /// Numbers of one picture.
    pub(super) fn coordinates(&self) -> usize {
        self.coordinates
    }

    fn drawn(&self, pictures: Range<usize>) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut numbers = Vec::with_capacity(pictures.len() * self.coordinates);
        for picture in pictures {
            rng.set_word_pos(WORDS * picture as u128);
            numbers.extend((0..self.coordinates).map(|_| -> f64 { StandardNormal.sample(&mut rng) }));
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use finray_model::Scene;

    /// Pictures that are kept, drawn on their own or with others before them are the same.
    #[test]
    fn a_picture_does_not_depend_on_what_is_kept() {
        let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the paper's scene").finger;
        let (places_mm, angles_deg) = Grid::grid(&finger, 12, 90.0);
        let grid = Grid {
            places_mm,
            angles_deg,
            forces_n: vec![1.0],
            noise_levels_mm: vec![0.1],
            noise_pictures: 6000,
            seed: 3,
        };
        let all = |noise: &Noise| {
            let mut all = Vec::new();
            noise.each(|first, pictures| {
                assert_eq!(all.len(), first * noise.coordinates());
                all.extend_from_slice(pictures);
            });
            all
        };
        let mut noise = Noise::new(&grid, &finger);
        let seen = all(&noise);
        assert_eq!(seen.len(), 6000 * noise.coordinates());
        assert!(noise.kept.len() < seen.len(), "not all are kept");
        noise.kept.truncate(noise.coordinates());
        assert!(all(&noise) == seen);
        assert!(noise.drawn(5999..6000) == seen[5999 * noise.coordinates()..]);
        assert_eq!((noise.pictures(0.1), noise.pictures(0.0)), (6000, 1));
    }
}
