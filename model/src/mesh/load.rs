//! Loads on a finger.

use crate::Vector;
use crate::finger::{NodeId, PlatePosition};

/// A dead load on a finger, finger frame. A dead load keeps its direction while the finger deforms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// A force (N) and a moment (N mm) on a key node.
    Node {
        /// The node.
        node: NodeId,
        /// Force, N.
        force: Vector,
        /// Moment, N mm, positive from x to y.
        moment_nmm: f64,
    },
    /// A force (N) at a position on a plate.
    Plate {
        /// Position on the plate.
        at: PlatePosition,
        /// Force, N.
        force: Vector,
    },
}

impl Load {
    /// A force (N) on a key node, without a moment.
    pub fn at_node(node: NodeId, force: Vector) -> Load {
        Load::Node { node, force, moment_nmm: 0.0 }
    }

    /// A force (N) at a position on a plate; a number is a position on the front plate, mm from the base.
    pub fn at_position(at: impl Into<PlatePosition>, force: Vector) -> Load {
        Load::Plate { at: at.into(), force }
    }
}

/// Error for a load at an invalid point of the finger.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LoadError {
    /// The node does not exist.
    #[error("node {node} does not exist: the finger has nodes 1 to {key_nodes}")]
    NodeMissing {
        /// The requested node.
        node: NodeId,
        /// Number of key nodes of the finger.
        key_nodes: usize,
    },
    /// The node is clamped.
    #[error("node {node} is clamped: a load on it moves nothing and is not identifiable")]
    NodeClamped {
        /// The requested node.
        node: NodeId,
    },
    /// The position lies outside the free length of its plate.
    #[error(
        "the position s = {} mm is not on the {} plate, which reaches from 0 (clamped) to {length_mm} mm (tip)",
        at.s_mm,
        at.plate
    )]
    PositionOffPlate {
        /// The requested position.
        at: PlatePosition,
        /// Length of the plate, mm.
        length_mm: f64,
    },
}
