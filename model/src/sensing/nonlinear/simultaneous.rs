//! The way to a minimum that is near: forces and shape corrected together.
//!
//! Each step factors the tangent once. It corrects the shape by Newton's method, then the forces by Gauss and Newton's
//! with the derivatives that the same tangent gives: these lag one correction behind, and both still converge
//! quadratically. A frame of a stream costs three or four linearisations instead of a solution for every trial.

use super::{NonlinearEstimator, SETTLED_ANGLE_DEG, State};
use crate::measurement::Measurement;

/// Most steps; from frame to frame there are three or four.
const MAX_STEPS: usize = 12;
/// Turn of a node in the first correction, rad, above which the minimum is not near.
const LARGEST_TURN: f64 = 0.3;
/// All later corrections together may turn nodes by this share of the first, as in a load step of the statics: a
/// smooth path is predicted by its tangent, a snap to another branch is not.
const LATER_TURNS: f64 = 0.5;
/// Turn, rad, that counts as none in that comparison.
const TURN_NOISE: f64 = 1e-4;
/// Last step, as a share of each unknown's scale. The derivatives lag, so it is wrong by about a hundredth of itself.
const SETTLED_STEP: f64 = 1e-8;
/// Last correction of the shape, as a share of the largest rotation. The residual error of the shape is of the order
/// of its square, and the derivatives lag by it.
const SETTLED_TURN: f64 = 1e-5;

impl NonlinearEstimator<'_> {
    /// Corrects a state whose derivatives are there; `None` if the minimum is not near, the state then being anywhere. Otherwise the number of steps.
    pub(super) fn correct(
        &mut self,
        state: &mut State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Option<usize> {
        let (mut first_turn, mut later_turns) = (0.0, 0.0);
        // The state is in equilibrium.
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
