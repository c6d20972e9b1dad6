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
    let test = ResidualTest::new(Some(0.1), f64::INFINITY, 3).unwrap();
    assert!(test.contradicts());
}

/// Upper 1 % points of F: 5.814, 5.198 for 10 and 30 over 8 degrees of freedom (Abramowitz and Stegun, table 26.9).
#[test]
fn the_limit_of_an_estimated_noise_is_the_tabulated_one() {
    for (degrees_of_freedom, limit) in [(10, 5.814), (30, 5.198)] {
        for (share, contradicted) in [(0.999, false), (1.001, true)] {
            let squares_mm2 = 0.25 * limit * share * degrees_of_freedom as f64;
            let test = ResidualTest::new(Some(0.5), squares_mm2, degrees_of_freedom).unwrap().of_estimated_noise(8.0);
            assert_eq!(test.contradicts(), contradicted, "{test:?}");
        }
    }
}

/// Residual and stated noise are pooled by their degrees of freedom, with the point of Student's t for 97.5 % and 20 degrees of freedom, 2.086
/// (Abramowitz and Stegun, table 26.10).
#[test]
fn an_estimated_noise_is_pooled_with_the_residual() {
    let test = ResidualTest::new(Some(0.1), 12.0 * 0.04, 12).unwrap().of_estimated_noise(8.0);
    let expected_mm = ((12.0 * 0.04 + 8.0 * 0.01) / 20.0_f64).sqrt() * 2.085_963 / 1.959_964;
    assert!((test.trusted_noise_mm() / expected_mm - 1.0).abs() < 1e-4, "{}", test.trusted_noise_mm());
    // A noise that is known to many degrees of freedom is a known noise.
    let small = ResidualTest::new(Some(0.1), 12.0 * 0.0121, 12).unwrap().of_estimated_noise(1e9);
    assert!((small.trusted_noise_mm() / 0.1 - 1.0).abs() < 1e-6, "{small:?}");
    // A small residual narrows no prior.
    let quiet = ResidualTest::new(Some(0.1), 12.0 * 0.0001, 12).unwrap().of_estimated_noise(8.0);
    assert!(quiet.trusted_noise_mm() >= 0.1, "{quiet:?}");
}
