//! Example shapes of the finger, for drawings.

use super::{Context, Evidence};
use crate::prelude::*;
use crate::truths::{Truth, TruthError, TruthId};
use finray_model::frame::NodeIndex;
use finray_model::validity::Validity;
use std::convert::Infallible;

impl Evidence for BentFinger {}

/// A deformed finger, for drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct BentFinger {
    /// Label that states load and kinematics.
    pub label: String,
    /// Kinematics of the solution.
    pub kinematics: Kinematics,
    /// Force vector in the finger frame, N.
    pub force: Vector,
    /// Deformed position at which the force acts, in the finger frame, mm.
    pub at: Vector,
    /// Deformed positions of the nodes along every member, in the finger frame, mm.
    pub lines: Vec<Vec<Vector>>,
    /// Validity of the beam model in this shape.
    pub validity: Validity,
}

/// The finger under a force at a contact node.
#[derive(Debug, Clone, PartialEq)]
pub struct TouchedFinger {
    /// Type of the true finger.
    pub truth: TruthId,
    /// Loaded node.
    pub node: usize,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Force, N.
    pub force_n: f64,
    /// Displacements and rotations of the key nodes, from node 1 on.
    pub shape: FingerShape,
}

impl Evidence for TouchedFinger {}

/// Step of the directions of [`touched`], degrees.
const TOUCHED_STEP_DEG: f64 = 20.0;

/// Shapes of the co-rotational finger under the force at which maps are drawn, at up to 13 contact nodes. Directions without equilibrium are omitted.
/// For the paper's scene, shapes of the finger with softer ends under the same loads follow.
pub(crate) fn touched(context: &Context) -> Result<Vec<TouchedFinger>, TruthError> {
    let mut touched = shapes_of(context, context.corotational);
    if context.is_paper {
        let mesh = TruthId::Twin.mesh(context.finger)?;
        touched.extend(shapes_of(context, &*TruthId::Twin.on(&mesh, &context.given.scene)?));
    }
    Ok(touched)
}

fn shapes_of(context: &Context, truth: &dyn Truth) -> Vec<TouchedFinger> {
    let (finger, force_n) = (context.finger, context.forces.drawn_n());
    let every = finger.contact_nodes().len().div_ceil(13);
    let nodes: Vec<NodeId> = finger.contact_nodes().rev().step_by(every).collect();
    let angles = (-4..=4).map(|step| f64::from(step) * TOUCHED_STEP_DEG);
    let contacts: Vec<(NodeId, f64)> =
        nodes.iter().flat_map(|&node| angles.clone().map(move |angle| (node, angle))).collect();
    let shape = |&(node, angle_deg): &(NodeId, f64)| {
        let contact = Contact { position: ContactPosition::Node(node), angle_deg };
        let shape = truth.shapes(&contact, &[force_n]).pop()?;
        Some(TouchedFinger { truth: truth.id(), node: node.0, angle_deg, force_n, shape })
    };
    contacts.par_iter().filter_map(shape).collect()
}

/// Linear and co-rotational shapes of the finger under the force at which maps are drawn, at up to three nodes. Shapes without equilibrium are
/// omitted.
pub(crate) fn run(context: &Context) -> Result<Vec<BentFinger>, Infallible> {
    let (finger, mesh, force_n) = (context.finger, context.fine, context.forces.drawn_n());
    let nodes: Vec<_> = finger.contact_nodes().collect();
    let chosen = [nodes.len() / 8, nodes.len() / 2, nodes.len() - 1].map(|i| nodes[i]);
    let mut chosen = chosen.to_vec();
    chosen.dedup();
    let mut bent = Vec::new();
    for node in chosen {
        for (kinematics, name) in [(Kinematics::Linear, "linear"), (Kinematics::Corotational, "co-rotational")] {
            let contact = Contact::at_node(node);
            let load: Load = contact.load(finger, force_n);
            let Ok(frame_load) = mesh.frame_load(&load) else { continue };
            let Ok(equilibrium) = Statics::ladder(mesh, kinematics).equilibrium(&[frame_load]) else { continue };
            let motion = equilibrium.motion;
            let position = |&index: &usize| mesh.frame().position(index) + motion.displacements[index];
            let drawn = |nodes: Vec<NodeIndex>| nodes.iter().map(position).collect();
            bent.push(BentFinger {
                validity: Validity::of(mesh, &motion, kinematics, &[frame_load]),
                label: format!("{force_n} N at node {node}, {name}"),
                kinematics,
                force: finger.direction(0.0) * force_n,
                at: position(&mesh.frame_node(node)),
                lines: mesh.lines().iter().map(|line| line.nodes.clone()).chain(brackets(mesh)).map(drawn).collect(),
            });
        }
    }
    Ok(bent)
}

/// Lines from key nodes to the joints of their ribs, for fingers whose brackets hold the ribs off the plates.
fn brackets(mesh: &Mesh) -> impl Iterator<Item = Vec<NodeIndex>> {
    let ends = mesh.finger().free_nodes().map(|node| [mesh.frame_node(node), mesh.hinge_node(node)]);
    ends.filter(|[node, hinge]| node != hinge).map(Vec::from)
}
