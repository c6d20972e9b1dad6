//! Loads on a finger.

use crate::Vector;
use crate::finger::NodeId;

/// A dead load on a finger, in the finger frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// Force (N) and moment (N mm) on a key node.
    Node {
        /// The node.
        node: NodeId,
        /// Force, N.
        force: Vector,
        /// Moment, N mm, from x to y.
        moment_nmm: f64,
    },
    /// Force (N) at a position of the front plate.
    Front {
        /// Position along the plate from the front base, mm.
        s_mm: f64,
        /// Force, N.
        force: Vector,
    },
}

impl Load {
    /// A force on a node, without moment.
    pub fn at_node(node: NodeId, force: Vector) -> Load {
        Load::Node { node, force, moment_nmm: 0.0 }
    }

    /// A force at a position of the front plate.
    pub fn at_position(s_mm: f64, force: Vector) -> Load {
        Load::Front { s_mm, force }
    }
}

/// A load that the finger cannot take.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LoadError {
    /// No such node.
    #[error("node {node} does not exist: the finger has the key nodes 1 to {key_nodes}")]
    NodeMissing {
        /// The node asked for.
        node: NodeId,
        /// Number of key nodes.
        key_nodes: usize,
    },
    /// The node is held.
    #[error("node {node} is clamped: a load there moves nothing and is not identifiable")]
    NodeClamped {
        /// The node asked for.
        node: NodeId,
    },
    /// The position is not on the free front plate.
    #[error(
        "the position s = {s_mm} mm is not on the front plate, which reaches from 0 (clamped) to {length_mm} mm (tip)"
    )]
    PositionOffPlate {
        /// The position asked for, mm.
        s_mm: f64,
        /// Length of the front plate, mm.
        length_mm: f64,
    },
}
