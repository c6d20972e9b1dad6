//! Studies of force sensing with fin-ray fingers: true fingers, sampling, reference problems, experiments and checks. "The paper" is Xu et al. (2021).
//!
//! Modules depend downwards only. [`settings`], [`check`] and [`statistics`] use no other module of this crate. [`exports`]
//! contains shapes of fingers computed by other programs. [`truths`] contains the simulated fingers on which sensing is
//! tested, [`finray_model::estimators`] contains the estimators under test, and [`sampling`] contains the test procedure. [`problems`] have known
//! solutions. [`experiments`] produce the results, and [`study`] runs them all for one scene.
#![forbid(unsafe_code)]

pub mod check;
pub mod experiments;
pub mod exports;
mod prelude;
pub mod problems;
pub mod sampling;
pub mod settings;
pub mod statistics;
pub mod study;
pub mod truths;
