//! Contacts and forces on a finger.

use finray_model::sensing::{Contact, ContactPosition};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Vector, statics};

/// A contact at a node, in a direction.
pub fn at_node(node: usize, angle_deg: f64) -> Contact {
    Contact { position: ContactPosition::Node(NodeId(node)), angle_deg }
}

/// Contacts at nodes along the undeformed normal.
pub fn at_nodes(nodes: &[usize]) -> Vec<Contact> {
    nodes.iter().map(|&node| at_node(node, 0.0)).collect()
}

/// A contact at a position along the front plate, in a direction.
pub fn at_position(s_mm: f64, angle_deg: f64) -> Contact {
    Contact { position: ContactPosition::At(s_mm), angle_deg }
}

/// A contact node of the finger, chosen by a fraction 0..1 from tip to base.
pub fn contact_node(finger: &Finger, fraction: f64) -> NodeId {
    let count = finger.contact_nodes().len();
    NodeId(finger.tip().0 + ((fraction * count as f64) as usize).min(count - 1))
}

/// A force on a node that bends the linear finger by `share` of its front plate, so that soft and stiff fingers are
/// put to the same test.
pub fn force_for_deflection(finger: &Finger, node: NodeId, angle_deg: f64, share: f64) -> Vector {
    let direction = finger.direction(angle_deg);
    let shape = statics::solve(&Mesh::key_nodes(finger), &[Load::at_node(node, direction)], Kinematics::Linear)
        .expect("a checked finger has a linear solution");
    direction * (share * finger.plate_length_mm(finray_model::finger::Plate::Front) / shape.largest_displacement_mm())
}
