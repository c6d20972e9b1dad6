//! Automatic refinement of a scene's lattice: the segments of the plate are halved until the total contact force of every step hardly changes.

use super::{ContactScene, SceneStep};
use crate::prelude::*;
use finray_lattice::pressing::{Pressing, Push};

/// Largest relative difference of a total contact force between a sufficiently fine lattice and a lattice half as fine.
pub const TOTAL_TOLERANCE: f64 = 1e-3;
/// The change of a total is divided by the total, but at least by this share of the scene's largest total.
const SMALL: f64 = 0.1;
/// Number of segments of the front plate in the first lattice.
const FIRST_SEGMENTS: usize = 36;
/// Largest number of segments of the front plate.
const MOST_SEGMENTS: usize = 600;

/// Lattice on which the steps of a scene are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// Number of segments in a plate member of mean length.
    pub fineness: usize,
    /// Largest change of a total compared with the lattice half as fine; `None` if the coarser lattice was not computed.
    pub change: Option<TotalChange>,
}

/// Difference of a step's total between two lattices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TotalChange {
    /// Number of the step, from 1.
    pub step: usize,
    /// Difference relative to the total.
    pub share: f64,
}

impl TotalChange {
    /// Largest change of a step's total from a lattice to a finer lattice. A step that only one of the two lattices reaches counts as a change of 100
    /// %.
    pub fn largest(coarse: &[SceneStep], fine: &[SceneStep]) -> Option<TotalChange> {
        let largest_n = fine.iter().map(|step| step.total_n().abs()).fold(0.0, f64::max);
        let share = |(coarse, fine): (&SceneStep, &SceneStep)| {
            let change_n = (coarse.total_n() - fine.total_n()).abs();
            if change_n == 0.0 { 0.0 } else { change_n / fine.total_n().abs().max(SMALL * largest_n) }
        };
        let shares = coarse.iter().zip(fine).map(share);
        let changes = shares.enumerate().map(|(index, share)| TotalChange { step: index + 1, share });
        let missing =
            (coarse.len() != fine.len()).then_some(TotalChange { step: coarse.len().min(fine.len()) + 1, share: 1.0 });
        changes.chain(missing).max_by(|a, b| a.share.total_cmp(&b.share))
    }
}

/// Steps up to the end or to an error, together with the error if there is one.
pub(super) type Pressed = (Vec<SceneStep>, Option<LatticeError>);

impl ContactScene {
    /// Runs the scene and passes every step to `each`. Without a requested fineness, segments are halved until no total changes by more than
    /// [`TOTAL_TOLERANCE`], or until the largest number of segments is reached.
    ///
    /// # Errors
    /// [`LatticeError`] if the object overlaps the finger at the start, or a step has no equilibrium. On an error, `each` has received the steps
    /// before the failed step.
    pub fn run(&self, mut each: impl FnMut(SceneStep)) -> Result<Refinement, LatticeError> {
        let members = self.finger().rib_count() + 1;
        let mut fineness = self.fineness.unwrap_or_else(|| FIRST_SEGMENTS.div_ceil(members));
        let (mut steps, mut stopped) = self.press(fineness);
        let (mut change, mut finer) = (None, 2 * fineness);
        while self.fineness.is_none() && finer * members <= MOST_SEGMENTS {
            let (their_steps, their_end) = self.press(finer);
            let their_change = TotalChange::largest(&steps, &their_steps);
            // Near a change of contacts, a step can fail on one lattice and succeed on the other lattice.
            if their_steps.len() >= steps.len() {
                (steps, stopped, fineness, change) = (their_steps, their_end, finer, their_change);
            }
            if their_change.is_none_or(|change| change.share <= TOTAL_TOLERANCE) {
                break;
            }
            finer *= 2;
        }
        steps.into_iter().for_each(&mut each);
        stopped.map_or(Ok(Refinement { fineness, change }), Err)
    }

    pub(super) fn press(&self, fineness: usize) -> Pressed {
        let mut steps = Vec::new();
        let outcome = self.press_each(fineness, &mut steps);
        (steps, outcome.err())
    }

    fn press_each(&self, fineness: usize, pressed: &mut Vec<SceneStep>) -> Result<(), LatticeError> {
        let lattice = Lattice::new(self.finger(), fineness)?;
        let object = (self.object.outline.shape(), self.object.friction);
        let (start, rod_radius_mm) = (self.object.start, self.scene.contact.rod_radius_mm);
        let mut pressing = Pressing::new(&lattice, rod_radius_mm, object, start, self.object.along)?;
        let (mut travel_mm, mut last) = (0.0, start);
        for step in &self.object.steps {
            for &corner in &step.corners {
                pressing.pass(Push::To(corner))?;
                travel_mm += (corner - last).norm();
                last = corner;
            }
            let found = pressing.push(step.end)?;
            travel_mm += (found.object - last).norm();
            last = found.object;
            let baseline_mm =
                |touch: &_| super::baseline_mm(self.finger(), rod_radius_mm, &self.object.outline, found.object, touch);
            let contacts = super::seen_contacts(&lattice, &found.touches, baseline_mm);
            let stopped_mm = if let Push::To(told) = step.end { (told - found.object).norm() } else { 0.0 };
            pressed.push(SceneStep { travel_mm, stopped_mm, along: step.along, contacts, pressed: found });
        }
        Ok(())
    }
}
