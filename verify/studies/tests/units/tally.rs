//! Mean error of a cell with a common error.

use super::*;

/// Mean of |mean + sd x| over the standard normal distribution, by the midpoint rule.
fn integrated(mean: f64, sd: f64) -> f64 {
    const STEP: f64 = 1e-4;
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    (-80_000..80_000).map(|i| (f64::from(i) + 0.5) * STEP).map(|x| (mean + sd * x).abs() * density(x) * STEP).sum()
}

#[test]
fn the_mean_error_is_that_over_all_common_errors() {
    for mean in [0.0, 0.01, -0.07, 0.3] {
        for sd in [0.02, 0.1, 0.5] {
            let (found, expected) = (mean_absolute(mean, sd), integrated(mean, sd));
            assert!((found / expected - 1.0).abs() < 1e-6, "{mean}, {sd}: {found}, integrated {expected}");
        }
        assert_eq!(mean_absolute(mean, 0.0), f64::abs(mean));
    }
}
