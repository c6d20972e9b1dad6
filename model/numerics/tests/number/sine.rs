//! Compares sines with the standard library.

use finray_numerics::number::sine_and_versine;
use std::f64::consts::FRAC_PI_4;

/// Covers the rounding of the polynomial's last sums and, for larger angles, the rounding of the square of a sine.
const RELATIVE_ERROR: f64 = 5e-16;

#[test]
fn are_the_standard_ones_to_rounding() {
    let around = (1..=80_000).map(|i| f64::from(i) * 1e-4);
    let tiny = (-150..0).map(|power| 10_f64.powi(power));
    for t in around.chain(tiny).chain([FRAC_PI_4, FRAC_PI_4.next_down()]) {
        let (sine, versine) = sine_and_versine(t);
        let half = (0.5 * t).sin();
        assert!((sine - t.sin()).abs() <= RELATIVE_ERROR * t.sin().abs(), "{t}: {sine}");
        assert!((versine - 2.0 * half * half).abs() <= RELATIVE_ERROR * versine, "{t}: {versine}");
        assert_eq!(sine_and_versine(-t), (-sine, versine));
    }
    let (sine, versine) = sine_and_versine(0.0);
    assert_eq!((sine, versine), (0.0, 0.0));
    let (sine, versine) = sine_and_versine(f64::NAN);
    assert!(sine.is_nan() && versine.is_nan());
}
