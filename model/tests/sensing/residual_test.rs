//! Chi-squared test of the residual against the stated noise.

use finray_model::sensing::ResidualTest;

/// Upper 1 % points of chi-squared: 6.635, 23.209, 69.957 for 1, 10, 45 degrees of freedom (Abramowitz and Stegun,
/// table 26.8; the last by interpolation of statistical tables).
#[test]
fn the_limit_is_the_tabulated_one() {
    for (degrees_of_freedom, limit) in [(1, 6.635), (10, 23.209), (45, 69.957)] {
        for (share, contradicted) in [(0.9999, false), (1.0001, true)] {
            let test = ResidualTest::new(Some(0.5), 0.25 * limit * share, degrees_of_freedom).unwrap();
            assert_eq!(test.contradicts(), contradicted, "{test:?}");
        }
    }
}

#[test]
fn nothing_is_tested_without_noise_or_degrees_of_freedom() {
    assert_eq!(ResidualTest::new(None, 1.0, 3), None);
    assert_eq!(ResidualTest::new(Some(0.0), 1.0, 3), None);
    assert_eq!(ResidualTest::new(Some(0.1), 1.0, 0), None);
}

#[test]
fn a_residual_that_is_no_number_does_not_pass_as_small() {
    let test = ResidualTest { marker_noise_mm: 0.1, residual_sd_mm: f64::INFINITY, degrees_of_freedom: 3 };
    assert!(test.contradicts());
}
