//! Tests of private items of `calibration::views::errors`.

use super::*;

/// Residuals of standard deviation `sd_mm`. The fit has absorbed a quarter of the variance of the residuals.
fn of(sd_mm: f64, stated_mm: f64, rows: usize) -> Vec<CoordinateResidual> {
    vec![CoordinateResidual { square_mm2: 0.75 * sd_mm * sd_mm, free: 0.75, stated_mm }; rows]
}

/// For equal stated noise, the expected values follow by hand: the mean square divided by the free part, times 75 / 73. This factor is the ratio of
/// mean to mode. The model error is the part beyond the stated noise.
#[test]
fn errors_stated_alike_are_those_of_the_residual() {
    let wider = 75.0 / 73.0;
    let more = likeliest(of(0.05, 0.03, 100), true);
    assert_eq!(more.noise_factor, 1.0);
    assert!((more.calibration_error_mm.powi(2) - (wider * 0.0025 - 0.0009)).abs() < 1e-8, "{more:?}");
    // The prior of the noise factor has the weight of two degrees of freedom out of 150.
    let less = likeliest(of(0.05, 0.1, 100), true);
    assert_eq!(less.calibration_error_mm, 0.0);
    assert!((less.noise_factor.powi(2) / (wider * 0.25) - 1.0).abs() < 0.02, "{less:?}");
}

/// Markers with different stated noise distinguish the model error from the noise.
#[test]
fn the_fingers_part_is_told_from_the_markers() {
    let both = |stated_mm: f64| (0.5 * stated_mm).hypot(0.02);
    let found = likeliest([0.01, 0.1].map(|stated_mm| of(both(stated_mm), stated_mm, 1000)).concat(), true);
    assert!(
        (found.noise_factor / 0.5 - 1.0).abs() < 0.01 && (found.calibration_error_mm / 0.02 - 1.0).abs() < 0.01,
        "{found:?}"
    );
    // Errors that do not depend on the stated noise are model errors; the prior keeps the noise factor above zero.
    let found = likeliest([0.01, 0.1].map(|stated_mm| of(0.02, stated_mm, 1000)).concat(), true);
    assert!((found.calibration_error_mm / 0.02 - 1.0).abs() < 0.03 && found.noise_factor < 0.1, "{found:?}");
    // A noise that may not be reduced stays as stated.
    assert_eq!(likeliest(of(0.05, 0.1, 100), false), MarkerErrors::default());
}
