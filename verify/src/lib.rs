//! Verification and accuracy maps of fin-ray force sensing, with the command-line program `finray`.
//!
//! Each layer is a crate that depends only on the layers below it:
//! - [`figures`] draws charts and is independent of fingers; [`files`] reads and writes files.
//! - [`lattice`] models a finger as rigid bodies and springs.
//! - The studies: [`truths`] are reference models of the finger, [`estimators`] are tested on these models, and [`sampling`] draws the test cases.
//!   [`problems`] have known answers, [`experiments`] are the individual studies, and [`study`] runs all of them for a scene.
//! - [`report`] presents the results as pages.
//! - This crate is the program, with its [`guide`]. The physics is in [`finray_model`].
#![forbid(unsafe_code)]

pub mod guide;

pub use finray_contact as contact;
pub use finray_figures as figures;
pub use finray_files as files;
pub use finray_lattice as lattice;
pub use finray_model::estimators;
pub use finray_report as report;
pub use finray_studies::{check, experiments, exports, problems, sampling, settings, statistics, study, truths};
