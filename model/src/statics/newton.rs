//! Newton's method: the equilibrium under one load, near the one before it.
//!
//! Every load step must keep the rotations small and end in a stable equilibrium (positive definite tangent), so the solution stays on the branch
//! that starts at rest. [`LoadStep`] decides that; how long the steps are is decided in [`continuation`](super::continuation).

use super::load_step::{LoadStep, Rejected, Taken};
use super::{EquilibriumEquations, Ladder, SparseEquations, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};
use crate::mesh::Mesh;

/// Equilibrium of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Displacements and rotations.
    pub motion: FrameMotion,
    /// Newton iterations spent, over all load steps.
    pub iterations: usize,
    /// Load steps taken.
    pub load_steps: usize,
}

/// Solver for one structure and one kinematics; what can be prepared once is kept between loads.
#[derive(Debug, Clone)]
pub struct Statics<E> {
    pub(super) equations: E,
    /// Rotations that the tangent at the start of a load step predicts for its end.
    predicted: Vec<f64>,
    /// The last correction of the last load step over the solution, by energy norm or displacement, whichever is more.
    pub(super) last_correction: f64,
}

impl<'f> Statics<SparseEquations<'f>> {
    /// Prepares the equations of any frame: the general sparse path.
    pub fn sparse(frame: &'f PlaneFrame, kinematics: Kinematics) -> Self {
        Statics::new(SparseEquations::new(frame, kinematics))
    }
}

impl<'m> Statics<Ladder<'m>> {
    /// Prepares the equations of a finger: block elimination along the ladder.
    pub fn ladder(mesh: &'m Mesh, kinematics: Kinematics) -> Self {
        Statics::new(Ladder::new(mesh, kinematics))
    }
}

impl<E: EquilibriumEquations> Statics<E> {
    fn new(equations: E) -> Self {
        Statics { equations, predicted: Vec::new(), last_correction: f64::INFINITY }
    }

    /// The equations that are solved.
    pub fn equations(&self) -> &E {
        &self.equations
    }

    /// The same, for sensitivities, which need room.
    pub fn equations_mut(&mut self) -> &mut E {
        &mut self.equations
    }

    /// Makes the next linear solution factorise again, for timing: the stiffness never changes, so one factor serves.
    pub fn forget_factor(&mut self) {
        self.equations.forget_factor();
    }

    /// Linearises the equations at a motion under loads; `false` if it is not a stable shape.
    pub fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad]) -> bool {
        self.equations.linearise(motion, loads, 1.0)
    }

    /// One correction by Newton's method from a motion near the equilibrium under loads: the largest turn of a node, rad,
    /// or `None` if the motion is no stable shape. Leaves the factored tangent of the motion before the correction behind.
    pub fn corrected(&mut self, motion: &mut FrameMotion, loads: &[FrameLoad]) -> Option<f64> {
        if !self.equations.linearise(motion, loads, 1.0) {
            return None;
        }
        self.predicted.clone_from(&motion.rotations);
        let work = self.equations.correct(motion);
        work.is_finite().then(|| largest_difference(&motion.rotations, &self.predicted))
    }

    /// Newton's iteration at one load level, from the equilibrium before it, until the next correction would be below
    /// `tolerance`. Leaves the factored tangent of the last iterate behind, and `motion` anywhere if the step is rejected.
    pub(super) fn load_step(
        &mut self,
        motion: &mut FrameMotion,
        loads: &[FrameLoad],
        multiple: f64,
        tolerance: f64,
    ) -> Result<Taken, Rejected> {
        let linear = self.equations.kinematics() == Kinematics::Linear;
        self.last_correction = f64::INFINITY;
        let mut step = LoadStep::new(linear, tolerance);
        loop {
            if !self.equations.linearise(motion, loads, multiple) {
                return Err(Rejected::NotPositiveDefinite);
            }
            let scale = 2.0 * self.equations.elastic_energy();
            if step.is_first() && !linear {
                self.predicted.clone_from(&motion.rotations);
            }
            let work = self.equations.correct(motion);
            let turn = if linear { 0.0 } else { largest_difference(&motion.rotations, &self.predicted) };
            if step.is_first() && !linear {
                // The first correction is what the tangent at the start predicts.
                self.predicted.clone_from(&motion.rotations);
            }
            let Some(end) = step.judge(work, scale, turn, || self.equations.keeps_digits()) else { continue };
            if let Ok(Taken { correction: Some(correction), .. }) = end {
                let moved = self.equations.largest_correction();
                self.last_correction = correction.max(share(moved, motion.largest_displacement()));
            }
            return end;
        }
    }

    /// Motions of the linear structure under each load alone: columns of its compliance.
    ///
    /// # Errors
    /// [`StaticsError::NotHeld`] if the structure has no stiffness against some motion.
    pub fn unit_motions(&mut self, loads: &[FrameLoad]) -> Result<Vec<FrameMotion>, StaticsError> {
        loads.iter().map(|load| self.equilibrium(std::slice::from_ref(load)).map(|found| found.motion)).collect()
    }
}

pub(super) fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Part of a whole; nothing is no part even of nothing, as in a frame without loads. What is no number counts as all.
pub(super) fn share(part: f64, whole: f64) -> f64 {
    match part / whole {
        _ if part == 0.0 => 0.0,
        share if share.is_nan() => 1.0,
        share => share,
    }
}
