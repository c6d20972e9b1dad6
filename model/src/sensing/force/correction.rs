//! Simultaneous correction of forces and shape, for a starting point near a minimum.
//!
//! Each step factors the tangent once. From this tangent follow the correction of the shape by Newton's method, the derivatives, and the change of the
//! forces by the Gauss-Newton method, which allows for the correction. Shape and forces are then corrected together, so both converge quadratically
//! if the residuals are small. For a frame of a stream, two or three linearisations replace an equilibrium for every trial.

use super::SETTLED_ANGLE_DEG;
use super::derivatives::{differentiate, look_ahead};
use super::linearised::Seen;
use super::problem::{ForceProblem, State};
use crate::finger::Plate;

/// The correction fails after this number of steps. From one camera frame to the next, the correction needs three or four steps.
const MAX_STEPS: usize = 12;
/// The minimum is not near if the first correction turns a node by more than this angle, rad.
const LARGEST_TURN: f64 = 0.3;
/// The minimum is not near if all later corrections together turn the nodes by more than this share of the turn in the first correction. A load step
/// in `statics` has a limit of the same kind. The tangent predicts a smooth path, but not a snap to another branch.
const LATER_TURNS: f64 = 0.5;
/// Negligible angle, rad, by which later corrections may always turn nodes.
const TURN_NOISE: f64 = 1e-4;
/// The unknowns have converged if the last step changes each unknown by at most this share of its scale.
const SETTLED_STEP: f64 = 1e-8;
/// The shape has converged if the rotation in its last correction is at most this share of the largest rotation. After the last correction, the error
/// of the shape is of second order, but the derivatives do not include this correction.
const SETTLED_TURN: f64 = 1e-5;
/// A correction that may stop below the noise stops if the next step is expected to move the markers by at most this many standard deviations. Shape and
/// unknowns converge quadratically, so their error is smaller still.
const NEGLIGIBLE_SIGMAS: f64 = 5e-3;
/// The derivatives then lag by at most this share of the largest rotation, and standard deviations have a relative error of this order.
const LARGEST_LAG: f64 = 1e-4;

/// Changes of shape and unknowns in the steps of a correction.
#[derive(Default)]
struct Progress {
    /// Largest rotation of a node in the first correction of the shape and in the last, rad, and the sum over all but the first.
    first_turn: f64,
    last_turn: f64,
    later_turns: f64,
    /// First-order motion of the markers in the last step, mm.
    last_moved_mm: f64,
    /// The last motion and the last turn, each as a share of the one before; 1 after the first step.
    moved_share: f64,
    turn_share: f64,
}

impl Progress {
    /// Adds a step, and returns whether the minimum may still be near.
    fn is_near_after(&mut self, moved_mm: f64, turn: f64) -> bool {
        match self.last_turn == 0.0 {
            true => self.first_turn = turn,
            false => self.later_turns += turn,
        }
        self.moved_share = (moved_mm / self.last_moved_mm).min(1.0);
        self.turn_share = (turn / self.last_turn).min(1.0);
        (self.last_moved_mm, self.last_turn) = (moved_mm, turn);
        self.first_turn <= LARGEST_TURN && self.later_turns <= LATER_TURNS * self.first_turn + TURN_NOISE
    }

    /// Whether the next step is expected to move the markers of a finger of length `length_mm` by at most `negligible_mm`, if steps shrink further by
    /// the same factor.
    fn is_negligible_after(&self, length_mm: f64, negligible_mm: f64) -> bool {
        let next_mm = (self.last_moved_mm * self.moved_share).max(self.last_turn * self.turn_share * length_mm);
        next_mm <= negligible_mm
    }
}

/// Corrects a state in equilibrium with known derivatives, and returns the number of steps. If the minimum is not near, returns `None`, and the state
/// is unusable.
pub(super) fn correct(problem: &mut ForceProblem, state: &mut State, seen: Seen) -> Option<usize> {
    corrected(problem, state, seen, 0.0)
}

/// Corrects a state like [`correct`], but only until the next step is expected to be negligible compared with the noise.
pub(super) fn correct_below_noise(problem: &mut ForceProblem, state: &mut State, seen: Seen) -> Option<usize> {
    corrected(problem, state, seen, NEGLIGIBLE_SIGMAS * seen.marker_noise_mm.unwrap_or(0.0))
}

fn corrected(problem: &mut ForceProblem, state: &mut State, seen: Seen, negligible_mm: f64) -> Option<usize> {
    let (mut progress, mut before) = (Progress::default(), Vec::new());
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let follows_shape = problem.loads_follow_plate();
    for steps in 1..=MAX_STEPS {
        let moved_mm = state.solve(seen.measurement, 0.0).ok()?.decrease.max(0.0).sqrt();
        let change = problem.relative_change(state);
        before.clone_from(&state.loads);
        let normal_turn_deg = problem.advance(state).ok()?;
        if steps == 1 && change <= SETTLED_STEP && normal_turn_deg <= SETTLED_ANGLE_DEG {
            return Some(steps);
        }
        let turn = match state.unit_motions.take() {
            Some(unit_motions) => state.move_by_forces(&unit_motions),
            // In the first step, nothing is factored yet.
            None if steps == 1 || problem.object.is_some() => {
                problem.statics.corrected(&mut state.motion, &state.loads)?
            }
            None => problem.statics.corrected_under(&mut state.motion, &before, &state.loads)?,
        };
        progress.is_near_after(moved_mm, turn).then_some(())?;
        // Directions follow the shape before its correction.
        let direction_turn_deg = normal_turn_deg.max(if follows_shape { turn.to_degrees() } else { 0.0 });
        let lags_by = |share: f64| turn <= share * state.motion.largest_rotation();
        let is_settled = change <= SETTLED_STEP && lags_by(SETTLED_TURN)
            || progress.is_negligible_after(length_mm, negligible_mm) && lags_by(LARGEST_LAG);
        if is_settled && direction_turn_deg <= SETTLED_ANGLE_DEG {
            state.linearised.is_in_equilibrium();
            return Some(steps);
        }
        match problem.object {
            None => look_ahead(problem, state)?,
            Some(_) => differentiate(problem, state).ok()?,
        }
        state.weigh(seen);
    }
    None
}
