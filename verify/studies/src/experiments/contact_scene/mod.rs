//! Studies of contact scenes: pressed objects, with sensed forces, noise samples, and verification by the physics engine rapier.
//!
//! [`finray_contact::press`] presses the objects on beams. Rapier, which finds the contacts of object and lattice on its own, verifies them (module
//! `verified`).

pub mod checks;
pub mod file;
pub mod objects;
pub mod samples;
pub mod study;
mod verified;

pub use verified::{EngineDifference, VerifiedStep};

/// Number of plate segments between two rods in the verification by rapier. With this number, the paper's finger under 5 N is within 0.1 % of
/// converged beams.
pub const FINENESS: usize = 3;
