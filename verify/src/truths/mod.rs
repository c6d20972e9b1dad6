//! The fingers that sensing is put to the test on, behind one small trait.

mod lattice;
mod mesh;
mod mujoco;

pub use lattice::LatticeTruth;
pub use mesh::{FINE_MESH_NODES, MeshTruth, fine_mesh};
pub use mujoco::{MujocoTruth, NotExported};

use finray_model::mesh::FingerShape;
use finray_model::sensing::Contact;

/// A finger that answers to a force with a shape.
pub trait Truth: Sync {
    /// What it is, for file names, tables and captions.
    fn name(&self) -> &str;

    /// Whether its displacements are proportional to the force.
    fn is_linear(&self) -> bool {
        false
    }

    /// Shapes of the key nodes under growing forces (N) at one contact, each followed from the one before it.
    ///
    /// The list ends before the first force that the finger cannot carry.
    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape>;
}
