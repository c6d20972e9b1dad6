//! Newton's method, which finds the equilibrium under one load from a nearby equilibrium.
//!
//! Every load step keeps the rotations small and ends in a stable equilibrium (positive definite tangent). The solution therefore stays on the branch
//! of equilibria that starts at the undeformed state. [`LoadStep`] accepts or rejects steps; [`continuation`](super::continuation) sets their length.

use super::load_step::{LoadStep, Rejected, Taken};
use super::{EquilibriumEquations, Ladder, SparseEquations, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};
use crate::mesh::Mesh;

/// An equilibrium of a frame, and the number of steps that led to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Displacements (mm) and rotations (rad) of the frame.
    pub motion: FrameMotion,
    /// Number of Newton iterations over all load steps.
    pub iterations: usize,
    /// Number of accepted load steps.
    pub load_steps: usize,
}

/// Tangent of Newton's method in a load step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Newton {
    /// The tangent stiffness at each motion.
    Exact,
    /// The tangent of [`relinearise`](EquilibriumEquations::relinearise), from the second iteration on.
    Mixed,
}

/// Solver for one structure with one kind of kinematics. The solver stores all data that do not depend on the loads.
#[derive(Debug, Clone)]
pub struct Statics<E> {
    pub(super) equations: E,
    /// Rotations at the end of a load step as predicted by the tangent at its start, rad.
    predicted: Vec<f64>,
    /// Ratio of the last correction to the solution, dimensionless: the larger of the ratios in energy norm and in displacement.
    pub(super) last_correction: f64,
}

impl<'f> Statics<SparseEquations<'f>> {
    /// Prepares the equations of any frame for the sparse solver.
    pub fn sparse(frame: &'f PlaneFrame, kinematics: Kinematics) -> Self {
        Statics::new(SparseEquations::new(frame, kinematics))
    }
}

impl<'m> Statics<Ladder<'m>> {
    /// Prepares the equations of a finger for block elimination along its ladder of plates and ribs.
    pub fn ladder(mesh: &'m Mesh, kinematics: Kinematics) -> Self {
        Statics::new(Ladder::new(mesh, kinematics))
    }

    /// Makes one Newton correction to the last linearised motion, to the equilibrium under the loads `after`. `before` are the loads of the linearisation.
    /// Returns the largest rotation of a node by the correction, rad, or `None` if the correction is not finite.
    pub fn corrected_under(
        &mut self,
        motion: &mut FrameMotion,
        before: &[FrameLoad],
        after: &[FrameLoad],
    ) -> Option<f64> {
        self.equations.change_loads(motion, before, after, (0.0, motion));
        self.turned_by_correction(motion)
    }
}

impl<E: EquilibriumEquations> Statics<E> {
    fn new(equations: E) -> Self {
        Statics { equations, predicted: Vec::new(), last_correction: f64::INFINITY }
    }

    /// The equilibrium equations that this solver solves.
    pub fn equations(&self) -> &E {
        &self.equations
    }

    /// The equilibrium equations, mutable because the computation of sensitivities uses their buffers.
    pub fn equations_mut(&mut self) -> &mut E {
        &mut self.equations
    }

    /// Linearises the equations at a motion under loads. Returns `false` if the tangent stiffness is not positive definite.
    pub fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad]) -> bool {
        self.equations.linearise(motion, loads, 1.0)
    }

    /// Makes one Newton correction to a motion near the equilibrium under the loads. Returns the largest rotation of a node by the correction, rad, or `None`
    /// if the tangent is not positive definite. The factored tangent of the uncorrected motion remains available.
    pub fn corrected(&mut self, motion: &mut FrameMotion, loads: &[FrameLoad]) -> Option<f64> {
        if !self.equations.linearise(motion, loads, 1.0) {
            return None;
        }
        self.turned_by_correction(motion)
    }

    /// Adds Newton's correction to the linearised motion. Returns the largest rotation of a node, rad, or `None` if the correction is not finite.
    fn turned_by_correction(&mut self, motion: &mut FrameMotion) -> Option<f64> {
        self.predicted.clone_from(&motion.rotations);
        let work = self.equations.correct(motion);
        work.is_finite().then(|| largest_difference(&motion.rotations, &self.predicted))
    }

    /// Iterates Newton's method at one load level, starting from the previous equilibrium, until the predicted next correction is below `tolerance`.
    /// The factored tangent of the last linearisation remains available. After a rejected step, the value of `motion` is undefined.
    pub(super) fn load_step(
        &mut self,
        motion: &mut FrameMotion,
        loads: &[FrameLoad],
        multiple: f64,
        tolerance: f64,
        newton: Newton,
    ) -> Result<Taken, Rejected> {
        let linear = self.equations.kinematics() == Kinematics::Linear;
        self.last_correction = f64::INFINITY;
        let mut step = LoadStep::new(linear, tolerance);
        loop {
            // Extrapolated forces may be larger than those of any stable equilibrium, so only the exact tangent rejects a step.
            let is_mixed = newton == Newton::Mixed && !step.is_first();
            let is_positive = is_mixed && self.equations.relinearise(motion, loads, multiple)
                || self.equations.linearise(motion, loads, multiple);
            if !is_positive {
                return Err(Rejected::NotPositiveDefinite);
            }
            let scale = 2.0 * self.equations.elastic_energy();
            if step.is_first() && !linear {
                self.predicted.clone_from(&motion.rotations);
            }
            let work = self.equations.correct(motion);
            let turn = if linear { 0.0 } else { largest_difference(&motion.rotations, &self.predicted) };
            if step.is_first() && !linear {
                // The first correction gives the rotations that the tangent at the start of the step predicts.
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

    /// Motions of the structure under each load alone. With linear kinematics and unit loads, these motions are columns of the structure's compliance
    /// matrix.
    ///
    /// # Errors
    /// [`StaticsError`] as for [`equilibrium`](Statics::equilibrium), for instance [`StaticsError::NotHeld`] if the structure is a mechanism.
    pub fn unit_motions(&mut self, loads: &[FrameLoad]) -> Result<Vec<FrameMotion>, StaticsError> {
        loads.iter().map(|load| self.equilibrium(std::slice::from_ref(load)).map(|found| found.motion)).collect()
    }
}

pub(super) fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Ratio of a part to a whole. Returns 0 if `part` is 0, even if `whole` is also 0, as in an unloaded frame; returns 1 if the ratio is NaN.
pub(super) fn share(part: f64, whole: f64) -> f64 {
    match part / whole {
        _ if part == 0.0 => 0.0,
        share if share.is_nan() => 1.0,
        share => share,
    }
}
