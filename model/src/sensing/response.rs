//! Response of a bent finger: displacements of its markers and their derivatives with respect to contact forces and positions.

use crate::finger::{Plate, PlatePosition};
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::{Load, LoadError};
use crate::sensing::{Contact, ContactPosition};
use crate::statics::{Ladder, Statics};
use crate::{Finger, Kinematics, Mesh, NodeId, Vector};
use nalgebra::DVector;

/// A contact force with a component across the contact's direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// Position and direction of the contact.
    pub contact: Contact,
    /// Force along the direction, N.
    pub along_n: f64,
    /// Force across the direction, positive towards the tip, N.
    pub across_n: f64,
    /// Distance, mm, of `across_n` from the plate's axis: the radius of a rod, or half the plate's thickness. The moment of `across_n` about the axis
    /// rotates the plate.
    pub lever_mm: f64,
}

/// At a contact between nodes, two forces represent a moment. Each of the two forces that represent a moment acts at this distance from the contact,
/// in mm.
const COUPLE_REACH_MM: f64 = 0.5;

impl ContactForce {
    /// A force of `along_n`, N, along the direction of its contact only.
    pub fn plain(contact: Contact, along_n: f64) -> ContactForce {
        ContactForce { contact, along_n, across_n: 0.0, lever_mm: 0.0 }
    }

    /// Load of the force `force_n`, N, along the contact's direction.
    fn along(&self, finger: &Finger, force_n: f64) -> Load {
        self.contact.load(finger, force_n)
    }

    /// Loads of the force `force_n`, N, across the contact's direction, including the moment of this force: -`lever_mm` times `force_n`, N mm.
    fn across(&self, finger: &Finger, force_n: f64) -> impl Iterator<Item = Load> + use<> {
        let turned = Contact { angle_deg: self.contact.angle_deg + 90.0, ..self.contact };
        let moment_nmm = -self.lever_mm * force_n;
        let loads = match turned.load(finger, force_n) {
            Load::Node { node, force, .. } => [Some(Load::Node { node, force, moment_nmm }), None],
            Load::Plate { at: PlatePosition { plate: _, s_mm }, force } => {
                let length_mm = finger.plate_length_mm(Plate::Front);
                // Positions on the plate are greater than 0.
                let reach_mm = COUPLE_REACH_MM.min(length_mm - s_mm).min(0.5 * s_mm);
                let turning = finger.direction(self.contact.angle_deg) * (-0.5 * moment_nmm / reach_mm);
                let pair = [(-reach_mm, -turning), (reach_mm, turning)];
                match reach_mm > 0.0 {
                    true => pair.map(|(off_mm, turn)| Some(Load::at_position(s_mm + off_mm, 0.5 * force + turn))),
                    false => [Some(Load::at_position(s_mm, force)), None],
                }
            }
        };
        loads.into_iter().flatten()
    }
}

/// Displacements of a bent finger and their derivatives. Vectors have two coordinates per marked node.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Displacements, mm.
    pub displacements_mm: DVector<f64>,
    /// Derivatives with respect to the force along each contact's direction, mm/N.
    pub along: Vec<DVector<f64>>,
    /// Derivatives with respect to the force across each contact's direction, mm/N.
    pub across: Vec<DVector<f64>>,
    /// Derivatives with respect to the position of each contact, which increases towards the tip, mm/mm. Zero for contacts at nodes, whose positions
    /// are fixed.
    pub moved: Vec<DVector<f64>>,
}

/// A co-rotational finger for repeated bending. Each search for an equilibrium starts from the last shape.
#[derive(Debug, Clone)]
pub struct RespondingFinger<'m> {
    mesh: &'m Mesh,
    statics: Statics<Ladder<'m>>,
    last: (Vec<FrameLoad>, FrameMotion),
}

impl<'m> RespondingFinger<'m> {
    /// An unloaded finger.
    pub fn new(mesh: &'m Mesh) -> RespondingFinger<'m> {
        let at_rest = (Vec::new(), FrameMotion::at_rest(mesh.frame()));
        RespondingFinger { mesh, statics: Statics::ladder(mesh, Kinematics::Corotational), last: at_rest }
    }

    /// The finger of the mesh.
    pub(super) fn finger(&self) -> &'m Finger {
        self.mesh.finger()
    }

    /// Response of the finger under forces. `None` if no equilibrium is found.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off the finger.
    pub fn under(&mut self, forces: &[ContactForce]) -> Result<Option<Response>, LoadError> {
        let finger = self.mesh.finger();
        let framed = |load: Load| self.mesh.frame_load(&load);
        let (mut loads, mut ends) = (Vec::new(), Vec::new());
        for force in forces {
            loads.push(framed(force.along(finger, force.along_n))?);
            for load in force.across(finger, force.across_n) {
                loads.push(framed(load)?);
            }
            ends.push(loads.len());
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
        let mut from = 0;
        for (force, to) in forces.iter().zip(ends) {
            let of_force = &loads[std::mem::replace(&mut from, to)..to];
            let mut rates_under = |unit: &mut dyn Iterator<Item = Load>| -> Result<DVector<f64>, LoadError> {
                let mut sum = DVector::zeros(2 * finger.marked_nodes().len());
                for load in unit {
                    ladder.added_load(&motion, &framed(load)?, &mut rates);
                    sum += marker_coordinates(finger, &rates);
                }
                Ok(sum)
            };
            along.push(rates_under(&mut std::iter::once(force.along(finger, 1.0)))?);
            across.push(rates_under(&mut force.across(finger, 1.0))?);
            let mut shift = DVector::zeros(2 * finger.marked_nodes().len());
            if matches!(force.contact.position, ContactPosition::At(_)) {
                for load in of_force {
                    ladder.moved_load(&motion, load, &mut rates);
                    shift += marker_coordinates(finger, &rates);
                }
            }
            moved.push(shift);
        }
        let markers =
            (1..=finger.key_node_count()).map(|node| motion.displacements[self.mesh.marker_node(NodeId(node))]);
        let displacements_mm = marker_coordinates(finger, &markers.collect::<Vec<_>>());
        self.last = (loads, motion);
        Ok(Some(Response { displacements_mm, along, across, moved }))
    }
}

/// Coordinates (x, y) of the marked nodes, in the unit of `of_nodes`, which has one vector per key node.
pub fn marker_coordinates(finger: &Finger, of_nodes: &[Vector]) -> DVector<f64> {
    let nodes = finger.marked_nodes();
    DVector::from_iterator(2 * nodes.len(), nodes.flat_map(|node| [of_nodes[node.0 - 1].x, of_nodes[node.0 - 1].y]))
}
