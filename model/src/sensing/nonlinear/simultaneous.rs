//! Simultaneous correction of forces and shape, for a starting point near a minimum.
//!
//! Each step factors the tangent once. Each step corrects the shape by Newton's method, then the forces by the Gauss-Newton method with derivatives
//! from the same tangent. The derivatives lag one correction behind the shape, but Newton's method and the Gauss-Newton method still converge
//! quadratically. For a frame of a stream, three or four linearisations suffice, and no equilibrium is computed for each trial of the forces.

use super::{NonlinearEstimator, SETTLED_ANGLE_DEG, State};
use crate::measurement::Measurement;

/// The correction fails after this number of steps. From one camera frame to the next, the correction needs three or four steps.
const MAX_STEPS: usize = 12;
/// The minimum is not near if the first correction turns a node by more than this angle, rad.
const LARGEST_TURN: f64 = 0.3;
/// The minimum is not near if all later corrections together turn the nodes by more than this share of the turn in the first correction. A load step
/// in `statics` has a limit of the same kind. The tangent predicts a smooth path, but not a snap to another branch.
const LATER_TURNS: f64 = 0.5;
/// Negligible angle, rad, by which later corrections may always turn nodes.
const TURN_NOISE: f64 = 1e-4;
/// The unknowns have converged if the last step changes each unknown by at most this share of its scale. The derivatives lag one correction behind
/// the shape, so the step has a relative error of about 1 %.
const SETTLED_STEP: f64 = 1e-8;
/// The shape has converged if the rotation in its last correction is at most this share of the largest rotation. After the last correction, the error
/// of the shape is of second order, but the derivatives do not include this correction.
const SETTLED_TURN: f64 = 1e-5;

impl NonlinearEstimator<'_> {
    /// Corrects a state with known derivatives, and returns the number of steps. If the minimum is not near, returns `None`, and the state is
    /// unusable.
    pub(super) fn correct(
        &mut self,
        state: &mut State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Option<usize> {
        let (mut first_turn, mut later_turns) = (0.0, 0.0);
        // The given state is in equilibrium.
        let mut turn = 0.0;
        for steps in 1..=MAX_STEPS {
            state.solve(measurement, 0.0).ok()?;
            let change = self.relative_change(state);
            let normal_turn_deg = self.advance(state).ok()?;
            let shape_settled = turn <= SETTLED_TURN * state.motion.largest_rotation();
            if change <= SETTLED_STEP && shape_settled && normal_turn_deg <= SETTLED_ANGLE_DEG {
                return Some(steps);
            }
            turn = self.statics.corrected(&mut state.motion, &state.loads)?;
            match steps {
                1 => first_turn = turn,
                _ => later_turns += turn,
            }
            if first_turn > LARGEST_TURN || later_turns > LATER_TURNS * first_turn + TURN_NOISE {
                return None;
            }
            self.differentiate(state).ok()?;
            state.weigh(measurement, noise_mm);
        }
        None
    }
}
