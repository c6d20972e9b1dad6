//! Cross-checks and accuracy maps of fin-ray force sensing, and the report that shows them.
//!
//! Arrows run down: [`settings`], [`check`], [`statistics`], [`files`] and [`figures`] are the floor; [`lattice`] is the finger as bodies and springs,
//! [`grasp`] two of them with an object between, [`mujoco`] the finger's shapes in MuJoCo; [`truths`] are the fingers that sensing is tested on, [`estimators`] what is tested, [`sampling`] how;
//! [`problems`] have known answers; [`experiments`] ask, [`study`] runs them all for a scene, [`claims`] holds the paper's sentences
//! against the results, [`report`] shows them. Physics lives in [`finray_model`].
#![forbid(unsafe_code)]

pub mod check;
pub mod claims;
pub mod estimators;
pub mod experiments;
pub mod figures;
pub mod files;
pub mod grasp;
pub mod lattice;
pub mod mujoco;
pub mod problems;
mod registry;
pub mod report;
pub mod sampling;
pub mod settings;
pub mod statistics;
pub mod study;
mod templates;
pub mod truths;
