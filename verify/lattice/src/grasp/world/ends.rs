//! How a grasp can fail, and what a contact is to those who read it off.

use crate::LatticeError;
use crate::skin::Touch;
use finray_model::Vector;

/// Why a grasp cannot begin.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// The object is inside a finger or the support.
    #[error("the object overlaps {what} by {overlap_mm:.3} mm where it starts")]
    Overlap {
        /// What it overlaps.
        what: TouchedBody,
        /// How deep, mm.
        overlap_mm: f64,
    },
    /// The lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

/// Why a grasp ends before its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum GraspFailure {
    /// The object falls or slides away and does not come to rest.
    #[error("the object gets away: the fingers do not hold it")]
    Dropped,
    /// Fingers hold the object, and no equilibrium is found: where plates snap far, on coarse lattices the earlier.
    #[error("jam: no equilibrium of object and fingers is found")]
    Jammed,
    /// A finger folds.
    #[error("a finger folds")]
    Folded,
}

/// What the object touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TouchedBody {
    /// A finger, by its number: 0 is the left one.
    Finger(usize),
    /// The support.
    Support,
}

impl std::fmt::Display for TouchedBody {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            TouchedBody::Finger(0) => "the left finger",
            TouchedBody::Finger(_) => "the right finger",
            TouchedBody::Support => "its support",
        })
    }
}

/// A contact that carries a force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectContact {
    /// What the object touches.
    pub partner: TouchedBody,
    /// Where, world, mm.
    pub point: Vector,
    /// Force on the object, world, N.
    pub force: Vector,
    /// How far it has slipped in the step, mm.
    pub slip_mm: f64,
    /// The same as the finger sees it; none of the support.
    pub touch: Option<Touch>,
}
