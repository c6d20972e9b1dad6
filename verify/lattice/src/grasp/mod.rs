//! Two lattice fingers on moving bases and a free rigid object between them, in equilibrium step by step.
//!
//! Fingers are the [`lattice`](crate) of bodies and springs. Where engines step through time until all rests, here every step is solved
//! for: `equilibrium` finds the bodies' motions, the object's pose and the contact forces at once, by Newton's method on balance, gaps and
//! Coulomb's law. [`contact`] is the kinematics of a contact, [`surface`] says which parts of finger, object and support can meet, [`world`]
//! moves the bases and lets things come to rest. An object pressed onto one finger is the same with an object
//! that a hand holds; rapier is the independent check of that.

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
