//! True fingers: simulated fingers on which estimators are tested. Each type has one file and one row of [`TruthId`].

mod corotational;
mod exported;
mod lattice;
mod linear;
mod mesh;
mod twin;

pub use exported::{ExportedTruth, NotExported, SAME};
pub use lattice::LATTICE_FINENESS;
pub use mesh::{FINE_MESH_NODES, MeshTruth, fine_mesh};
pub use twin::{TwinError, twin_of};

use crate::prelude::*;
use finray_model::registry;

registry! {
    /// Type of a true finger: a simulated finger on which estimators are tested.
    TruthId: TruthRow {
        /// The scene's finger on a fine mesh, with co-rotational statics.
        Corotational => corotational::ROW,
        /// The paper's finger with softer ends.
        Twin => twin::ROW,
        /// The finger as rigid bodies and springs.
        Lattice => lattice::ROW,
        /// Shapes of the finger from MuJoCo.
        Mujoco => exported::MUJOCO,
        /// Shapes of the finger as a plane continuum, from CalculiX.
        Continuum => exported::CONTINUUM,
        /// The scene's finger with linear statics.
        Linear => linear::ROW,
    }
}

/// A true finger on a mesh of a scene.
type TruthOnMesh = for<'m> fn(&'m Mesh, &Scene) -> Result<Box<dyn Truth + 'm>, TruthError>;

/// Properties of one type of true finger.
struct TruthRow {
    name: &'static str,
    label: &'static str,
    help: &'static str,
    kinematics: Option<Kinematics>,
    mesh: fn(&Finger) -> Result<Mesh, TruthError>,
    on: TruthOnMesh,
}

impl TruthId {
    /// Kinematics if this true finger consists of the scene's own beams, so that a network can be trained on this finger; otherwise `None`.
    pub fn kinematics(self) -> Option<Kinematics> {
        self.row().kinematics
    }

    /// Mesh of the true finger, derived from the scene's finger.
    ///
    /// # Errors
    /// [`TruthError`] if the scene's finger has no true finger of this type.
    pub fn mesh(self, finger: &Finger) -> Result<Mesh, TruthError> {
        (self.row().mesh)(finger)
    }

    /// Builds the true finger of a scene on its [mesh](TruthId::mesh).
    ///
    /// # Errors
    /// [`TruthError`] if the finger at rest cannot be solved, or this type does not support the scene's finger.
    pub fn on<'m>(self, mesh: &'m Mesh, scene: &Scene) -> Result<Box<dyn Truth + 'm>, TruthError> {
        (self.row().on)(mesh, scene)
    }
}

/// Why a true finger could not be built, or has no shapes under a force.
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
    /// An export has no shapes of the finger, or no shape under a force.
    #[error("--truth {0}: {1}")]
    NotExported(TruthId, #[source] NotExported),
    /// The finger has no digital twin.
    #[error("--truth {name}: {0}", name = TruthId::Twin)]
    Twin(#[from] TwinError),
}

/// Positions along the front plate (mm from the base), and directions (degrees from the inward normal).
pub type Positions = (Vec<f64>, Vec<f64>);

/// A true finger, which returns the shape of the simulated finger under a force.
pub trait Truth: Sync {
    /// Type of this true finger.
    fn id(&self) -> TruthId;

    /// Whether displacements are proportional to the force.
    fn is_linear(&self) -> bool {
        false
    }

    /// Positions and directions at which shapes exist under these forces (N); `None` if shapes exist at every position and direction.
    ///
    /// # Errors
    /// [`TruthError`] if no shapes exist under one of the forces.
    fn positions(&self, _forces_n: &[f64]) -> Result<Option<Positions>, TruthError> {
        Ok(None)
    }

    /// Shapes (motions of the key nodes) under ascending forces (N) at one contact. An iterative solver starts from the previous equilibrium.
    ///
    /// The list ends before the first force that the finger cannot carry.
    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape>;

    /// Reason why a shape is missing in [`shapes`](Truth::shapes).
    fn no_shape(&self) -> &'static str {
        "the true finger has no equilibrium under this force"
    }
}
