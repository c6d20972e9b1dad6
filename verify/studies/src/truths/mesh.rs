//! True fingers that consist of beams and are solved by the model's statics.

use super::{Truth, TruthId};
use crate::prelude::*;
use finray_model::compliance::NodalCompliance;
use finray_model::statics::{EquilibriumEquations, Ladder};

/// Number of nodes of the paper's fine mesh (Xu et al. 2021, sec. III).
pub const FINE_MESH_NODES: usize = 684;

/// Mesh of the true finger. It has the paper's 684 nodes, or four elements per member if four elements give more nodes.
///
/// # Errors
/// [`MeshSizeError`] if the finger has no mesh of 684 nodes. This error does not occur, because a finger with too many key nodes for 684 nodes gets
/// four elements per member.
pub fn fine_mesh(finger: &Finger) -> Result<Mesh, MeshSizeError> {
    let four_a_member = Mesh::with_elements_per_member(finger, 4);
    if four_a_member.node_count() > FINE_MESH_NODES {
        return Ok(four_a_member);
    }
    Mesh::with_nodes(finger, FINE_MESH_NODES)
}

/// A true finger (see [`TruthId`]) as a mesh of beams, solved by the model's statics.
#[derive(Debug, Clone)]
pub struct MeshTruth<'m> {
    id: TruthId,
    mesh: &'m Mesh,
    /// Solver that is prepared once and copied for each contact.
    prepared: Statics<Ladder<'m>>,
    /// Compliance of the linear finger at its key nodes; the shapes follow from this compliance without the solver. `None` for co-rotational statics,
    /// and for a mesh that has nodes besides the key nodes.
    solved: Option<NodalCompliance>,
}

impl<'m> MeshTruth<'m> {
    /// Prepares a mesh as the true finger `id`.
    ///
    /// # Errors
    /// [`StaticsError`] if the finger at rest cannot be factorised, or rounding leaves fewer than four correct digits.
    pub fn new(id: TruthId, mesh: &'m Mesh, kinematics: Kinematics) -> Result<MeshTruth<'m>, StaticsError> {
        let finger = mesh.finger();
        let push = Load::at_node(finger.tip(), finger.direction(0.0));
        Statics::ladder(mesh, Kinematics::Linear).accurate_equilibrium(&[mesh.frame_load(&push)?])?;
        let mut prepared = Statics::ladder(mesh, kinematics);
        prepared.equilibrium(&[])?;
        let key_nodes_alone = mesh.node_count() == finger.key_node_count();
        let solved = (key_nodes_alone && kinematics == Kinematics::Linear).then(|| NodalCompliance::new(finger));
        Ok(MeshTruth { id, mesh, prepared, solved })
    }

    /// Shapes of the linear finger under forces (N), as multiples of its shape under 1 N.
    fn multiples(
        &self,
        solved: &NodalCompliance,
        contact: &Contact,
        forces_n: &[f64],
    ) -> Result<Vec<FingerShape>, StaticsError> {
        let finger = self.mesh.finger();
        let unit = solved.motions(&contact.unit_load(finger))?;
        let shape = |force_n: &f64| {
            FingerShape::new(finger, true, |node| {
                let motion = unit[node.0 - 1] * *force_n;
                (motion.xy(), motion.z)
            })
        };
        let finite = |shape: &FingerShape| shape.largest_displacement_mm().is_finite();
        Ok(forces_n.iter().take_while(|force_n| force_n.is_finite()).map(shape).take_while(finite).collect())
    }
}

impl Truth for MeshTruth<'_> {
    fn id(&self) -> TruthId {
        self.id
    }

    fn is_linear(&self) -> bool {
        self.prepared.equations().kinematics() == Kinematics::Linear
    }

    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape> {
        if let Some(Ok(shapes)) = self.solved.as_ref().map(|solved| self.multiples(solved, contact, forces_n)) {
            return shapes;
        }
        let Ok(load) = self.mesh.frame_load(&contact.unit_load(self.mesh.finger())) else { return Vec::new() };
        let (equilibria, _) = self.prepared.clone().path(&[load], forces_n);
        equilibria.iter().map(|equilibrium| self.mesh.shape(&equilibrium.motion)).collect()
    }
    fn turned(&self, finger: &Finger, contact: &Contact, force_n: f64) -> Option<(f64, FingerShape)> {
        let load = contact.unit_load(finger);
        let (equilibria, _) = self.prepared.clone().path(&[self.mesh.frame_load(&load).ok()?], &[force_n]);
        let motion = &equilibria.first()?.motion;
        Some((self.mesh.normal_turn(motion, &load, 0.0).ok()?.to_degrees(), self.mesh.shape(motion)))
    }
}
