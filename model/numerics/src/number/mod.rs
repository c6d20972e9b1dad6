//! What equations are written in: one number, or several side by side that go through the same instructions.
//!
//! Both compute alike: additions, products, quotients and roots are rounded each by itself (nothing is contracted to a
//! fused multiply-add), and other functions are evaluated by the same operations. So a lane of [`Lanes`] holds, bit for
//! bit, what an `f64` would, whatever its neighbours hold and whatever the machine.

mod arctangent;
mod lanes;
mod sine;

pub use arctangent::arctangent;
pub use lanes::Lanes;
pub use sine::sine_and_versine;

use nalgebra::Scalar;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number, or several: one a lane.
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
    /// A truth value a lane.
    type Mask: Copy + Debug;
    /// How many numbers there are.
    const LANES: usize;

    /// Another number, the same in each lane. Not from nothing: only a number knows by what instructions it computes.
    fn constant(self, value: f64) -> Self;

    /// The square root.
    fn sqrt(self) -> Self;

    /// The absolute value.
    fn abs(self) -> Self;

    /// The larger of two; the other one where one is not a number.
    fn larger(self, other: Self) -> Self;

    /// Another number: in each lane what is given for it.
    fn of_lanes(self, number: impl Fn(usize) -> f64) -> Self;

    /// A function of one number, lane by lane.
    fn each(self, function: impl Fn(f64) -> f64) -> Self;

    /// Where it is larger; `false` where one is not a number.
    fn exceeds(self, other: Self) -> Self::Mask;

    /// `yes` where the mask holds, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Where both hold.
    fn both(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// Where one of them holds.
    fn either(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// Whether a mask holds in any lane.
    fn anywhere(self, mask: Self::Mask) -> bool;

    /// Whether a mask holds in all lanes.
    fn everywhere(self, mask: Self::Mask) -> bool;

    /// Whether a mask holds in a lane.
    fn holds(self, mask: Self::Mask, lane: usize) -> bool;

    /// The number in a lane.
    fn lane(&self, lane: usize) -> f64;

    /// Overwrites the number in a lane.
    fn set_lane(&mut self, lane: usize, value: f64);

    /// Zero in each lane.
    #[inline(always)]
    fn zero(self) -> Self {
        self.constant(0.0)
    }

    /// A mask that holds everywhere.
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
