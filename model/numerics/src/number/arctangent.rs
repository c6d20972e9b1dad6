//! Angle of a vector, with the same operations for one number and for SIMD lanes.

use super::Number;
use std::f64::consts::{FRAC_PI_2, PI};

/// Slopes y / x up to this value need no range reduction.
const SHALLOW: f64 = 0.66;
/// tan(3 pi / 8). For slopes above this value, the angle is measured from pi / 2. For slopes between `SHALLOW` and this value, the angle is measured
/// from pi / 4.
const STEEP: f64 = 2.414_213_562_373_095;
/// pi / 2 minus its double-precision value. The remainders of pi / 4 and pi are half and twice as large.
const REST_OF_FRAC_PI_2: f64 = 6.123_233_995_736_766e-17;

/// atan(t) = t + t^3 P(t^2) / Q(t^2) for |t| <= 0.66, with a relative error of 2e-16. The highest power comes first. The leading coefficient 1 of Q is
/// omitted.
///
/// Source: Moshier, Cephes Mathematical Library (1989), `atan`.
const P: [f64; 5] = [
    -8.750_608_600_031_904e-1, -1.615_753_718_733_365_2e1, -7.500_855_792_314_705e1, -1.228_866_684_490_136_2e2,
    -6.485_021_904_942_025e1,
];
const Q: [f64; 5] = [
    2.485_846_490_142_306_2e1, 1.650_270_098_316_988_5e2, 4.328_810_604_912_902_6e2, 4.853_903_996_359_137e2,
    1.945_506_571_482_614e2,
];

/// Angle of the vector (x, y) from the x axis, rad, in [-pi, pi], with a relative error of 4e-16; NaN for the zero vector.
#[inline(always)]
pub fn arctangent<R: Number>(y: R, x: R) -> R {
    let zero = y.zero();
    let (a, b) = (y.abs(), x.abs());
    // Vectors that are vertical or point to the left never pass this test.
    if zero.everywhere((x * SHALLOW).exceeds(a)) {
        return of_slope(y / x);
    }
    let (beyond_shallow, steep) = (a.exceeds(b * SHALLOW), a.exceeds(b * STEEP));
    let numerator = R::select(steep, -b, R::select(beyond_shallow, a - b, a));
    let denominator = R::select(steep, a, R::select(beyond_shallow, a + b, b));
    let reference = |steepest: f64| {
        let half = R::select(beyond_shallow, zero.constant(0.5 * steepest), zero);
        R::select(steep, zero.constant(steepest), half)
    };
    let angle = reference(FRAC_PI_2) + (of_slope(numerator / denominator) + reference(REST_OF_FRAC_PI_2));
    let left = zero.exceeds(x);
    let angle = R::select(left, (zero.constant(PI) - angle) + 2.0 * REST_OF_FRAC_PI_2, angle);
    R::select(zero.exceeds(y), -angle, angle)
}

#[inline(always)]
fn of_slope<R: Number>(t: R) -> R {
    // Powers are combined in pairs (Estrin's scheme), which halves the chain of dependent operations.
    let z = t * t;
    let (z2, z4) = (z * z, z * z * (z * z));
    let p = z4 * P[0] + (z * P[1] + P[2]) * z2 + (z * P[3] + P[4]);
    let q = (z + Q[0]) * z4 + (z * Q[1] + Q[2]) * z2 + (z * Q[3] + Q[4]);
    t + t * (z * p / q)
}
