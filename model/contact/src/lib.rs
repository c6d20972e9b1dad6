//! Contact of rigid objects with fin-ray fingers: an object pressed onto one finger, and an object grasped by two fingers.
//!
//! # Entry points
//! [`press::ContactScene`] presses the object of a scene onto its finger and senses the forces; [`pressing::Pressing`] moves or pulls an object against
//! one finger, without a scene. [`World`] holds one or more fingers on moving bases, a free object, and its
//! support. Both take outlines ([`outline::Shape`]): discs and polygons.
//!
//! ```
//! use finray_contact::press::ContactScene;
//! use finray_model::Scene;
//!
//! let scene = Scene::from_toml(finray_fixtures::DISC_SCENE)?;
//! let object = scene.object.as_ref().expect("an object");
//! let mut last_mm = 0.0;
//! ContactScene::new(&scene, object, &[])?.run(|step| last_mm = step.travel_mm)?;
//! assert!((last_mm - 26.6).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Model
//! A finger is the co-rotational frame of [`finray_model`]. An object is outside the finger, or in one of the cells between plates and ribs, and stays
//! there. It touches the sides of the walls ([`Wall`]) that face it: surfaces half a thickness from the axis of the wall's elements, with a disc at
//! every rod of the front plate; the module `surface` divides them into parts. The axis of an element is a cubic without kinks at its ends. Contacts are
//! unilateral with Coulomb friction. Corners and discs of an object meet the curved surface itself; straight sides meet it at two points an element.
//!
//! Physics engines step through time until everything rests; here each state of rest is solved for directly. Contact forces act on few nodes of the mesh. The
//! finger is therefore condensed onto these nodes: a Newton step needs one factorisation of the finger, a compliance between the touched nodes, and
//! the solution of a small dense system for touched nodes and object.
//!
//! # Conventions
//! Lengths in mm, forces in N, moments in N mm, angles in rad. The finger frame is that of [`finray_model`]; placements map it to the world.
#![forbid(unsafe_code)]

pub mod carrier;
mod newton;
mod number;
pub mod outline;
mod overlap;
pub mod pair;
pub mod part;
pub mod path;
pub mod press;
pub mod pressing;
mod region;
mod scene;
mod status;
mod surface;
mod tangent_system;
mod world;

pub use world::{Account, Drive, GraspFailure, ObjectContact, TouchedBody, World, WorldError};

use finray_model::finger::{Finger, Plate};
use finray_model::{NodeId, Vector};

/// Reason why contact forces cannot be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContactError {
    /// The front plate tapers. The computation of contacts assumes that the plate's outline is parallel to the plate's middle line.
    #[error("finger.front.tip_thickness_mm: expected a front plate of constant thickness where an object touches it")]
    Tapered,
    /// The finger has no equilibrium under a tiny force.
    #[error(transparent)]
    Statics(#[from] finray_model::statics::StaticsError),
    /// The object overlaps the finger at the start.
    #[error(
        "the object overlaps the undeformed finger by {overlap_mm:.3} mm at the start{}",
        part.map_or(String::new(), |part| format!(", at {part}"))
    )]
    Overlap {
        /// Overlapped part of the finger, if it is known.
        part: Option<TouchedPart>,
        /// Depth of the overlap, mm.
        overlap_mm: f64,
    },
    /// The object reaches a wall of the finger on which contact is not modelled.
    #[error(
        "the object reaches {part}: contact is modelled with plates of constant thickness, and with ribs that deform and are joined rigidly to both \
            plates without brackets"
    )]
    Unmodelled {
        /// The part of the finger that the object reaches.
        part: TouchedPart,
    },
    /// The press was stopped before its last step.
    #[error("stopped before the last step")]
    Stopped,
    /// The finger does not hold the object against the applied force.
    #[error(
        "the finger does not hold the object against the force{}", touched_n.map_or(String::new(), |n| format!(": they last touched at {n:.3} N"))
    )]
    LetGo {
        /// Pull at which the finger lost the object, N. `None` if the object never touched the finger.
        touched_n: Option<f64>,
    },
    /// No equilibrium is found with the object at its prescribed position.
    #[error("no stable equilibrium of finger and object is found{}", if *is_folded { ": the finger folds" } else { "" })]
    NoEquilibrium {
        /// Whether the finger folds: a node has rotated by more than 1 rad.
        is_folded: bool,
    },
}

/// A wall of a finger, through which no object passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wall {
    /// The front plate.
    Front,
    /// The back plate.
    Back,
    /// A rib; ribs are numbered from 0 at the base.
    Rib(usize),
    /// The straight line between the bases of both plates, which never moves.
    Base,
}

impl Wall {
    /// The plate; `None` for ribs and base.
    pub fn plate(self) -> Option<Plate> {
        match self {
            Wall::Front => Some(Plate::Front),
            Wall::Back => Some(Plate::Back),
            Wall::Rib(_) | Wall::Base => None,
        }
    }
}

/// The part of the finger that an object touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TouchedPart {
    /// Rod at a key node of the front plate.
    Rod(NodeId),
    /// A wall, at this position along the wall, mm: from the base of a plate, or from the back plate.
    On(Wall, f64),
}

impl TouchedPart {
    /// The wall, and the position along the wall, mm.
    pub fn place(&self, finger: &Finger) -> (Wall, f64) {
        match *self {
            TouchedPart::Rod(node) => (Wall::Front, finger.front_position_mm(node).unwrap_or_default()),
            TouchedPart::On(wall, position_mm) => (wall, position_mm),
        }
    }
}

impl std::fmt::Display for TouchedPart {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            TouchedPart::Rod(node) => write!(f, "the rod of node {node}"),
            TouchedPart::On(Wall::Front, s_mm) => write!(f, "{s_mm:.1} mm of the front plate"),
            TouchedPart::On(Wall::Back, s_mm) => write!(f, "{s_mm:.1} mm of the back plate"),
            TouchedPart::On(Wall::Rib(rib), s_mm) => write!(f, "rib {}, {s_mm:.1} mm from the back plate", rib + 1),
            TouchedPart::On(Wall::Base, _) => write!(f, "the base"),
        }
    }
}

/// A point at which the object pushes on the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Touched part of the finger.
    pub part: TouchedPart,
    /// Whether the touched part is clamped; the force then does not bend the finger.
    pub clamped: bool,
    /// Contact point, finger frame, deformed, mm.
    pub point: Vector,
    /// Unit vector from the object into the finger, finger frame.
    pub normal: Vector,
    /// Force on the finger, N, finger frame.
    pub force: Vector,
    /// Overlap of object and finger, mm; negative for a gap.
    pub overlap_mm: f64,
}
