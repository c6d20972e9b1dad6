//! Number of correct digits of a solution after rounding.
//!
//! The stiffness of an element grows as 1 / h^3 with its length h, and its deformation shrinks with h. Finer meshes therefore lose more digits to
//! cancellation. Newton's corrections recover the digits that the factored tangent loses, but not the digits that the residual loses.

use super::load_step::FEWEST_DIGITS;
use super::newton::share;
use super::{Equilibrium, EquilibriumEquations, Statics, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion};

/// If the last correction is below this share of the solution, the solution has one digit more than required. The margin of one digit exists because
/// the error may exceed the correction.
const SMALL_CORRECTION: f64 = 1e-5;
/// Number of decimal digits of a number in double precision.
const ALL_DIGITS: f64 = 15.65;
/// With fewer correct digits than this number, no Newton correction falls below the threshold of rounding noise, 1e-6 of the solution.
const FEWEST_NEWTON_DIGITS: f64 = 5.0;
/// Load factor so small that every frame is linear to all digits. A factor of 1e-12 is too large: under 1e-12 N, a plate of 0.01 mm thickness is not
/// linear to all digits.
const HARDLY_ANY_LOAD: f64 = 1e-20;

impl<E: EquilibriumEquations> Statics<E> {
    /// Equilibrium under dead loads, computed by continuation from rest, with at least four correct digits. Linearises one more time than
    /// [`equilibrium`](Statics::equilibrium), unless the last correction already proves that enough digits are correct.
    ///
    /// # Errors
    /// [`StaticsError`] as for [`equilibrium`](Statics::equilibrium), and [`StaticsError::TooFewDigits`] for fewer than four digits.
    pub fn accurate_equilibrium(&mut self, loads: &[FrameLoad]) -> Result<Equilibrium, StaticsError> {
        let found = self.equilibrium(loads)?;
        let linear = self.equations().kinematics() == Kinematics::Linear;
        if self.last_correction <= SMALL_CORRECTION || (linear && self.equations().keeps_digits()) {
            return Ok(found);
        }
        let digits = self.digits_left(&found.motion, loads);
        if digits < FEWEST_DIGITS { Err(StaticsError::TooFewDigits { digits }) } else { Ok(found) }
    }

    /// Number of correct decimal digits of an equilibrium, 0 to 15.65. The number follows from the effect of one more correction: the larger of the
    /// relative changes in energy norm and in displacement.
    ///
    /// The number is an estimate. For linear solutions with known error, the estimate is at most 0.3 digits too high. The estimate may be three or
    /// four digits too low, because the energy norm includes noise in single elements that barely moves any node.
    ///
    /// Source: corrections as error estimates, Higham, Accuracy and Stability of Numerical Algorithms, ch. 12.
    pub fn digits_left(&mut self, motion: &FrameMotion, loads: &[FrameLoad]) -> f64 {
        self.digits_under(motion, loads, 1.0)
    }

    /// Fails if rounding leaves too few digits for Newton's method to converge, even under so small a load that the frame is linear.
    pub(super) fn require_digits_at_rest(&mut self, loads: &[FrameLoad]) -> Result<(), StaticsError> {
        let mut motion = self.equations().at_rest();
        if !self.equations_mut().linearise(&motion, loads, HARDLY_ANY_LOAD) {
            return Err(StaticsError::NotHeld);
        }
        self.equations_mut().correct(&mut motion);
        let digits = self.digits_under(&motion, loads, HARDLY_ANY_LOAD);
        if digits < FEWEST_NEWTON_DIGITS { Err(StaticsError::TooFewDigits { digits }) } else { Ok(()) }
    }

    fn digits_under(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> f64 {
        if !self.equations_mut().linearise(motion, loads, factor) {
            return 0.0;
        }
        let energy = self.equations().elastic_energy();
        let mut corrected = motion.clone();
        let work = self.equations_mut().correct(&mut corrected);
        let pairs = corrected.displacements.iter().zip(&motion.displacements);
        let moved = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let change = share(work.abs(), 2.0 * energy).sqrt().max(share(moved, motion.largest_displacement()));
        (-change.log10()).clamp(0.0, ALL_DIGITS)
    }
}
