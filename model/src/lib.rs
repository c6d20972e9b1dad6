//! Beam model of a compliant fin-ray finger, and estimation of contact forces from its deformation.
//!
//! # Entry points
//! - From an observation to a force: [`sensor::Sensor`] estimates the forces of an [`observation::Observation`]. `finray-imaging` extracts
//!   observations from images; its example `force_from_image` computes a force from an image file.
//! - From a force to a shape: [`statics::solve`]. [`checked_shape::CheckedShape`] also states reasons why the shape may be inaccurate.
//! - From measured forces to a calibrated finger: [`calibration::factors`] (moduli), [`calibration::calibrate_rig`] (finger, camera and friction from
//!   images).
//! - From a scene file to a finger: [`Scene::from_toml`]; [`keys`] lists every key.
//! # Conventions
//! Units are N, mm, MPa and rad; a name states any other unit (`angle_deg`). The finger frame has its origin at the middle of the base line. Its x axis
//! points from the base towards the tip. Its y axis runs along the base line towards the front plate (the contact side). Rotations are positive from x to y.
//! Angles of forces are measured from the inward normal of the undeformed front plate, positive towards the tip. In names, `sd` and `sigma` mean standard
//! deviation.
//!
//! Data flows one way. A [`Scene`] describes a [`Finger`]. A [`Mesh`] divides the finger into beam elements, and [`statics`] computes its equilibrium
//! under [`Load`]s. An [`observation`] contains the measured positions or displacements of markers. [`estimators`] and the [`sensor`] estimate the
//! contact forces from an observation.
//!
//! The crate is pure: it reads no files, prints nothing, uses no clock, and draws no random numbers. Functions that need random numbers accept a
//! generator.
//!
//! The crate `nalgebra` provides vectors, small fixed-size matrices and small dense systems. The crate `sprs` assembles the sparse stiffness of a
//! mesh, and the crate `faer` factors this stiffness.
//!
//! ```
//! use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, statics};
//!
//! let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
//! let mesh = Mesh::key_nodes(&scene.finger);
//! let load = Load::at_node(NodeId(19), scene.finger.direction(0.0) * 2.0);
//! let shape = statics::solve(&mesh, &[load], Kinematics::Corotational)?;
//! assert!(shape.motion(NodeId(19)).displacement.norm() > 1.0); // the node moves by more than 1 mm
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod calibration;
pub mod camera;
pub mod checked_shape;
pub mod compliance;
pub mod element;
pub mod estimators;
pub mod finger;
pub mod frame;
pub mod gripper;
pub mod keys;
pub mod measurement;
pub mod mesh;
pub mod observation;
pub mod registry;
pub mod rigid_fit;
pub mod scene;
pub mod sensing;
pub mod sensor;
pub mod statics;
pub mod text;
pub mod validity;

pub use element::Kinematics;
pub use finger::{Finger, NodeId};
pub use mesh::{Load, Mesh};
pub use scene::Scene;

use finray_numerics::{number, optimise};

/// A position, displacement or force in the plane of the finger (mm or N, finger frame).
pub type Vector = nalgebra::Vector2<f64>;
