//! Loads on a finger.

use crate::Vector;
use crate::finger::NodeId;

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
    /// A force (N) at a position on the front plate.
    Front {
        /// Position along the plate from the front base, mm.
        s_mm: f64,
        /// Force, N.
        force: Vector,
    },
}

impl Load {
    /// A force (N) on a key node, without a moment.
    pub fn at_node(node: NodeId, force: Vector) -> Load {
        Load::Node { node, force, moment_nmm: 0.0 }
    }

    /// A force (N) at a position along the front plate, mm from the base.
    pub fn at_position(s_mm: f64, force: Vector) -> Load {
        Load::Front { s_mm, force }
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
    /// The position lies outside the free length of the front plate.
    #[error(
        "the position s = {s_mm} mm is not on the front plate, which reaches from 0 (clamped) to {length_mm} mm (tip)"
    )]
    PositionOffPlate {
        /// The requested position, mm from the base.
        s_mm: f64,
        /// Length of the front plate, mm.
        length_mm: f64,
    },
}
