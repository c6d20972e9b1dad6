//! True fingers that sensing is tested on: one file and one row of [`TruthId`] each.

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
        /// The scene's finger, co-rotational on a fine mesh.
        Corotational => corotational::ROW,
        /// The paper's finger with softer ends.
        Twin => twin::ROW,
        /// The finger as rigid bodies and springs.
        Lattice => lattice::ROW,
        /// Shapes of the finger from MuJoCo.
        Mujoco => mujoco::ROW,
        /// The scene's finger, linear.
        Linear => linear::ROW,
    }
}

/// Properties of one type of true finger.
struct TruthRow {
    name: &'static str,
    label: &'static str,
    help: &'static str,
    /// Kinematics of a truth that consists of the scene's own beams; `None` for others.
    kinematics: Option<Kinematics>,
    /// Whether its shapes differ strongly from those of the scene's co-rotational beams.
    is_far_from_corotational: bool,
    /// Whether a separate study tests it with the estimators that answer at every contact.
    has_study: bool,
    /// Builds the mesh of the true finger from the scene's finger.
    mesh: fn(&Finger) -> Result<Mesh, TruthError>,
    /// Builds the truth on that mesh.
    on: for<'m> fn(&'m Mesh) -> Result<Box<dyn Truth + 'm>, TruthError>,
}

impl TruthId {
    /// Kinematics of a truth that consists of the scene's own beams, on which a network can be trained; `None` for others.
    pub fn kinematics(self) -> Option<Kinematics> {
        self.row().kinematics
    }

    /// Whether its shapes differ strongly from those of the scene's co-rotational beams.
    pub fn is_far_from_corotational(self) -> bool {
        self.row().is_far_from_corotational
    }

    /// Whether a separate study tests it with the estimators that answer at every contact.
    pub fn has_study(self) -> bool {
        self.row().has_study
    }

    /// Mesh of the true finger that corresponds to a scene's finger.
    ///
    /// # Errors
    /// [`TruthError`] if this truth does not exist for the finger.
    pub fn mesh(self, finger: &Finger) -> Result<Mesh, TruthError> {
        (self.row().mesh)(finger)
    }

    /// The truth on its [mesh](TruthId::mesh).
    ///
    /// # Errors
    /// [`TruthError`] if the finger at rest cannot be solved, or this truth does not exist for it.
    pub fn on(self, mesh: &Mesh) -> Result<Box<dyn Truth + '_>, TruthError> {
        (self.row().on)(mesh)
    }
}

/// Why a true finger could not be built.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// The finger cannot be meshed.
    #[error(transparent)]
    Mesh(#[from] MeshSizeError),
    /// The finger at rest cannot be solved.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// The lattice of the finger cannot be built.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// MuJoCo's export has no shapes of the finger.
    #[error("--truth {name}: {0}", name = TruthId::Mujoco)]
    NotExported(#[from] NotExported),
    /// The finger has no digital twin.
    #[error("--truth {name}: {0}", name = TruthId::Twin)]
    Twin(#[from] TwinError),
}

/// Positions along the front plate (mm from the base), and directions (degrees from the inward normal).
pub type Positions = (Vec<f64>, Vec<f64>);

/// A finger that responds to a force with a shape.
pub trait Truth: Sync {
    /// Type of this truth.
    fn id(&self) -> TruthId;

    /// Whether its displacements are proportional to the force.
    fn is_linear(&self) -> bool {
        false
    }

    /// Positions and directions for which it has shapes under these forces (N); `None` if it has them everywhere.
    ///
    /// # Errors
    /// [`TruthError`] if it has no shapes under one of the forces.
    fn positions(&self, _forces_n: &[f64]) -> Result<Option<Positions>, TruthError> {
        Ok(None)
    }

    /// Shapes of the key nodes under ascending forces (N) at one contact; each continues from the previous one.
    ///
    /// The list ends before the first force that the finger cannot carry.
    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape>;
}
