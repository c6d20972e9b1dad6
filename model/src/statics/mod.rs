//! The whole frame in equilibrium: assembly, the linear solution and the path to a nonlinear one.

mod assembly;
mod factor;
mod newton;
mod reactions;

pub use assembly::{Assembly, FrameLoad};
pub use factor::Factor;
pub use newton::{Equilibrium, Statics};
pub use reactions::{Reaction, reaction};

use crate::mesh::{FingerShape, Load, LoadError, Mesh};
use crate::{Kinematics, frame::PlaneFrame};

/// Why no equilibrium was found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StaticsError {
    /// The frame can move without deforming, or its stiffness is not a number.
    #[error("the frame is not held: it can move without deforming, or a stiffness in it is not a finite number")]
    NotHeld,
    /// The load is not on the finger.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A load is infinite or not a number.
    #[error("a load is not a finite number")]
    LoadNotFinite,
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

/// Shape of a finger under loads, from rest to the full load.
///
/// # Errors
/// [`StaticsError`] if there is no equilibrium to be found.
pub fn solve(mesh: &Mesh, loads: &[Load], kinematics: Kinematics) -> Result<FingerShape, StaticsError> {
    let loads = loads.iter().map(|load| mesh.frame_load(load)).collect::<Result<Vec<_>, _>>()?;
    let motion = solve_frame(mesh.frame(), &loads, kinematics)?;
    Ok(mesh.shape(&motion))
}

/// Motion of any plane frame under loads; see [`solve`].
///
/// # Errors
/// [`StaticsError`] if there is no equilibrium to be found.
pub fn solve_frame(
    frame: &PlaneFrame,
    loads: &[FrameLoad],
    kinematics: Kinematics,
) -> Result<crate::frame::FrameMotion, StaticsError> {
    let mut statics = Statics::new(frame, kinematics);
    let equilibrium = statics.equilibrium(loads)?;
    Ok(equilibrium.motion)
}
