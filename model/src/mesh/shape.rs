//! How the key nodes of a finger have moved.

use crate::Vector;
use crate::finger::{Finger, FingerPoint, MarkerPoints, NodeId};
use crate::frame::swing;

/// Motion of one key node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeMotion {
    /// The node.
    pub node: NodeId,
    /// Undeformed position, mm.
    pub position: Vector,
    /// Displacement, mm.
    pub displacement: Vector,
    /// Rotation, rad; at a hinge the plate's.
    pub rotation: f64,
    /// Undeformed position of the joint of its rib, mm: its own where no bracket holds the rib off the plate.
    pub hinge_position: Vector,
    /// Displacement of that joint, mm.
    pub hinge_displacement: Vector,
}

impl NodeMotion {
    /// Undeformed position of the node's marker on a finger, mm.
    pub fn marker_position(&self, finger: &Finger) -> Vector {
        self.position + finger.marker_offset(self.node)
    }

    /// Displacement of the node's marker on a finger, mm.
    pub fn marker_displacement(&self, finger: &Finger) -> Vector {
        match finger.description().markers_on {
            MarkerPoints::Junctions => self.displacement,
            MarkerPoints::Hinges => self.hinge_displacement,
        }
    }
}

/// The key nodes of a deformed finger, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerShape {
    motions: Vec<NodeMotion>,
}

impl FingerShape {
    /// The shape of all key nodes in their order.
    pub(super) fn of_motions(motions: Vec<NodeMotion>) -> FingerShape {
        FingerShape { motions }
    }

    /// The shape in which every key node has the displacement (mm) and rotation (rad) that `motion` gives it.
    pub fn new(finger: &Finger, motion: impl FnMut(NodeId) -> (Vector, f64)) -> FingerShape {
        FingerShape::turning(finger, motion, false)
    }

    /// The same where rotations are small: brackets turn linearly.
    pub fn of_linear(finger: &Finger, motion: impl FnMut(NodeId) -> (Vector, f64)) -> FingerShape {
        FingerShape::turning(finger, motion, true)
    }

    fn turning(finger: &Finger, mut motion: impl FnMut(NodeId) -> (Vector, f64), linear: bool) -> FingerShape {
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

    /// All key nodes in their order.
    pub fn motions(&self) -> &[NodeMotion] {
        &self.motions
    }

    /// One key node, which must be one of the finger's.
    pub fn motion(&self, node: NodeId) -> &NodeMotion {
        &self.motions[node.0 - 1]
    }

    /// Position of a point, mm.
    pub fn point(&self, point: FingerPoint) -> Vector {
        match point {
            FingerPoint::Node(node) => self.motion(node).position + self.motion(node).displacement,
            FingerPoint::Hinge(node) => self.motion(node).hinge_position + self.motion(node).hinge_displacement,
        }
    }

    /// Largest displacement of a key node, mm.
    pub fn largest_displacement_mm(&self) -> f64 {
        self.motions.iter().map(|m| m.displacement.norm()).fold(0.0, f64::max)
    }
}
