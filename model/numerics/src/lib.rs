//! Numerics of the finger model, independent of fingers, meshes and scenes.
//!
//! - [`dense`]: evaluation of the layers of neural networks.
//! - [`optimise`]: damped least squares with priors, bounds on steps, and the covariance of the unknowns.
//! - [`linear`]: factorisations of symmetric matrices, small and sparse.
//! - [`number`]: the number type of the equations, which is one number or several SIMD lanes, with bitwise equal results.
//!
//! The crate is pure: it reads no files, prints nothing and uses no clock.
#![forbid(unsafe_code)]

pub mod dense;
pub mod linear;
pub mod number;
pub mod optimise;
