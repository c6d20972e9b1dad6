//! Sine and versine (1 - cosine) of an angle, with the same operations for one number and for SIMD lanes.

use super::Number;
use std::f64::consts::FRAC_PI_4;

/// sin(t) = t + t^3 S(t^2) and cos(t) = 1 - t^2 / 2 + t^4 C(t^2) for |t| <= pi / 4, with an error of 1.1e-16. The highest power comes first.
///
/// Source: Moshier, Cephes Mathematical Library (1989), `sin`.
const S: [f64; 6] = [
    1.589_623_015_765_465_7e-10, -2.505_074_776_285_780_7e-8, 2.755_731_362_138_572_5e-6, -1.984_126_982_958_954e-4,
    8.333_333_333_322_118e-3, -1.666_666_666_666_663e-1,
];
const C: [f64; 6] = [
    -1.135_853_652_138_768_2e-11, 2.087_570_084_197_473e-9, -2.755_731_417_929_674e-7, 2.480_158_728_885_171_8e-5,
    -1.388_888_888_887_306e-3, 4.166_666_666_666_659_5e-2,
];

/// sin(t) and 1 - cos(t) of an angle in rad, each with a relative error of at most 5e-16. Up to pi / 4 no library function is called.
#[inline(always)]
pub fn sine_and_versine<R: Number>(t: R) -> (R, R) {
    // Powers are combined in pairs (Estrin's scheme), which halves the chain of dependent operations.
    let z = t * t;
    let (z2, z4) = (z * z, z * z * (z * z));
    let s = (z * S[0] + S[1]) * z4 + (z * S[2] + S[3]) * z2 + (z * S[4] + S[5]);
    let c = (z * C[0] + C[1]) * z4 + (z * C[2] + C[3]) * z2 + (z * C[4] + C[5]);
    let (sine, versine) = (t + t * z * s, z * 0.5 - z * z * c);
    let is_small = t.constant(FRAC_PI_4).exceeds(t.abs());
    if t.everywhere(is_small) {
        return (sine, versine);
    }
    let half = (t * 0.5).each(f64::sin);
    (R::select(is_small, sine, t.each(f64::sin)), R::select(is_small, versine, half * 2.0 * half))
}
