//! Beam model of a compliant fin-ray finger, and force sensing through its deformation.
//!
//! # Entry points
//! - From what was seen to a force: [`sensor::Sensor`] senses the forces in an [`observation::Observation`]. `finray-imaging` makes observations of
//!   images; its example `force_from_image` goes from an image file to a force.
//! - From a force to a shape: [`statics::solve`].
//! - From measured forces to a finger: [`calibration::factors`] (moduli), [`calibration::calibrate_rig`] (finger, camera and friction from images).
//! - From a scene file to a finger: [`Scene::from_toml`]; [`keys`] has every key.
//!
//! # Conventions
//! Units are N, mm, MPa and rad throughout; a name says where a value is in another unit (`angle_deg`). The finger frame has its origin in the middle of
//! the base line, x from the base towards the tip, y along the base line towards the front plate (the contact side); rotations count from x to y.
//! Angles of forces count from the front plate's undeformed inward normal, positive towards the tip. `sd` and `sigma` are standard deviations.
//!
//! Data flows one way: a [`Scene`] describes a [`Finger`], a [`Mesh`] divides it into beam elements, [`statics`] finds its equilibrium under
//! [`Load`]s, an [`observation`] keeps what a camera sees of it, [`estimators`] and the [`sensor`] go back from there to the contact forces.
//!
//! The crate is pure: it reads no files, prints nothing, knows no clock and draws no random numbers but from a seed.
//!
//! nalgebra holds vectors, blocks of fixed size and small dense systems. sprs assembles the sparse stiffness of a mesh, which faer factors.
//!
//! ```
//! use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, statics};
//!
//! let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
//! let mesh = Mesh::key_nodes(&scene.finger);
//! let load = Load::at_node(NodeId(19), scene.finger.direction(0.0) * 2.0);
//! let shape = statics::solve(&mesh, &[load], Kinematics::Corotational)?;
//! assert!(shape.motion(NodeId(19)).displacement.norm() > 1.0); // it gives way by more than a millimetre
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod calibration;
pub mod camera;
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
pub mod samples;
pub mod scene;
pub mod sensing;
pub mod sensor;
pub mod statics;
#[cfg(feature = "train")]
pub mod train;
pub mod validity;

pub use element::Kinematics;
pub use finger::{Finger, NodeId};
pub use mesh::{Load, Mesh};
pub use scene::Scene;

use finray_numerics::{number, optimise};

/// A position, displacement or force in the plane of the finger (mm or N, finger frame).
pub type Vector = nalgebra::Vector2<f64>;
