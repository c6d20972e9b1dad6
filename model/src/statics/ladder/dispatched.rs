//! Elimination of one finger with the widest SIMD instructions of the machine, bitwise equal to the scalar elimination. SIMD lanes condense several
//! lines at a time; rungs are eliminated one after the other.
//!
//! Each task that uses SIMD instructions is a struct, not a closure. The compiler uses the wide instructions for code that is inlined into
//! [`WithSimd::with_simd`], but not for closures.

use super::balance::Balance;
use super::factor::Factor;
use crate::frame::FrameMotion;
use crate::number::Lanes;
use pulp::{Arch, Simd, WithSimd};

/// Runs [`Balance::factorise`] with the widest SIMD instructions.
pub(super) fn factorise(balance: &mut Balance, stiffness: &mut Factor, motion: &FrameMotion) {
    Arch::new().dispatch(Factorisation { balance, stiffness, motion });
}

/// Runs [`Balance::eliminate_gradient`] with the widest SIMD instructions.
pub(super) fn eliminate_gradient(balance: &mut Balance, stiffness: &Factor) {
    Arch::new().dispatch(Elimination { balance, stiffness });
}

/// Runs [`Balance::correct`] with the widest SIMD instructions.
pub(super) fn correct(balance: &mut Balance, stiffness: &Factor, motion: &mut FrameMotion) -> f64 {
    Arch::new().dispatch(Correction { balance, stiffness, motion })
}

struct Factorisation<'a, 'm> {
    balance: &'a mut Balance<'m>,
    stiffness: &'a mut Factor,
    motion: &'a FrameMotion,
}

impl WithSimd for Factorisation<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Factorisation { balance, stiffness, motion } = self;
        balance.condense_abreast(stiffness, motion, Lanes::splat(simd, 0.0));
        balance.eliminate_rungs(stiffness, motion);
    }
}

struct Elimination<'a, 'm> {
    balance: &'a mut Balance<'m>,
    stiffness: &'a Factor,
}

impl WithSimd for Elimination<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.balance.eliminate_gradient(self.stiffness);
    }
}

struct Correction<'a, 'm> {
    balance: &'a mut Balance<'m>,
    stiffness: &'a Factor,
    motion: &'a mut FrameMotion,
}

impl WithSimd for Correction<'_, '_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Correction { balance, stiffness, motion } = self;
        let work = balance.correct_nodes(stiffness, motion);
        balance.mend_abreast(stiffness, motion, Lanes::splat(simd, 0.0));
        work
    }
}
