//! What is asked of force sensing with fin-ray fingers, and what came out.
//!
//! Arrows run down: [`settings`], [`check`] and [`statistics`] are the floor; [`lattice`] measures the lattice's own error, [`mujoco`] has the
//! finger's shapes in MuJoCo; [`truths`] are the fingers that sensing is tested on, [`finray_model::estimators`] what is tested, [`sampling`] how;
//! [`problems`] have known answers; [`experiments`] ask, [`study`] runs them all for a scene, [`claims`] holds the paper's sentences against the
//! results.
#![forbid(unsafe_code)]

pub mod check;
pub mod claims;
pub mod experiments;
pub mod lattice;
pub mod mujoco;
mod prelude;
pub mod problems;
pub mod sampling;
pub mod settings;
pub mod statistics;
pub mod study;
pub mod templates;
pub mod truths;
