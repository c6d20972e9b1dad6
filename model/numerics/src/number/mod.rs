//! Number type of the equations: one number, or several SIMD lanes that run through the same instructions.
//!
//! Scalars and lanes give bitwise equal results. Each sum, product, quotient and root is rounded separately, without fused multiply-add. All other
//! functions use the same operations for scalars and lanes. A lane of [`Lanes`] therefore holds the same bits as the same calculation with an `f64`,
//! independent of the neighbouring lanes and of the machine.

mod arctangent;
mod lanes;
mod sine;

pub use arctangent::arctangent;
pub use lanes::Lanes;
pub use sine::sine_and_versine;

use nalgebra::Scalar;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number, or several real numbers: one per SIMD lane.
pub trait Number:
    Scalar
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Add<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// A truth value per lane.
    type Mask: Copy + Debug;
    /// Number of lanes; 1 for a scalar.
    const LANES: usize;

    /// Returns `value` in each lane. Takes `self`, because only an existing number knows the SIMD instructions to use.
    fn constant(self, value: f64) -> Self;

    /// Square root in each lane.
    fn sqrt(self) -> Self;

    /// Absolute value in each lane.
    fn abs(self) -> Self;

    /// The larger of two numbers in each lane; if one of the two is NaN, returns the other.
    fn larger(self, other: Self) -> Self;

    /// Returns `number(lane)` in each lane.
    fn of_lanes(self, number: impl Fn(usize) -> f64) -> Self;

    /// Applies a scalar function lane by lane.
    fn each(self, function: impl Fn(f64) -> f64) -> Self;

    /// Lanes in which `self` is larger than `other`; `false` if either is NaN.
    fn exceeds(self, other: Self) -> Self::Mask;

    /// Returns `yes` in the lanes of the mask and `no` in the others.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Lanes in which both masks hold.
    fn both(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// Lanes in which at least one mask holds.
    fn either(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// Whether a mask holds in any lane.
    fn anywhere(self, mask: Self::Mask) -> bool;

    /// Whether a mask holds in all lanes.
    fn everywhere(self, mask: Self::Mask) -> bool;

    /// Whether a mask holds in the given lane.
    fn holds(self, mask: Self::Mask, lane: usize) -> bool;

    /// The number in the given lane.
    fn lane(&self, lane: usize) -> f64;

    /// Overwrites the number in the given lane.
    fn set_lane(&mut self, lane: usize, value: f64);

    /// Zero in each lane.
    #[inline(always)]
    fn zero(self) -> Self {
        self.constant(0.0)
    }

    /// A mask that holds in all lanes.
    #[inline(always)]
    fn always(self) -> Self::Mask {
        self.constant(1.0).exceeds(self.constant(0.0))
    }
}

impl Number for f64 {
    type Mask = bool;
    const LANES: usize = 1;

    #[inline(always)]
    fn constant(self, value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn larger(self, other: f64) -> f64 {
        f64::max(self, other)
    }

    #[inline(always)]
    fn of_lanes(self, number: impl Fn(usize) -> f64) -> f64 {
        number(0)
    }

    #[inline(always)]
    fn each(self, function: impl Fn(f64) -> f64) -> f64 {
        function(self)
    }

    #[inline(always)]
    fn exceeds(self, other: f64) -> bool {
        self > other
    }

    #[inline(always)]
    fn select(mask: bool, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn both(self, a: bool, b: bool) -> bool {
        a & b
    }

    #[inline(always)]
    fn either(self, a: bool, b: bool) -> bool {
        a | b
    }

    #[inline(always)]
    fn anywhere(self, mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn everywhere(self, mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn holds(self, mask: bool, _: usize) -> bool {
        mask
    }

    #[inline(always)]
    fn lane(&self, _: usize) -> f64 {
        *self
    }

    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: f64) {
        *self = value;
    }
}
