//! Reasons why a grasp fails, and the description of a contact for callers.

use crate::{ContactError, Touch, TouchedPart};
use finray_model::Vector;

/// Reason why a grasp cannot begin.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// The object overlaps a finger or the support.
    #[error("the object overlaps {what} by {overlap_mm:.3} mm at the start")]
    Overlap {
        /// Finger or support that the object overlaps.
        what: TouchedBody,
        /// Overlapped part of the finger; `None` for the support.
        part: Option<TouchedPart>,
        /// Depth of the overlap, mm.
        overlap_mm: f64,
    },
    /// A finger cannot be used for contact.
    #[error(transparent)]
    Finger(#[from] ContactError),
}

/// Reason why a grasp ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum GraspFailure {
    /// The object falls or slides out of the fingers and does not come to rest.
    #[error("drop: the fingers do not hold the object")]
    Dropped,
    /// The fingers hold the object, but no equilibrium is found. A large snap-through of a plate may cause this failure; on a coarse mesh the
    /// failure occurs earlier than on a fine mesh.
    #[error("jam: no equilibrium of object and fingers is found")]
    Jammed,
    /// A finger folds: a node has rotated by more than 1 rad.
    #[error("fold: a finger folds")]
    Folded,
}

/// A body that the object touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TouchedBody {
    /// A finger, by its index; 0 is the left one.
    Finger(usize),
    /// The support on which the object lies.
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
    /// Finger or support that the object touches.
    pub partner: TouchedBody,
    /// Contact point on the object, world frame, mm.
    pub point: Vector,
    /// Force on the object, world frame, N.
    pub force: Vector,
    /// Slip of the finger over the object in the last increment, mm.
    pub slip_mm: f64,
    /// The same contact in the finger's frame; `None` for the support.
    pub touch: Option<Touch>,
}
