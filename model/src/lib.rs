//! Beam model of a compliant fin-ray finger, and force sensing through its deformation.
//!
//! Data flows one way: a [`Scene`] describes a [`Finger`], a [`Mesh`] divides it into beam elements, [`statics`] finds
//! its equilibrium under [`Load`]s, [`measurement`] keeps what a camera sees of it, and [`sensing`] goes back from
//! there to the contact forces.
//!
//! Units are N, mm, MPa and rad throughout. The finger frame has its origin in the middle of the base line, x from the
//! base towards the tip, y along the base line towards the front plate (the contact side); rotations count from x to y.
//!
//! The crate is pure: it reads no files, prints nothing, knows no clock and draws no random numbers but from a seed.
//!
//! Linear algebra: nalgebra holds vectors and small dense matrices (frames, elements, least squares); faer holds and
//! factors sparse ones, for frames in general and where a factor must show the signs of its pivots. A finger's own
//! equations need neither: [`statics::Ladder`] eliminates blocks of fixed size, in one lane or several.
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
mod number;
pub mod observation;
pub mod optimise;
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

/// A position, displacement or force in the plane of the finger (mm or N, finger frame).
pub type Vector = nalgebra::Vector2<f64>;
