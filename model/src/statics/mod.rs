//! The whole frame in equilibrium: assembly, the linear solution and the path to a nonlinear one.

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

/// Why no equilibrium was found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StaticsError {
    /// The frame can move without deforming, or its stiffness is not a number.
    #[error(
        "the linear equations have no solution in double precision: the frame can move without deforming, its mesh is too \
         fine, or its stiffness or displacements are beyond the largest number"
    )]
    NotHeld,
    /// The load is not on the finger.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A load is infinite or not a number.
    #[error("a load is not a finite number")]
    LoadNotFinite,
    /// Rounding has left too few digits.
    #[error(
        "rounding leaves {digits:.1} digits of the solution, and 4 are the fewest that are given (5 with large rotations): use \
         a coarser mesh (or parts that differ less in stiffness)"
    )]
    TooFewDigits {
        /// Decimal digits left.
        digits: f64,
    },
    /// No stable equilibrium follows from the last one found on the way from rest to the full load.
    #[error(
        "no stable equilibrium was found beyond {:.4} % of the load: the finger snaps through, buckles or folds there",
        100.0 * converged_fraction
    )]
    NoEquilibrium {
        /// Share of the load, 0..1, at which an equilibrium was last found.
        converged_fraction: f64,
    },
}

/// The equilibrium equations of a structure, as Newton's method sees them.
pub trait EquilibriumEquations {
    /// The structure at rest.
    fn at_rest(&self) -> FrameMotion;

    /// How displacements become deformations.
    fn kinematics(&self) -> Kinematics;

    /// Evaluates energy and residual under `factor` times the loads, factors the tangent; `false` if not definite.
    fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool;

    /// Whether no pivot of the last factorisation lost more than three of its digits to cancellation, so that a correction
    /// by the residual would change nothing that counts. `false` where that is not known.
    fn keeps_digits(&self) -> bool {
        false
    }

    /// Natural logarithm of the determinant of the last factored tangent, up to a constant; `None` where it is not known.
    fn log_determinant(&mut self) -> Option<f64>;

    /// Drops a factor that is kept because it never changes: the linear one.
    fn forget_factor(&mut self);

    /// Elastic energy at the last linearised motion, N mm.
    fn elastic_energy(&self) -> f64;

    /// Adds Newton's correction -K^-1 r to the linearised motion; returns its squared energy norm r K^-1 r, N mm.
    fn correct(&mut self, motion: &mut FrameMotion) -> f64;

    /// Largest displacement in the last correction of the key nodes, mm; infinite where that is not known.
    fn largest_correction(&self) -> f64 {
        f64::INFINITY
    }
}

/// Shape of a finger under loads, from rest to the full load, to at least four digits.
///
/// # Errors
/// [`StaticsError`] if there is no equilibrium to be found, or rounding leaves fewer digits of it.
pub fn solve(mesh: &Mesh, loads: &[Load], kinematics: Kinematics) -> Result<FingerShape, StaticsError> {
    let loads = loads.iter().map(|load| mesh.frame_load(load)).collect::<Result<Vec<_>, _>>()?;
    let equilibrium = Statics::ladder(mesh, kinematics).accurate_equilibrium(&loads)?;
    Ok(mesh.shape(&equilibrium.motion))
}

/// Motion of any plane frame under loads; see [`solve`].
///
/// # Errors
/// [`StaticsError`] if there is no equilibrium to be found.
pub fn solve_frame(
    frame: &PlaneFrame,
    loads: &[FrameLoad],
    kinematics: Kinematics,
) -> Result<FrameMotion, StaticsError> {
    Ok(Statics::sparse(frame, kinematics).accurate_equilibrium(loads)?.motion)
}
