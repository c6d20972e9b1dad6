//! The beam finger itself, linear or on a fine co-rotational mesh.

use super::Truth;
use finray_model::mesh::{FingerShape, MeshSizeError};
use finray_model::sensing::Contact;
use finray_model::statics::{Ladder, Statics, StaticsError};
use finray_model::{Finger, Kinematics, Load, Mesh};

/// Nodes of the paper's fine mesh (Xu et al. 2021, sec. III).
pub const FINE_MESH_NODES: usize = 684;

/// The mesh that stands for the true finger: the paper's 684 nodes, or four elements a member where that is more.
///
/// # Errors
/// [`MeshSizeError`] never in practice: a finger with more key nodes takes the second way.
pub fn fine_mesh(finger: &Finger) -> Result<Mesh, MeshSizeError> {
    let four_a_member = Mesh::with_elements_per_member(finger, 4);
    if four_a_member.node_count() > FINE_MESH_NODES {
        return Ok(four_a_member);
    }
    Mesh::with_nodes(finger, FINE_MESH_NODES)
}

/// A meshed finger, solved by the model's own statics.
#[derive(Debug, Clone)]
pub struct MeshTruth<'m> {
    name: &'static str,
    mesh: &'m Mesh,
    /// The equations, prepared once and copied for each contact.
    prepared: Statics<Ladder<'m>>,
}

impl<'m> MeshTruth<'m> {
    /// Prepares a mesh under a name.
    ///
    /// # Errors
    /// [`StaticsError`] if the finger at rest cannot be factorised, or rounding leaves fewer than four digits of how it
    /// gives way to a force on its tip.
    pub fn new(name: &'static str, mesh: &'m Mesh, kinematics: Kinematics) -> Result<MeshTruth<'m>, StaticsError> {
        let finger = mesh.finger();
        let push = Load::at_node(finger.tip(), finger.direction(0.0));
        Statics::ladder(mesh, Kinematics::Linear).accurate_equilibrium(&[mesh.frame_load(&push)?])?;
        let mut prepared = Statics::ladder(mesh, kinematics);
        prepared.equilibrium(&[])?;
        Ok(MeshTruth { name, mesh, prepared })
    }
}

impl Truth for MeshTruth<'_> {
    fn name(&self) -> &str {
        self.name
    }

    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape> {
        let Ok(load) = self.mesh.frame_load(&contact.unit_load(self.mesh.finger())) else { return Vec::new() };
        let (equilibria, _) = self.prepared.clone().path(&[load], forces_n);
        equilibria.iter().map(|equilibrium| self.mesh.shape(&equilibrium.motion)).collect()
    }
}
