//! Static equilibrium of a frame: assembly, linear solution, and nonlinear solution in load steps.

mod arc_length;
mod assembly;
mod batch;
mod continuation;
mod digits;
mod ladder;
mod limit;
mod load_path;
mod load_step;
mod newton;
mod outcome;
mod sparse;

pub use arc_length::{ArcLength, EquilibriumPath, LimitPoint, PathPoint};
pub use assembly::Assembly;
pub use batch::equilibria;
pub use ladder::Ladder;
pub use newton::{Equilibrium, Statics};
pub use outcome::{Reaction, elastic_energy, reaction};
pub use sparse::SparseEquations;

use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};
use crate::mesh::{FingerShape, Load, LoadError, Mesh};

/// Reasons why a solver returns no equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StaticsError {
    /// The frame can move without deforming, or its stiffness is not finite.
    #[error(
        "the linear equations have no solution in double precision: the frame can move without deforming, its mesh is too fine, or its stiffness or \
         displacements overflow"
    )]
    NotHeld,
    /// A load does not act on a valid point of the finger.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A load is infinite or not a number.
    #[error("expected finite loads, found a load that is infinite or not a number")]
    LoadNotFinite,
    /// Rounding leaves too few correct digits of the solution.
    #[error(
        "rounding leaves {digits:.1} digits of the solution, expected at least 4 (5 with co-rotational kinematics): use a coarser mesh, or parts \
         that differ less in stiffness"
    )]
    TooFewDigits {
        /// Estimated number of correct decimal digits.
        digits: f64,
    },
    /// The branch of stable equilibria ends before the full load.
    #[error(
        "no stable equilibrium was found beyond {:.4} % of the load: the finger snaps through, buckles or folds there",
        100.0 * converged_fraction
    )]
    NoEquilibrium {
        /// Share of the load at the last equilibrium that was found, 0..1.
        converged_fraction: f64,
    },
}

/// The equilibrium equations of a structure, in the form that Newton's method needs.
pub trait EquilibriumEquations {
    /// The motion of the undeformed structure: all displacements and rotations are zero.
    fn at_rest(&self) -> FrameMotion;

    /// The kinematic relation between displacements and strains that the equations use.
    fn kinematics(&self) -> Kinematics;

    /// Evaluates energy and residual under `factor` times the loads, and factors the tangent stiffness. Returns `false` if the tangent is not positive
    /// definite.
    fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool;

    /// Same as [`linearise`](EquilibriumEquations::linearise) at the motion that [`correct`](EquilibriumEquations::correct) returned last. The tangent
    /// may differ from the tangent stiffness in terms that vanish with the correction.
    fn relinearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        self.linearise(motion, loads, factor)
    }

    /// Whether every pivot of the last factorisation lost at most three digits to cancellation. If the pivots keep their digits, another correction
    /// by the residual has no significant effect. `false` if the loss is unknown.
    fn keeps_digits(&self) -> bool {
        false
    }

    /// Natural logarithm of the determinant of the last factored tangent, up to an additive constant. `None` if the determinant is unknown.
    fn log_determinant(&mut self) -> Option<f64>;

    /// Elastic energy at the last linearised motion, N mm.
    fn elastic_energy(&self) -> f64;

    /// Adds Newton's correction -K^-1 r to the linearised motion, where r is the residual. Returns r K^-1 r, the squared energy norm of the
    /// correction, N mm.
    fn correct(&mut self, motion: &mut FrameMotion) -> f64;

    /// Largest magnitude of a key node's displacement in the last correction, mm; infinite if unknown.
    fn largest_correction(&self) -> f64 {
        f64::INFINITY
    }
}

/// Solves for the shape of a finger under dead loads, which grow from zero to their full values; accurate to at least four digits.
///
/// # Errors
/// [`StaticsError`] if a load is invalid, no stable equilibrium exists on the path from zero to the full load, or rounding leaves fewer than four
/// digits.
pub fn solve(mesh: &Mesh, loads: &[Load], kinematics: Kinematics) -> Result<FingerShape, StaticsError> {
    let loads = loads.iter().map(|load| mesh.frame_load(load)).collect::<Result<Vec<_>, _>>()?;
    let equilibrium = Statics::ladder(mesh, kinematics).accurate_equilibrium(&loads)?;
    Ok(mesh.shape(&equilibrium.motion))
}

/// Solves for the motion of any plane frame under dead loads, accurate to at least four digits. For a finger, use [`solve`].
///
/// # Errors
/// [`StaticsError`] if a load is not finite, no stable equilibrium exists on the path from zero to the full load, or rounding leaves fewer than four
/// digits.
pub fn solve_frame(
    frame: &PlaneFrame,
    loads: &[FrameLoad],
    kinematics: Kinematics,
) -> Result<FrameMotion, StaticsError> {
    Ok(Statics::sparse(frame, kinematics).accurate_equilibrium(loads)?.motion)
}
