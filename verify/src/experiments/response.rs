//! A bent finger, and how its markers move, to first order, with the forces on it and where these act.

use finray_model::frame::{FrameLoad, FrameMotion};
use finray_model::mesh::LoadError;
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::statics::{Ladder, Statics};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Vector};
use nalgebra::DVector;

/// A force with a component across the direction of its contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// Position and direction.
    pub contact: Contact,
    /// Along the direction, N.
    pub along_n: f64,
    /// Across it, towards the tip, N.
    pub across_n: f64,
    /// At a node, how far before it the force across acts, mm: the radius of a rod, which friction turns.
    pub lever_mm: f64,
}

/// Shape and derivatives; vectors have two coordinates a free key node.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Displacements, mm.
    pub displacements_mm: DVector<f64>,
    /// mm per N along each contact's direction.
    pub along: Vec<DVector<f64>>,
    /// mm per N across it.
    pub across: Vec<DVector<f64>>,
    /// mm per mm that a force moves towards the tip; zero at nodes, where contacts do not move.
    pub moved: Vec<DVector<f64>>,
}

/// A co-rotational finger that is bent again and again, each time from the shape before.
#[derive(Debug, Clone)]
pub struct RespondingFinger<'m> {
    mesh: &'m Mesh,
    statics: Statics<Ladder<'m>>,
    last: (Vec<FrameLoad>, FrameMotion),
}

impl<'m> RespondingFinger<'m> {
    /// A finger at rest.
    pub fn new(mesh: &'m Mesh) -> RespondingFinger<'m> {
        let at_rest = (Vec::new(), FrameMotion::at_rest(mesh.frame()));
        RespondingFinger { mesh, statics: Statics::ladder(mesh, Kinematics::Corotational), last: at_rest }
    }

    /// Bends the finger; `None` where it has no equilibrium under the forces.
    ///
    /// # Errors
    /// [`LoadError`] for a contact that is not on the finger.
    pub fn under(&mut self, forces: &[ContactForce]) -> Result<Option<Response>, LoadError> {
        let finger = self.mesh.finger();
        let turned = |force: &ContactForce, turned_deg: f64, force_n: f64| {
            let contact = Contact { angle_deg: force.contact.angle_deg + turned_deg, ..force.contact };
            self.mesh.frame_load(&contact.load(finger, force_n))
        };
        let across_by = |force: &ContactForce, force_n: f64| -> Result<FrameLoad, LoadError> {
            Ok(match turned(force, 90.0, force_n)? {
                // (-lever n) x (across), with n and the direction across a right-handed pair.
                FrameLoad::Node { node, force: vector, .. } => {
                    FrameLoad::Node { node, force: vector, moment_nmm: -force.lever_mm * force_n }
                }
                load => load,
            })
        };
        let mut loads = Vec::new();
        for force in forces {
            loads.push(turned(force, 0.0, force.along_n)?);
            loads.push(across_by(force, force.across_n)?);
        }
        let (from, motion) = &self.last;
        let found = self.statics.shifted(motion, from, &loads).or_else(|_| self.statics.equilibrium(&loads));
        let Ok(found) = found else { return Ok(None) };
        let motion = found.motion;
        if !self.statics.linearise(&motion, &loads) {
            return Ok(None);
        }
        let ladder = self.statics.equations_mut();
        let mut rates = vec![Vector::zeros(); finger.key_node_count()];
        let (mut along, mut across, mut moved) = (Vec::new(), Vec::new(), Vec::new());
        for (force, loads) in forces.iter().zip(loads.chunks_exact(2)) {
            for (columns, load) in [(&mut along, turned(force, 0.0, 1.0)?), (&mut across, across_by(force, 1.0)?)] {
                ladder.added_load(&motion, &load, &mut rates);
                columns.push(coordinates(finger, &rates));
            }
            let mut shift = DVector::zeros(2 * finger.marked_nodes().len());
            if matches!(force.contact.position, ContactPosition::At(_)) {
                for load in loads {
                    ladder.moved_load(&motion, load, &mut rates);
                    shift += coordinates(finger, &rates);
                }
            }
            moved.push(shift);
        }
        let markers =
            (1..=finger.key_node_count()).map(|node| motion.displacements[self.mesh.marker_node(NodeId(node))]);
        let displacements_mm = coordinates(finger, &markers.collect::<Vec<_>>());
        self.last = (loads, motion);
        Ok(Some(Response { displacements_mm, along, across, moved }))
    }
}

/// Coordinates of the markers, from vectors by key node.
pub(super) fn coordinates(finger: &Finger, of_nodes: &[Vector]) -> DVector<f64> {
    let nodes = finger.marked_nodes();
    DVector::from_iterator(2 * nodes.len(), nodes.flat_map(|node| [of_nodes[node.0 - 1].x, of_nodes[node.0 - 1].y]))
}
