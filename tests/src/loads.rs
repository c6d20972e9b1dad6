//! Contacts and forces on a finger.

use finray_model::finger::Plate;
use finray_model::frame::FrameMotion;
use finray_model::sensing::{Contact, ContactPosition, Pad};
use finray_model::statics::{self, Statics, StaticsError};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Vector};

/// A contact at a node. `angle_deg` is the direction of the force, from the undeformed inward normal.
pub fn at_node(node: usize, angle_deg: f64) -> Contact {
    Contact { position: ContactPosition::Node(NodeId(node)), angle_deg }
}

/// Contacts at nodes, with forces along the undeformed normal.
pub fn at_nodes(nodes: &[usize]) -> Vec<Contact> {
    nodes.iter().map(|&node| at_node(node, 0.0)).collect()
}

/// A contact at a position along the front plate. `angle_deg` is the direction of the force, from the undeformed inward normal.
pub fn at_position(s_mm: f64, angle_deg: f64) -> Contact {
    Contact { position: ContactPosition::at(s_mm), angle_deg }
}

/// A contact node of the finger. `fraction` selects the node: 0 is the tip, 1 is the contact node nearest to the base.
pub fn contact_node(finger: &Finger, fraction: f64) -> NodeId {
    let count = finger.contact_nodes().len();
    NodeId(finger.tip().0 + ((fraction * count as f64) as usize).min(count - 1))
}

/// Force on a node, N, under which the largest displacement of the linear finger is `share` of the front plate's length. Soft and stiff fingers are
/// deformed equally by their forces.
pub fn force_for_deflection(finger: &Finger, node: NodeId, angle_deg: f64, share: f64) -> Vector {
    let direction = finger.direction(angle_deg);
    let shape = statics::solve(&Mesh::key_nodes(finger), &[Load::at_node(node, direction)], Kinematics::Linear)
        .expect("a checked finger has a linear solution");
    direction * (share * finger.plate_length_mm(Plate::Front) / shape.largest_displacement_mm())
}

/// Number of iterations that find the direction of the plate under a pad.
const SETTLED_AFTER: usize = 12;

/// Forces, N, that are statically equivalent to the forces of an object that presses on a pad: equal forces at `parts` positions along the pad, and a
/// couple at its ends. The couple is the moment of the shear force, which acts at the pad's surface, half the plate's thickness and the pad's in front
/// of the middle line. The forces of the object are normal to the
/// deformed plate, whose direction is found by iteration. The estimator models a pad differently, by two forces.
///
/// # Errors
/// [`StaticsError`] if the finger has no equilibrium under these forces.
///
/// # Panics
/// If part of the pad is not on the plate.
pub fn under_pad(
    mesh: &Mesh,
    contact: Contact,
    force_n: f64,
    pad: Pad,
    parts: usize,
) -> Result<Vec<(Contact, f64)>, StaticsError> {
    let finger = mesh.finger();
    let s_mm = contact.position_mm(finger).expect("on the plate");
    let shares: Vec<(Contact, f64)> = (0..parts)
        .map(|i| s_mm + pad.length_mm * ((i as f64 + 0.5) / parts as f64 - 0.5))
        .map(|at_mm| (at_position(at_mm, contact.angle_deg), force_n / parts as f64))
        .collect();
    let ends_mm = [-0.5, 0.5].map(|side| s_mm + side * pad.length_mm);
    let mut statics = Statics::ladder(mesh, Kinematics::Corotational);
    let mut all = shares.clone();
    let mut plate_deg = 0.0;
    for _ in 0..SETTLED_AFTER {
        let shear_n = force_n * (contact.angle_deg - plate_deg).to_radians().sin();
        let lever_mm = 0.5 * finger.description().front.thickness_mm + pad.thickness_mm;
        let turning_n = shear_n * lever_mm / pad.length_mm;
        let couple = ends_mm.into_iter().zip([-turning_n, turning_n]);
        all.clone_from(&shares);
        all.extend(couple.map(|(at_mm, force_n)| (at_position(at_mm, plate_deg), force_n)));
        let loads = all.iter().map(|(contact, force_n)| mesh.frame_load(&contact.load(finger, *force_n)));
        let loads: Vec<_> = loads.collect::<Result<_, _>>().expect("on the plate");
        let motion = statics.equilibrium(&loads)?.motion;
        plate_deg = chord_turn_deg(mesh, &motion, ends_mm);
    }
    Ok(all)
}

/// Rotation, degrees, of the line between the mesh nodes nearest to two positions on the front plate (mm from its base).
fn chord_turn_deg(mesh: &Mesh, motion: &FrameMotion, ends_mm: [f64; 2]) -> f64 {
    let (finger, frame) = (mesh.finger(), mesh.frame());
    let ends = ends_mm.map(|end_mm| {
        let wanted = finger.base(Plate::Front) + finger.front_tangent() * end_mm;
        let off = |node: &usize| (frame.position(*node) - wanted).norm();
        (0..frame.node_count()).min_by(|a, b| off(a).total_cmp(&off(b))).expect("a mesh has nodes")
    });
    let [before, after] = [0.0, 1.0].map(|moved| {
        let [from, to] = ends.map(|node| frame.position(node) + motion.displacements[node] * moved);
        (to - from).y.atan2((to - from).x)
    });
    (after - before).to_degrees()
}
