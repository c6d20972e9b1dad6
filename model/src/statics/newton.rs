//! Newton's method along the load path.
//!
//! The load grows from rest in steps that adapt themselves. Every step must keep the rotations small and end in a
//! stable equilibrium (positive definite tangent), so the solution stays on the branch that starts at rest; where that
//! branch ends, the last load that could be carried is reported.

use super::{Assembly, Factor, FrameLoad, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameMotion, PlaneFrame};

/// Newton has converged when the energy norm of its last correction is below this share of the solution's. Newton
/// squares the error with every step, so applying that correction leaves rounding alone.
const CORRECTION_TOLERANCE: f64 = 1e-9;
/// A correction this small that no longer shrinks is rounding noise of a fine mesh.
const STAGNATION_TOLERANCE: f64 = 1e-6;
/// More iterations than this mean that the step was too long.
const MAX_ITERATIONS: usize = 20;
/// Corrections of a linear solution by its residual.
const REFINEMENTS: usize = 1;
/// Rotation of a node in one load step, rad, beyond which another branch might be met.
const MAX_STEP_ROTATION: f64 = 0.8;
/// A load step may turn no node further from what the tangent at its start predicts than this share of the largest
/// rotation predicted. On a smooth path that holds for every step that is short enough; a snap to another branch hardly
/// ever passes: of 4500 random fingers, 71 jumped over a limit load without this rule, one with it.
const MAX_PREDICTION_ERROR: f64 = 0.5;
/// Load steps that converge in this many iterations are doubled.
const EASY_ITERATIONS: usize = 6;
/// Smallest load step, as a share of the whole load.
const MIN_LOAD_STEP: f64 = 1e-6;

/// Equilibrium of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Displacements and rotations.
    pub motion: FrameMotion,
    /// Elastic energy, N mm.
    pub elastic_energy_nmm: f64,
    /// Newton iterations spent, over all load steps.
    pub iterations: usize,
    /// Load steps taken.
    pub load_steps: usize,
}

/// Solver for one frame and one kinematics; the pattern and order of the equations are kept between loads.
#[derive(Debug, Clone)]
pub struct Statics<'f> {
    assembly: Assembly<'f>,
    factor: Factor,
}

/// Why a load step was not taken.
enum Rejected {
    NotPositiveDefinite,
    TooFar,
}

impl<'f> Statics<'f> {
    /// Prepares the equations of a frame.
    pub fn new(frame: &'f PlaneFrame, kinematics: Kinematics) -> Statics<'f> {
        Statics { assembly: Assembly::new(frame, kinematics), factor: Factor::new() }
    }

    /// The assembled equations.
    pub fn assembly(&self) -> &Assembly<'f> {
        &self.assembly
    }

    /// Equilibrium under dead loads, followed from rest.
    ///
    /// # Errors
    /// See [`StaticsError`].
    pub fn equilibrium(&mut self, loads: &[FrameLoad]) -> Result<Equilibrium, StaticsError> {
        let rest = FrameMotion::at_rest(self.assembly.frame());
        self.continued(&rest, loads, 0.0, 1.0)
    }

    /// Equilibria under growing multiples of the loads, each followed from the one before it; the first from rest.
    ///
    /// The result ends before the first multiple that has no equilibrium, and says why.
    ///
    /// # Errors
    /// None as such: the reason why the list is short comes as its second part.
    pub fn path(&mut self, loads: &[FrameLoad], multiples: &[f64]) -> (Vec<Equilibrium>, Option<StaticsError>) {
        let mut found: Vec<Equilibrium> = Vec::with_capacity(multiples.len());
        let mut motion = FrameMotion::at_rest(self.assembly.frame());
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
        let mut motion = start.clone();
        let (mut done, mut step) = (0.0, 1.0);
        let (mut iterations, mut load_steps) = (0, 0);
        while done < 1.0 {
            let target = f64::min(done + step, 1.0);
            match self.load_step(&motion, loads, from + (to - from) * target) {
                Ok((next, spent)) => {
                    motion = next;
                    done = target;
                    iterations += spent;
                    load_steps += 1;
                    if spent <= EASY_ITERATIONS {
                        step *= 2.0;
                    }
                }
                Err(Rejected::NotPositiveDefinite) if self.assembly.kinematics() == Kinematics::Linear => {
                    return Err(StaticsError::NotHeld);
                }
                Err(_) if step < MIN_LOAD_STEP => {
                    let reached = from + (to - from) * done;
                    return Err(if reached == 0.0 && !self.is_held(&motion) {
                        StaticsError::NotHeld
                    } else {
                        StaticsError::NoEquilibrium { converged_fraction: reached / to }
                    });
                }
                Err(_) => step = 0.5 * (target - done),
            }
        }
        Ok(Equilibrium { motion, elastic_energy_nmm: self.assembly.elastic_energy(), iterations, load_steps })
    }

