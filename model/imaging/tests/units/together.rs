//! The factor on the standard deviations of a plate's markers.

use super::*;
use finray_tests::random_stream;
use rand_distr::{Distribution, Exp1};

/// Excess variances of whole markers with independent errors: exponential distributions about 1.
fn whole(count: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut chance = random_stream(66, seed);
    (0..count).map(|_| [0, 1].map(|_| Exp1.sample(&mut chance))).collect()
}

/// A marker that something covers in part has residuals with hundred times the power of a whole marker. As a mean, the factor of all markers of the plate
/// once rose to 5.
#[test]
fn one_covered_marker_does_not_widen_the_others() {
    for seed in 0..200 {
        let mut markers = whole(12, seed);
        let without = wider(markers.iter().copied());
        markers.push([300.0; 2]);
        let with = wider(markers.iter().copied());
        assert!(with < 2.0 * without, "seed {seed}: {without} {with}");
    }
}

/// The bound on a marker's share hardly changes the mean of whole markers: of an exponential distribution, 0.1 % lies beyond ten medians.
#[test]
fn whole_markers_keep_their_mean() {
    let markers: Vec<f64> = whole(100_000, 0).iter().map(|of| of[0]).collect();
    let mean = bounded_mean(markers.iter().copied());
    // The standard deviation of the mean of 100 000 is 0.3 %.
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
}
