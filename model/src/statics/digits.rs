//! Digits of a solution that survive rounding.
//!
//! Elements of length h have stiffnesses that grow as 1 / h^3 and deformations that shrink with h, so finer meshes cancel
//! more digits. Newton's corrections win back what the factored tangent loses; what the residual lost stays.

use super::load_step::FEWEST_DIGITS;
use super::newton::share;
use super::{Equilibrium, EquilibriumEquations, Statics, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion};

/// A last correction this small leaves one digit more than the fewest: the next one may be larger.
const SMALL_CORRECTION: f64 = 1e-5;
/// Digits of a number in double precision.
const ALL_DIGITS: f64 = 15.65;
/// With fewer digits no correction of Newton's gets below what counts as rounding noise, 1e-6 of the solution.
const FEWEST_NEWTON_DIGITS: f64 = 5.0;
/// Share of the load under which any frame is linear to all digits: under 1e-12 of 1 N a plate of 0.01 mm was not.
const HARDLY_ANY_LOAD: f64 = 1e-20;

impl<E: EquilibriumEquations> Statics<E> {
    /// Equilibrium under dead loads, followed from rest, that has kept at least four digits. Where nothing else shows
    /// so many, it linearises once more than [`equilibrium`](Statics::equilibrium).
    ///
    /// # Errors
    /// See [`StaticsError`].
    pub fn accurate_equilibrium(&mut self, loads: &[FrameLoad]) -> Result<Equilibrium, StaticsError> {
        let found = self.equilibrium(loads)?;
        let linear = self.equations().kinematics() == Kinematics::Linear;
        if self.last_correction <= SMALL_CORRECTION || (linear && self.equations().keeps_digits()) {
            return Ok(found);
        }
        let digits = self.digits_left(&found.motion, loads);
        if digits < FEWEST_DIGITS { Err(StaticsError::TooFewDigits { digits }) } else { Ok(found) }
    }

    /// Decimal digits of an equilibrium, up to 15.65: the share that a further correction changes, by energy or size.
    ///
    /// An estimate: for linear solutions, which are known otherwise, it was at most 0.3 digits too high. The energy norm
    /// sees noise of single elements that hardly moves any node, and may state three or four digits too few.
    ///
    /// Source: corrections as estimates of errors, Higham, Accuracy and Stability of Numerical Algorithms, ch. 12.
    pub fn digits_left(&mut self, motion: &FrameMotion, loads: &[FrameLoad]) -> f64 {
        self.digits_under(motion, loads, 1.0)
    }

    /// An error if rounding leaves Newton's method too few digits to converge even where the frame is linear.
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