    fn is_held(&mut self, motion: &FrameMotion) -> bool {
        self.assembly.evaluate(motion, &[], 0.0);
        self.factor.factorise(self.assembly.stiffness())
    }

    /// Newton's iteration at one load level. Leaves the factored tangent of the equilibrium behind.
    fn load_step(
        &mut self,
        start: &FrameMotion,
        loads: &[FrameLoad],
        multiple: f64,
    ) -> Result<(FrameMotion, usize), Rejected> {
        let frame = self.assembly.frame();
        let linear = self.assembly.kinematics() == Kinematics::Linear;
        let mut motion = start.clone();
        let mut correction = vec![0.0; self.assembly.equations().count()];
        let mut previous = f64::INFINITY;
        let (mut predicted, mut predicted_turn) = (Vec::new(), 0.0);
        for iteration in 1..=MAX_ITERATIONS {
            self.assembly.evaluate(&motion, loads, multiple);
            // The linear stiffness stays; further iterations refine its solution, because the residual, formed from the
            // deformations of the elements, keeps digits that the factor of a fine mesh loses.
            let keep_factor = linear && iteration > 1;
            if !keep_factor && !self.factor.factorise(self.assembly.stiffness()) {
                return Err(Rejected::NotPositiveDefinite);
            }
            for (c, r) in correction.iter_mut().zip(self.assembly.residual()) {
                *c = -r;
            }
            if !self.factor.solve_in_place(&mut correction, self.assembly.equations().count()) {
                return Err(Rejected::NotPositiveDefinite);
            }
            let work: f64 = correction.iter().zip(self.assembly.residual()).map(|(c, r)| -c * r).sum();
            let scale = 2.0 * self.assembly.elastic_energy();
            self.assembly.equations().advance(frame, &mut motion, &correction, linear);
            let turned = largest_difference(&motion.rotations, &start.rotations);
            if iteration == 1 {
                predicted.clone_from(&motion.rotations);
                predicted_turn = turned;
            }
            let near_enough = linear || turned <= MAX_STEP_ROTATION;
            if !near_enough {
                return Err(Rejected::TooFar);
            }
            let relative = (work / scale).max(0.0).sqrt();
            let stagnates = relative <= STAGNATION_TOLERANCE && relative > 0.25 * previous;
            if work <= 0.0 || relative <= CORRECTION_TOLERANCE || stagnates {
                let surprise = largest_difference(&motion.rotations, &predicted);
                let follows = linear || surprise <= MAX_PREDICTION_ERROR * predicted_turn;
                return if follows { Ok((motion, iteration)) } else { Err(Rejected::TooFar) };
            }
            previous = relative;
        }
        Err(Rejected::TooFar)
    }

    /// Motions of the linear frame under each load alone: columns of its compliance, by one factorisation.
    ///
    /// # Errors
    /// [`StaticsError::NotHeld`] if the frame has no stiffness against some motion.
    pub fn linear_motions(frame: &'f PlaneFrame, loads: &[FrameLoad]) -> Result<Vec<FrameMotion>, StaticsError> {
        let mut statics = Statics::new(frame, Kinematics::Linear);
        statics.equilibrium(&[])?;
        let unknowns = statics.assembly.equations().count();
        let motion_under = |load: &FrameLoad| {
            let mut motion = FrameMotion::at_rest(frame);
            let mut correction = vec![0.0; unknowns];
            for _ in 0..=REFINEMENTS {
                statics.assembly.evaluate(&motion, std::slice::from_ref(load), 1.0);
                for (c, r) in correction.iter_mut().zip(statics.assembly.residual()) {
                    *c = -r;
                }
                if !statics.factor.solve_in_place(&mut correction, unknowns) {
                    return Err(StaticsError::NotHeld);
                }
                statics.assembly.equations().advance(frame, &mut motion, &correction, true);
            }
            Ok(motion)
        };
        loads.iter().map(motion_under).collect()
    }
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
