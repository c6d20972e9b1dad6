//! The hyperbolic tangent of the lanes of a SIMD vector.

use super::products::Finish;
use pulp::Simd;

/// Magnitude to which arguments are clamped; for larger arguments, |tanh| is 1 within the error of the approximation.
const CLAMP: f32 = 8.0;
/// Coefficients of the numerator N in tanh(x) = x N(x^2) / D(x^2), constant term first. Minimax fit over 0..8 with an error of 6e-9, scaled to minimise the
/// rounding of the coefficients to f32.
const NUMERATOR: [f32; 5] = [1.0770481, 0.14477357, 0.0038432276, 2.3523542e-5, 1.6323131e-8];
/// Coefficients of the denominator D in tanh(x) = x N(x^2) / D(x^2), constant term first.
const DENOMINATOR: [f32; 5] = [1.0770481, 0.5037895, 0.028166784, 0.00036683367, 9.1461675e-7];

/// The hyperbolic tangent as the last step of a layer.
#[derive(Debug, Clone, Copy)]
pub struct Tanh;

impl Finish<f32> for Tanh {
    #[inline(always)]
    fn finish<S: Simd>(self, simd: S, sum: S::f32s) -> S::f32s {
        tanh(simd, sum)
    }
}

/// Hyperbolic tangent of each lane.
#[inline(always)]
fn tanh<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    if S::IS_SCALAR {
        // Without fused multiply-add, f32 would round too much. For one number at a time, f64 is as fast as f32.
        return simd.splat_f32s(tanh_alone(simd.reduce_sum_f32s(x)));
    }
    let clamped = simd.max_f32s(simd.min_f32s(x, simd.splat_f32s(CLAMP)), simd.splat_f32s(-CLAMP));
    let square = simd.mul_f32s(clamped, clamped);
    let numerator = simd.mul_f32s(clamped, polynomial(simd, square, NUMERATOR));
    let ratio = simd.div_f32s(numerator, polynomial(simd, square, DENOMINATOR));
    let one = simd.splat_f32s(1.0);
    let value = simd.max_f32s(simd.min_f32s(ratio, one), simd.splat_f32s(-1.0));
    // Clamping may turn a NaN into a number, so NaN is restored. Bits are combined with OR, because a select would become a slow masked store.
    let not_a_number = simd.select_f32s(simd.equal_f32s(x, x), simd.splat_f32s(0.0), simd.splat_f32s(f32::NAN));
    simd.or_f32s(value, not_a_number)
}

/// Hyperbolic tangent of one number, computed in f64.
#[inline(always)]
fn tanh_alone(x: f32) -> f32 {
    let clamped = f64::from(x.clamp(-CLAMP, CLAMP));
    let square = clamped * clamped;
    let polynomial = |coefficients: [f32; 5]| {
        coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * square + f64::from(*coefficient))
    };
    (clamped * polynomial(NUMERATOR) / polynomial(DENOMINATOR)).clamp(-1.0, 1.0) as f32
}

/// Polynomial by Horner's rule; the constant coefficient comes first.
#[inline(always)]
fn polynomial<S: Simd>(simd: S, x: S::f32s, coefficients: [f32; 5]) -> S::f32s {
    let [lower @ .., highest] = coefficients;
    let mut sum = simd.splat_f32s(highest);
    for coefficient in lower.iter().rev() {
        sum = simd.mul_add_e_f32s(sum, x, simd.splat_f32s(*coefficient));
    }
    sum
}
