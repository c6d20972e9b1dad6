//! Numerics of the finger model: what knows nothing of fingers, meshes or scenes.
//!
//! - [`dense`]: layers of networks.
//! - [`optimise`]: damped least squares with priors, bounds of steps and the covariance of the unknowns.
//! - [`linear`]: factors of symmetric matrices, small and sparse.
//! - [`number`]: one number or several side by side, computed to the same bits.
//!
//! The crate is pure: it allocates, and computes.
#![forbid(unsafe_code)]

pub mod dense;
pub mod linear;
pub mod number;
pub mod optimise;
