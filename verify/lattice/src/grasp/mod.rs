//! Quasi-static equilibrium of two lattice fingers on moving bases with a free rigid object between them.
//!
//! Fingers are [`lattice`](crate)s of bodies and springs. Engines step through time until everything rests; here `equilibrium` solves each step
//! directly. It finds the bodies' motions, the object's pose and the contact forces at once, by Newton's method on balance, gaps and Coulomb's law.
//! [`contact`] is the kinematics of a contact, and [`surface`] finds the parts of finger, object and support that can touch. [`world`] moves the
//! bases and brings everything to rest. An object pressed onto one finger is the same problem with an object held by a hand; rapier checks that
//! case independently.

mod bordered;
pub mod contact;
mod elimination;
mod equilibrium;
mod linearised;
mod near;
mod scene;
pub mod surface;
pub mod world;

pub use world::{Account, Drive, GraspFailure, ObjectContact, TouchedBody, World, WorldError};
