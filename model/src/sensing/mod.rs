//! Estimates contact forces from measured displacements.

mod assembly;
mod contact;
mod error;
mod estimate;
mod force;
mod lean;
mod linear;
mod linearisation;
pub mod network;
mod object;
mod pad;
mod pad_force;
mod residual_test;

pub use assembly::{AssemblyErrors, CameraAbove, UnloadedError, UnloadedFinger};
pub use contact::{
    Contact, ContactPosition, ContactQuestion, ContactUncertainty, Direction, MeasuredContact, check_contacts,
    check_questions,
};
pub use error::SensingError;
pub use estimate::{Alternative, Estimate, MeasuredForces, MethodError, TWO_SIDED_95, Warning};
pub use force::{Discretisation, NearForces, NonlinearEstimate, NonlinearEstimator, Refinement, sense_refining};
pub(crate) use force::{ForceUnknowns, LinearisedAssembly, LoadedShape, Press, PressedFinger, linearise_assembly};
pub use lean::{Lean, MeasuredNormal, Normal};
pub use linear::{ForcePrior, LinearEstimator};
pub use linearisation::Linearisation;
pub use object::{NotConvex, TouchedObject, TouchedOutline};
pub use pad::Pad;
pub(crate) use pad_force::{PadForce, plate_turn};
pub(crate) use residual_test::noise_of;
pub use residual_test::{ResidualTest, SIGNIFICANCE};

/// Largest accepted ratio of the largest to the smallest singular value of a matrix: the derivatives of displacements with respect to scaled
/// unknowns. Beyond this ratio of singular values, forces are not identifiable.
pub const LARGEST_SPAN: f64 = 1e8;

/// A measurement counts as unexplained if its residual exceeds both `UNEXPLAINED_SIGMAS` standard deviations of the noise and the share
/// `UNEXPLAINED_SHARE` of the displacements. The residual of a real finger may be many times the camera's noise, but stays below the share
/// `UNEXPLAINED_SHARE` of the displacements.
const UNEXPLAINED_SIGMAS: f64 = 10.0;
const UNEXPLAINED_SHARE: f64 = 0.3;

/// Largest power of one half below `carried`, the share of a load step (0 to 1) up to which equilibria exist. Returns one half if `carried` is zero.
/// Repeated halving of the step would have the same result, but each halving would need a search for an equilibrium.
fn halved_below(carried: f64) -> f64 {
    let mut share = 0.5;
    while share >= carried && carried > 0.0 {
        share *= 0.5;
    }
    share
}
