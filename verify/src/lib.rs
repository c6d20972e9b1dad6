//! Cross-checks and accuracy maps of fin-ray force sensing, and the report that shows them.
//!
//! [`problems`] holds reference problems with known answers, [`convergence`] and [`hard_cases`] what meshes and extremes
//! come to, [`lattice`] another discretisation of the finger, [`mujoco`] what another program says of it, [`truth`] the fingers that sensing is put to the test on, [`estimators`] and [`networks`] what is
//! tested, [`twin`] what the paper's own finger may have been like,
//! [`sweep`], [`map`], [`scatter`], [`direction`], [`table_one`] and [`table_two`] what is asked of them, [`contact_scene`] what objects do to it,
//! [`explain`] and [`displacement_noise`] what limits them, [`response`] how a bent finger's markers move with its forces, [`ledger`] and [`speed_error`] what came of it, [`report`] the page. [`files`] reads
//! and writes what users bring and take away; physics lives in [`finray_model`].
#![forbid(unsafe_code)]

pub mod causes;
pub mod check;
pub mod contact_scene;
pub mod convergence;
pub mod coverage;
pub mod direction;
pub mod displacement_noise;
pub mod estimators;
pub mod explain;
pub mod files;
pub mod hard_cases;
pub mod lattice;
pub mod ledger;
pub mod map;
pub mod mujoco;
pub mod networks;
pub mod problems;
pub mod report;
pub mod response;
pub mod scatter;
pub mod speed_error;
pub mod study;
pub mod sweep;
pub mod table_one;
pub mod table_two;
pub mod truth;
pub mod twin;
