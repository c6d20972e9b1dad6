//! Response of a bent finger: displacements of its markers and their derivatives with respect to contact forces.

use crate::prelude::*;
use finray_model::statics::Ladder;

/// Displacements of a bent finger and their derivatives. Vectors have two coordinates per marked node.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Response {
    /// Displacements, mm.
    pub displacements_mm: DVector<f64>,
    /// Derivatives with respect to the force along each contact's direction, mm/N.
    pub along: Vec<DVector<f64>>,
}

/// A co-rotational finger for repeated bending. Each search for an equilibrium starts from the last shape.
#[derive(Debug, Clone)]
pub(crate) struct RespondingFinger<'m> {
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

    /// Response of the finger under forces, N, at contacts. `None` if no equilibrium is found.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off the finger.
    pub fn under(&mut self, forces: &[(Contact, f64)]) -> Result<Option<Response>, LoadError> {
        let finger = self.mesh.finger();
        let loads = |force: &(Contact, f64)| self.mesh.frame_load(&force.0.load(finger, force.1));
        let loads: Vec<FrameLoad> = forces.iter().map(loads).collect::<Result<_, _>>()?;
        let (from, motion) = &self.last;
        let found = self.statics.shifted(motion, from, &loads).or_else(|_| self.statics.equilibrium(&loads));
        let Ok(found) = found else { return Ok(None) };
        let motion = found.motion;
        if !self.statics.linearise(&motion, &loads) {
            return Ok(None);
        }
        let ladder = self.statics.equations_mut();
        let mut rates = vec![Vector::zeros(); finger.key_node_count()];
        let mut along = Vec::new();
        for (contact, _) in forces {
            ladder.added_load(&motion, &self.mesh.frame_load(&contact.unit_load(finger))?, &mut rates);
            along.push(marker_coordinates(finger, &rates));
        }
        let markers =
            (1..=finger.key_node_count()).map(|node| motion.displacements[self.mesh.marker_node(NodeId(node))]);
        let displacements_mm = marker_coordinates(finger, &markers.collect::<Vec<_>>());
        self.last = (loads, motion);
        Ok(Some(Response { displacements_mm, along }))
    }
}

/// Coordinates (x, y) of the marked nodes, in the unit of `of_nodes`, which has one vector per key node.
pub(crate) fn marker_coordinates(finger: &Finger, of_nodes: &[Vector]) -> DVector<f64> {
    let nodes = finger.marked_nodes();
    DVector::from_iterator(2 * nodes.len(), nodes.flat_map(|node| [of_nodes[node.0 - 1].x, of_nodes[node.0 - 1].y]))
}
