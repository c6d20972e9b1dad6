//! Noise samples of a sweep.

use super::*;
use finray_model::Scene;

/// A sample is the same whether it is drawn alone, after other samples, or kept from an earlier draw.
#[test]
fn a_sample_does_not_depend_on_what_is_kept() {
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the paper's scene").finger;
    let (positions_mm, angles_deg) = Grid::grid(&finger, 12, 90.0);
    let mut grid = Grid {
        positions_mm,
        angles_deg,
        is_leaning: false,
        forces_n: vec![1.0],
        noise_levels_mm: vec![0.1],
        noise_samples: 6000,
        seed: 3,
    };
    let all = |noise: &NoiseSamples| {
        let mut all = Vec::new();
        noise.each(7, |first, samples| {
            assert_eq!(all.len(), first * noise.coordinates);
            all.extend_from_slice(samples);
        });
        all
    };
    let mut noise = NoiseSamples::new(&grid, &finger);
    let seen = all(&noise);
    assert_eq!(seen.len(), 6000 * noise.coordinates);
    assert!(noise.kept.len() < seen.len(), "not all are kept");
    noise.kept.truncate(noise.coordinates);
    assert!(all(&noise) == seen);
    assert!(noise.drawn(7, 5999..6000) == seen[5999 * noise.coordinates..]);
    assert_eq!((noise.samples(0.1), noise.samples(0.0)), (6000, 1));
    let of_force =
        |noise: &NoiseSamples, group: &[f64], n| noise.of_force(n, group).flatten().copied().collect::<Vec<_>>();
    assert!(of_force(&noise, &seen, 1) == seen, "all forces share the samples");

    grid.is_leaning = true;
    grid.forces_n = vec![1.0, 2.0];
    let own = NoiseSamples::new(&grid, &finger);
    let first = own.drawn(7, 0..1);
    assert!(first[..own.coordinates] != seen[..own.coordinates] && first[..] == own.drawn(7, 0..2)[..own.length]);
    assert_eq!(first.len(), 2 * own.coordinates);
    assert!(
        of_force(&own, &first, 0) == first[..own.coordinates] && of_force(&own, &first, 1) == first[own.coordinates..]
    );
}
