//! Cross-checks and accuracy maps of fin-ray force sensing, and the report that shows them.
//!
//! Each floor is a crate, and uses those below it alone:
//! [`figures`] draws and knows nothing of fingers; [`files`] reads and writes; [`lattice`] is the finger as bodies and springs, and two of them
//! with an object between; the studies have [`truths`], the fingers that sensing is tested on, [`estimators`], what is tested, [`sampling`], how,
//! [`problems`] with known answers, [`experiments`], [`study`], which runs them all for a scene, and [`claims`], the paper's sentences beside the
//! results; [`report`] shows them. This crate is the program on top, with its [`guide`]. Physics lives in [`finray_model`].
#![forbid(unsafe_code)]

pub mod guide;

pub use finray_figures as figures;
pub use finray_files as files;
pub use finray_lattice as lattice;
pub use finray_model::estimators;
pub use finray_report as report;
pub use finray_studies::{check, claims, experiments, mujoco, problems, sampling, settings, statistics, study, truths};
