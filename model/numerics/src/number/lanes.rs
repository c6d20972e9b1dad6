//! Several numbers in one SIMD register.

use super::Number;
use pulp::Simd;
use pulp::bytemuck::{cast, cast_slice, cast_slice_mut};
use std::fmt;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use std::slice;

/// The sign bit of an f64.
const SIGN: u64 = 1 << 63;

/// As many numbers as a SIMD register holds: 4 with AVX2, 1 on a machine whose SIMD instructions are not supported.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd> {
    /// Token for the SIMD instructions of the machine; it needs no memory.
    simd: S,
    values: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// Returns `value` in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Lanes<S> {
        Lanes { simd, values: simd.splat_f64s(value) }
    }

    #[inline(always)]
    fn with(self, values: S::f64s) -> Lanes<S> {
        Lanes { simd: self.simd, values }
    }

    /// The numbers in the order of the lanes.
    #[inline(always)]
    fn as_slice(&self) -> &[f64] {
        cast_slice(slice::from_ref(&self.values))
    }

    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [f64] {
        cast_slice_mut(slice::from_mut(&mut self.values))
    }
}

impl<S: Simd> fmt::Debug for Lanes<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_slice().fmt(f)
    }
}

impl<S: Simd> PartialEq for Lanes<S> {
    fn eq(&self, other: &Lanes<S>) -> bool {
        self.as_slice() == other.as_slice()
    }
}

macro_rules! operator {
    ($operator:ident, $method:ident, $assign:ident, $assign_method:ident, $instruction:ident) => {
        impl<S: Simd> $operator for Lanes<S> {
            type Output = Lanes<S>;

            #[inline(always)]
            fn $method(self, other: Lanes<S>) -> Lanes<S> {
                self.with(self.simd.$instruction(self.values, other.values))
            }
        }

        impl<S: Simd> $operator<f64> for Lanes<S> {
            type Output = Lanes<S>;

            #[inline(always)]
            fn $method(self, other: f64) -> Lanes<S> {
                self.with(self.simd.$instruction(self.values, self.simd.splat_f64s(other)))
            }
        }

        impl<S: Simd> $assign for Lanes<S> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Lanes<S>) {
                self.values = self.simd.$instruction(self.values, other.values);
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign, add_f64s);
operator!(Sub, sub, SubAssign, sub_assign, sub_f64s);
operator!(Mul, mul, MulAssign, mul_assign, mul_f64s);
operator!(Div, div, DivAssign, div_assign, div_f64s);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Lanes<S>;

    #[inline(always)]
    fn neg(self) -> Lanes<S> {
        // `neg_f64s`, `abs_f64s` and `select_f64s` are compiled separately, without the machine's SIMD instructions, so they would be called as
        // functions instead of inlined.
        self.with(self.simd.xor_f64s(self.values, self.simd.splat_f64s(-0.0)))
    }
}

impl<S: Simd> Number for Lanes<S> {
    type Mask = S::m64s;
    const LANES: usize = S::F64_LANES;

    #[inline(always)]
    fn constant(self, value: f64) -> Lanes<S> {
        Lanes::splat(self.simd, value)
    }

    #[inline(always)]
    fn sqrt(self) -> Lanes<S> {
        self.with(self.simd.sqrt_f64s(self.values))
    }

    #[inline(always)]
    fn abs(self) -> Lanes<S> {
        self.with(self.simd.and_f64s(self.values, self.simd.splat_f64s(f64::from_bits(!SIGN))))
    }

    #[inline(always)]
    fn larger(self, other: Lanes<S>) -> Lanes<S> {
        // The SIMD maximum instructions of different machines give different results for NaN; selections give the same result.
        let self_or_other = Lanes::select(self.exceeds(other), self, other);
        Lanes::select(other.or_above(other), self_or_other, self)
    }

    #[inline(always)]
    fn of_lanes(mut self, number: impl Fn(usize) -> f64) -> Lanes<S> {
        for (lane, value) in self.as_mut_slice().iter_mut().enumerate() {
            *value = number(lane);
        }
        self
    }

    #[inline(always)]
    fn each(mut self, function: impl Fn(f64) -> f64) -> Lanes<S> {
        for value in self.as_mut_slice() {
            *value = function(*value);
        }
        self
    }

    #[inline(always)]
    fn exceeds(self, other: Lanes<S>) -> S::m64s {
        self.simd.greater_than_f64s(self.values, other.values)
    }

    #[inline(always)]
    fn select(mask: S::m64s, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        yes.with(cast(yes.simd.select_u64s(mask, cast(yes.values), cast(no.values))))
    }

    #[inline(always)]
    fn both(self, a: S::m64s, b: S::m64s) -> S::m64s {
        self.simd.and_m64s(a, b)
    }

    #[inline(always)]
    fn either(self, a: S::m64s, b: S::m64s) -> S::m64s {
        self.simd.or_m64s(a, b)
    }

    #[inline(always)]
    fn anywhere(self, mask: S::m64s) -> bool {
        self.simd.first_true_m64s(mask) < S::F64_LANES
    }

    #[inline(always)]
    fn everywhere(self, mask: S::m64s) -> bool {
        self.simd.first_true_m64s(self.simd.not_m64s(mask)) >= S::F64_LANES
    }

    #[inline(always)]
    fn holds(self, mask: S::m64s, lane: usize) -> bool {
        Lanes::select(mask, self.constant(1.0), self.constant(0.0)).lane(lane) > 0.5
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.as_slice()[lane]
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self.as_mut_slice()[lane] = value;
    }
}

impl<S: Simd> Lanes<S> {
    /// Lanes in which `self` is at least `other`; `false` if either is NaN. Comparing a number with itself by this function gives `false` only for
    /// NaN.
    #[inline(always)]
    fn or_above(self, other: Lanes<S>) -> S::m64s {
        self.simd.greater_than_or_equal_f64s(self.values, other.values)
    }
}
