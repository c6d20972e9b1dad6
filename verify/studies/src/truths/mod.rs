//! The fingers that sensing is tested on: one file and one row of [`TruthId`] each.

mod corotational;
mod lattice;
mod linear;
mod mesh;
mod mujoco;
mod twin;

pub use lattice::LatticeTruth;
pub use mesh::{FINE_MESH_NODES, MeshTruth, fine_mesh};
pub use mujoco::{MujocoTruth, NotExported};
pub use twin::{TwinError, twin_of};

use crate::prelude::*;
use finray_model::registry;

registry! {
    /// A true finger.
    TruthId: TruthRow {
        /// The finger itself, co-rotational on a fine mesh.
        Corotational => corotational::ROW,
        /// The paper's finger with softer ends.
        Twin => twin::ROW,
        /// The finger as rigid bodies and springs.
        Lattice => lattice::ROW,
        /// The finger as MuJoCo solved it.
        Mujoco => mujoco::ROW,
        /// The finger itself, linear.
        Linear => linear::ROW,
    }
}

/// Properties of a kind of true finger.
struct TruthRow {
    name: &'static str,
    label: &'static str,
    help: &'static str,
    /// Kinematics of a truth that is the scene's own beams.
    kinematics: Option<Kinematics>,
    /// Whether its shapes are far from those of the scene's co-rotational beams.
    is_far_from_corotational: bool,
    /// Whether a study of its own puts it to the estimators that answer at every contact.
    has_study: bool,
    /// The true finger of a scene's finger, meshed.
    mesh: fn(&Finger) -> Result<Mesh, TruthError>,
    /// The truth on that mesh.
    on: for<'m> fn(&'m Mesh) -> Result<Box<dyn Truth + 'm>, TruthError>,
}

impl TruthId {
    /// Kinematics of a truth that is the scene's own beams: what a network can be trained on.
    pub fn kinematics(self) -> Option<Kinematics> {
        self.row().kinematics
    }

    /// Whether its shapes are far from those of the scene's co-rotational beams.
    pub fn is_far_from_corotational(self) -> bool {
        self.row().is_far_from_corotational
    }

    /// Whether a study of its own puts it to the estimators that answer at every contact.
    pub fn has_study(self) -> bool {
        self.row().has_study
    }

    /// The true finger of a scene's finger, meshed.
    ///
    /// # Errors
    /// [`TruthError`] for a finger that there is no such truth of.
    pub fn mesh(self, finger: &Finger) -> Result<Mesh, TruthError> {
        (self.row().mesh)(finger)
    }

    /// The truth on its [mesh](TruthId::mesh).
    ///
    /// # Errors
    /// [`TruthError`] if the finger at rest cannot be solved, or there is no such truth of it.
    pub fn on(self, mesh: &Mesh) -> Result<Box<dyn Truth + '_>, TruthError> {
        (self.row().on)(mesh)
    }
}

/// Why there is no true finger.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// The finger cannot be meshed.
    #[error(transparent)]
    Mesh(#[from] MeshSizeError),
    /// The finger at rest cannot be solved.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// The finger has no lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// The shape was not exported from MuJoCo.
    #[error("--truth {name}: {0}", name = TruthId::Mujoco)]
    NotExported(#[from] NotExported),
    /// The finger has no twin.
    #[error("--truth {name}: {0}", name = TruthId::Twin)]
    Twin(#[from] TwinError),
}

/// Positions along the front plate, mm from the base, and directions, degrees.
pub type Positions = (Vec<f64>, Vec<f64>);

/// A finger that answers to a force with a shape.
pub trait Truth: Sync {
    /// Which truth it is.
    fn id(&self) -> TruthId;

    /// Whether its displacements are proportional to the force.
    fn is_linear(&self) -> bool {
        false
    }

    /// The positions and directions that it answers at under these forces (N); `None` if it answers everywhere.
    ///
    /// # Errors
    /// [`TruthError`] for a force that it does not answer to at all.
    fn positions(&self, _forces_n: &[f64]) -> Result<Option<Positions>, TruthError> {
        Ok(None)
    }

    /// Shapes of the key nodes under growing forces (N) at one contact, each followed from the one before it.
    ///
    /// The list ends before the first force that the finger cannot carry.
    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape>;
}
