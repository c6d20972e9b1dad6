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

    /// Whether maps average over the uncertain stiffness of the scene's finger. Shapes of other programs show the errors of the beam model on a solid of
    /// known moduli.
    pub(crate) fn has_stiffness_error(self) -> bool {
        !matches!(self, TruthId::Mujoco | TruthId::Continuum)
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

/// A force that leans from the deformed normal is aligned within this angle, degrees. A misalignment by this angle changes the force by 1e-5, relative.
const ALIGNED_DEG: f64 = 1e-3;
/// Largest number of iterations to find the deformed normal.
const MOST_TURNS: usize = 30;

/// The contact of a force (N) that leans by `lean_deg` (degrees, positive towards the tip) from the normal of the deformed plate at `s_mm`, and the
/// shape of the finger. `None` if the finger has no equilibrium under the force.
pub fn leaning(
    truth: &dyn Truth,
    finger: &Finger,
    s_mm: f64,
    lean_deg: f64,
    force_n: f64,
) -> Option<(Contact, FingerShape)> {
    let mut contact = Contact { position: ContactPosition::at(s_mm), angle_deg: lean_deg };
    for _ in 0..MOST_TURNS {
        let (normal_deg, shape) = truth.turned(finger, &contact, force_n)?;
        let turn_deg = normal_deg + lean_deg - contact.angle_deg;
        if turn_deg.abs() <= ALIGNED_DEG {
            return Some((contact, shape));
        }
        contact.angle_deg += turn_deg;
    }
    None
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

    /// Rotation of the front plate's normal at a position (mm from the base), degrees, and shape of the finger, under a force (N). The default
    /// interpolates the rotations of the key nodes. `None` without equilibrium.
    fn turned(&self, finger: &Finger, contact: &Contact, force_n: f64) -> Option<(f64, FingerShape)> {
        let shape = self.shapes(contact, &[force_n]).pop()?;
        let s_mm = contact.position_mm(finger)?;
        let turns = finger.plate_nodes(Plate::Front).into_iter().map(|node| shape.motion(node).rotation.to_degrees());
        let nodes: Vec<(f64, f64)> = finger.plate_positions_mm(Plate::Front).into_iter().zip(turns).collect();
        let ends = nodes.windows(2).find(|ends| ends[1].0 > ends[0].0 && (ends[0].0..=ends[1].0).contains(&s_mm))?;
        let share = (s_mm - ends[0].0) / (ends[1].0 - ends[0].0);
        Some((ends[0].1 + share * (ends[1].1 - ends[0].1), shape))
    }

    /// Reason why a shape is missing in [`shapes`](Truth::shapes).
    fn no_shape(&self) -> &'static str {
        "the true finger has no equilibrium under this force"
    }
}
