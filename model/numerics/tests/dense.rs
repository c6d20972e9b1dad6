//! Tests the hyperbolic tangent over the whole range of numbers.

use finray_numerics::dense::tanh;
use pulp::{Arch, Scalar, Simd, WithSimd};

/// Error bound that `tanh` states; the bound must hold for every number.
const LARGEST_ERROR: f64 = 3e-7;
/// Distance between two tested bit patterns. The distance is prime, so that mantissas of all kinds occur.
const STRIDE: usize = 499;

struct TanhAll<'a>(&'a mut [f32]);

impl WithSimd for TanhAll<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        tanh(simd, self.0);
    }
}

/// The hyperbolic tangents of the numbers, computed with the detected and with the portable processor instructions.
fn both(numbers: &[f32]) -> [Vec<f32>; 2] {
    let mut values = [numbers.to_vec(), numbers.to_vec()];
    Arch::new().dispatch(TanhAll(&mut values[0]));
    TanhAll(&mut values[1]).with_simd(Scalar);
    values
}

#[test]
fn every_number_is_within_the_error() {
    let numbers: Vec<f32> = (0..=u32::MAX).step_by(STRIDE).map(f32::from_bits).filter(|x| !x.is_nan()).collect();
    for (values, instructions) in both(&numbers).iter().zip(["detected", "portable"]) {
        for (x, value) in numbers.iter().zip(values) {
            let error = (f64::from(*value) - f64::from(*x).tanh()).abs();
            assert!(error <= LARGEST_ERROR, "{instructions}: tanh({x:e}) = {value:e}");
            assert!(value.abs() <= 1.0 && value.is_sign_negative() == x.is_sign_negative());
        }
    }
}

#[test]
fn special_numbers_stay_what_they_are() {
    let numbers = [0.0, -0.0, f32::MIN_POSITIVE, 1e-40, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 8.0];
    for values in both(&numbers) {
        assert!(values[0] == 0.0 && values[0].is_sign_positive());
        assert!(values[1] == 0.0 && values[1].is_sign_negative());
        assert!(values[2] <= f32::MIN_POSITIVE && values[3] <= 1.1e-40);
        assert!(values[7].is_nan());
    }
}
