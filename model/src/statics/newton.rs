//! Newton's method: the equilibrium under one load, near the one before it.
//!
//! Every load step must keep the rotations small and end in a stable equilibrium (positive definite tangent), so the
//! solution stays on the branch that starts at rest. [`LoadStep`] decides that; how long the steps are is decided in
//! [`load_path`](super::load_path).

use super::digits;
use super::load_path::{Growing, Shifting, Tried};
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
    /// The last correction of the last load step, as a share of the solution: by energy norm or by displacement, whichever
    /// is more. What is left to correct is less, or as much if it is rounding noise.
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

    /// Makes the next linear solution factorise again. Its stiffness never changes, so one factor serves all loads; this
    /// is for timing a factorisation.
    pub fn forget_factor(&mut self) {
        self.equations.forget_factor();
    }

    /// Equilibrium under dead loads, followed from rest.
    ///
    /// # Errors
    /// See [`StaticsError`].
    pub fn equilibrium(&mut self, loads: &[FrameLoad]) -> Result<Equilibrium, StaticsError> {
        self.continued(&self.equations.at_rest(), loads, 0.0, 1.0)
    }

    /// Equilibria under growing multiples of the loads, each followed from the one before it; the first from rest.
    ///
    /// The list ends before the first multiple that has no equilibrium; the second part says why.
    pub fn path(&mut self, loads: &[FrameLoad], multiples: &[f64]) -> (Vec<Equilibrium>, Option<StaticsError>) {
        let mut found: Vec<Equilibrium> = Vec::with_capacity(multiples.len());
        let mut motion = self.equations.at_rest();
        let mut from = 0.0;
        for &to in multiples {
            match self.continued(&motion, loads, from, to) {
                Ok(equilibrium) => {
                    motion.clone_from(&equilibrium.motion);
                    found.push(equilibrium);
                    from = to;
                }
                Err(error) => return (found, Some(error)),
            }
        }
        (found, None)
    }

    /// Equilibrium under `to` times the loads, followed from one under `from` times the loads.
    ///
    /// # Errors
    /// See [`StaticsError`]; the converged fraction refers to `to`.
    pub fn continued(
        &mut self,
        start: &FrameMotion,
        loads: &[FrameLoad],
        from: f64,
        to: f64,
    ) -> Result<Equilibrium, StaticsError> {
        if !loads.iter().all(FrameLoad::is_finite) || !from.is_finite() || !to.is_finite() {
            return Err(StaticsError::LoadNotFinite);
        }
        let growing = Growing { loads, from, to };
        let found = self.follow(start, growing);
        let Err(StaticsError::NoEquilibrium { converged_fraction }) = found else { return found };
        Err(StaticsError::NoEquilibrium { converged_fraction: growing.multiple(converged_fraction) / to })
    }

    /// Equilibrium under the loads `to`, followed from one under the loads `from` while the first fade and the second
    /// grow.
    ///
    /// # Errors
    /// See [`StaticsError`]; the converged fraction is that of the way.
    pub fn shifted(
        &mut self,
        start: &FrameMotion,
        from: &[FrameLoad],
        to: &[FrameLoad],
    ) -> Result<Equilibrium, StaticsError> {
        if !from.iter().chain(to).all(FrameLoad::is_finite) {
            return Err(StaticsError::LoadNotFinite);
        }
        self.follow(start, Shifting { from, to, loads: Vec::with_capacity(from.len() + to.len()) })
    }

    /// As [`shifted`](Statics::shifted), for a caller who shortens the way where it fails: the end of a branch is not sought
    /// closely, and the way is also given up at an equilibrium that is not worth going on from.
    ///
    /// # Errors
    /// See [`StaticsError`]; the converged fraction is that of the way.
    pub(crate) fn tried(
        &mut self,
        start: &FrameMotion,
        [from, to]: [&[FrameLoad]; 2],
        most_rejected: usize,
        goes_on: impl FnMut(f64, &FrameMotion) -> bool,
    ) -> Result<Equilibrium, StaticsError> {
        if !from.iter().chain(to).all(FrameLoad::is_finite) {
            return Err(StaticsError::LoadNotFinite);
        }
        let shifting = Shifting { from, to, loads: Vec::with_capacity(from.len() + to.len()) };
        self.follow(start, Tried { shifting, goes_on, most_rejected })
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
                self.last_correction = correction.max(digits::share(moved, motion.largest_displacement()));
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
