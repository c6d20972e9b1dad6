//! Compares angles with the standard library, for single numbers and for SIMD lanes.

use finray_numerics::number::{Lanes, Number, arctangent};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;

/// Covers the rounding of the quotient and of the sum, and an equally large error of the polynomial.
const RELATIVE_ERROR: f64 = 4e-16;

struct InLanes(Vec<(f64, f64)>);

impl WithSimd for InLanes {
    type Output = Vec<f64>;

    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        let of_chunk = |vectors: &[(f64, f64)]| {
            let [mut y, mut x] = [Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0)];
            for (lane, vector) in vectors.iter().enumerate() {
                y.set_lane(lane, vector.0);
                x.set_lane(lane, vector.1);
            }
            let angles = arctangent(y, x);
            (0..vectors.len()).map(|lane| angles.lane(lane)).collect::<Vec<f64>>()
        };
        self.0.chunks(S::F64_LANES).flat_map(of_chunk).collect()
    }
}

/// Vectors (y, x) of several lengths: in all quadrants, on the axes, at tiny angles, and at the limits of range reduction.
fn vectors() -> Vec<(f64, f64)> {
    let around = (0..=20_000).map(|i| f64::from(i) * 1e-4 * PI);
    let tiny = (-300..0).map(|power| 10_f64.powi(power));
    // Range reduction begins at the slope 0.66 and changes at the slope tan(3 pi / 8).
    let borders =
        [0.66, 2.414_213_562_373_095_f64].into_iter().flat_map(|t| [t, t.next_up(), t.next_down()]).map(f64::atan);
    let angles = around.chain(tiny).chain(borders);
    let of_angle = |angle: f64| [1e-3, 1.0, 1e3].map(|r| (r * angle.sin(), r * angle.cos()));
    angles.flat_map(of_angle).chain([(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0)]).collect()
}

#[test]
fn is_the_standard_one_to_rounding() {
    for (y, x) in vectors() {
        let (ours, standard) = (arctangent(y, x), y.atan2(x));
        assert!((ours - standard).abs() <= RELATIVE_ERROR * standard.abs(), "{y} {x}: {ours} {standard}");
        // A negative zero counts as zero: the angle of a vector along the negative x axis is pi.
        assert_eq!(arctangent(-y, x), if y == 0.0 { ours } else { -ours });
    }
    assert!(arctangent(0.0, 0.0).is_nan() && arctangent(f64::NAN, 1.0).is_nan());
}

#[test]
fn is_the_same_in_lanes() {
    let alone: Vec<f64> = vectors().iter().map(|(y, x)| arctangent(*y, *x)).collect();
    assert_eq!(Arch::new().dispatch(InLanes(vectors())), alone);
}
