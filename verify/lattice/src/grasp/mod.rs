//! Quasi-static equilibrium of two lattice fingers on moving bases and a free rigid object between the fingers.
//!
//! Fingers are [`lattice`](crate)s of bodies and springs. Physics engines step through time until everything rests; the module `equilibrium` solves
//! for each state of rest directly. Newton's method, applied to force balance, gaps and Coulomb's law, yields the bodies' motions, the object's pose
//! and the contact forces together. [`contact`] is the kinematics of one contact, and [`surface`] finds the parts of finger, object and support that
//! can touch. [`world`] moves the bases and brings everything to rest. An object pressed onto one finger is solved by the same method; a "hand" (the
//! imposed motion or force) then holds the object. For an object pressed onto one finger, the physics engine rapier verifies the results
//! independently.

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
