//! Motions of the key nodes of a finger.

use crate::Vector;
use crate::finger::{Finger, FingerPoint, MarkerPoints, NodeId};
use crate::frame::swing;

/// Motion of one key node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeMotion {
    /// The key node.
    pub node: NodeId,
    /// Undeformed position of the node, mm, finger frame.
    pub position: Vector,
    /// Displacement of the node, mm, finger frame.
    pub displacement: Vector,
    /// Rotation of the node, rad. At a hinged rib, the rotation of the plate, not of the rib.
    pub rotation: f64,
    /// Undeformed position of the joint between rib and bracket, mm, finger frame. Equals the node's position if the node has no bracket.
    pub hinge_position: Vector,
    /// Displacement of the joint between rib and bracket, mm, finger frame.
    pub hinge_displacement: Vector,
}

impl NodeMotion {
    /// Displacement of the node's marker, mm, finger frame.
    pub fn marker_displacement(&self, finger: &Finger) -> Vector {
        match finger.description().markers_on {
            MarkerPoints::Junctions => self.displacement,
            MarkerPoints::Hinges => self.hinge_displacement,
        }
    }
}

/// Motions of all key nodes of a finger, in ascending order of the nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerShape {
    pub(super) motions: Vec<NodeMotion>,
}

impl FingerShape {
    /// Makes a shape from `motion`, a function that returns the displacement (mm) and rotation (rad) of a key node. If `linear`, the displacements of
    /// bracket ends are of first order in the rotation.
    pub fn new(finger: &Finger, linear: bool, mut motion: impl FnMut(NodeId) -> (Vector, f64)) -> FingerShape {
        let motions = (1..=finger.key_node_count()).map(NodeId).map(|node| {
            let (displacement, rotation) = motion(node);
            let hinge_displacement = displacement + swing(finger.bracket(node), rotation, linear);
            NodeMotion {
                node,
                position: finger.position(node),
                displacement,
                rotation,
                hinge_position: finger.hinge(node),
                hinge_displacement,
            }
        });
        FingerShape { motions: motions.collect() }
    }

    /// Motions of all key nodes, in ascending order.
    pub fn motions(&self) -> &[NodeMotion] {
        &self.motions
    }

    /// Motion of one key node.
    ///
    /// # Panics
    /// Panics if the finger does not have this node.
    pub fn motion(&self, node: NodeId) -> &NodeMotion {
        &self.motions[node.0 - 1]
    }

    /// Deformed position of a point of the finger, mm, finger frame.
    pub fn point(&self, point: FingerPoint) -> Vector {
        match point {
            FingerPoint::Node(node) => self.motion(node).position + self.motion(node).displacement,
            FingerPoint::Hinge(node) => self.motion(node).hinge_position + self.motion(node).hinge_displacement,
        }
    }

    /// Largest magnitude of a key node's displacement, mm.
    pub fn largest_displacement_mm(&self) -> f64 {
        self.motions.iter().map(|m| m.displacement.norm()).fold(0.0, f64::max)
    }
}
