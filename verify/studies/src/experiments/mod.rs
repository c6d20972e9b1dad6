//! Experiments on fingers, estimators and models: one a file, each with results of its own type.
//!
//! Those of the report `run` on the [`Context`] and results that they rest on; [`study`](crate::study) lists them.

pub mod assumed;
pub mod camera;
pub mod causes;
pub mod contact_scene;
pub mod convergence;
pub mod coverage;
pub mod direction;
pub mod displacement_noise;
pub mod explain;
pub mod grasp;
pub mod hard_cases;
pub mod lattice;
pub mod maps;
pub mod measured;
pub mod networks;
pub mod noise;
pub mod shapes;
pub mod speed_error;
pub mod table_one;
pub mod table_two;
pub mod twin;

use crate::prelude::*;
use crate::problems::ProblemError;
use crate::truths::{MeshTruth, TwinError};
use contact_scene::study::{SceneStudyError, SceneWithOutline};
use finray_model::calibration::CalibrationError;
use finray_model::estimators::network::Networks;
use finray_model::finger::ImpossibleFinger;
use finray_model::measurement::MeasurementError;
use finray_model::sensing::network::NetworkError;
use grasp::GraspError;

/// Input of every experiment of a report.
#[derive(Clone, Copy)]
pub struct Context<'c> {
    /// The scene.
    pub given: &'c SceneWithOutline,
    /// Its finger.
    pub finger: &'c Finger,
    /// Whether it is the paper's finger: only then there are reference values.
    pub is_paper: bool,
    /// Standard deviation of one coordinate of the camera, mm.
    pub noise_mm: f64,
    /// Forces of maps and drawings, and of what explains them.
    pub forces: ReportForces,
    /// Effort: how much is computed.
    pub effort: Effort,
    /// The finger's [fine mesh](crate::truths::fine_mesh).
    pub fine: &'c Mesh,
    /// The co-rotational finger on it.
    pub corotational: &'c MeshTruth<'c>,
    /// The networks that ship.
    pub networks: &'c Networks,
    /// Callbacks of progress.
    pub progress: &'c dyn Progress,
}

impl Context<'_> {
    /// Forces of studies whose checks and claims hold for fixed ones.
    pub fn checked_forces(&self) -> ReportForces {
        self.forces.checked(self.is_paper)
    }

    /// No noise, and the camera's if it has any; mm.
    pub fn noise_levels_mm(&self) -> Vec<f64> {
        if self.noise_mm > 0.0 { vec![0.0, self.noise_mm] } else { vec![0.0] }
    }
}

/// Why an experiment could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// A finger could not be meshed.
    #[error(transparent)]
    Mesh(#[from] MeshSizeError),
    /// A finger could not be solved.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// A lattice has no equilibrium.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// A finger with other zones or modulus is impossible.
    #[error(transparent)]
    Finger(#[from] ImpossibleFinger),
    /// A contact is not on the finger.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A modulus or zones could not be calibrated.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A contact cannot be sensed.
    #[error(transparent)]
    Sensing(#[from] SensingError),
    /// An estimator refuses what it is made for.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// A network does not read.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A network could not be trained.
    #[cfg(feature = "train")]
    #[error(transparent)]
    Train(#[from] finray_model::train::TrainError),
    /// A scene that ships does not read.
    #[error("a scene that ships: {0}")]
    Scene(#[from] SceneError),
    /// It is no grasp.
    #[error(transparent)]
    Grasp(#[from] GraspError),
    /// Markers that no camera would measure.
    #[error(transparent)]
    Markers(#[from] MeasurementError),
    /// There is no twin.
    #[error(transparent)]
    Twin(#[from] TwinError),
    /// A reference problem, or the lattice.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// An object.
    #[error("contact scene: {0}")]
    Object(#[from] SceneStudyError),
    /// A finger cannot carry a weight.
    #[error("the finger cannot carry {weight_g} g at node {node}")]
    NotCarried {
        /// The loaded node.
        node: NodeId,
        /// The weight, g.
        weight_g: f64,
    },
}

/// Evidence from results: checks, and comparisons without a tolerance.
pub trait Evidence {
    /// Figures against references, with tolerances.
    fn checks(&self, _context: &Context) -> Vec<Check> {
        Vec::new()
    }

    /// Figures beside others, where a difference is expected.
    fn comparisons(&self) -> Vec<Comparison> {
        Vec::new()
    }
}

impl<E: Evidence> Evidence for Option<E> {
    fn checks(&self, context: &Context) -> Vec<Check> {
        self.iter().flat_map(|evidence| evidence.checks(context)).collect()
    }

    fn comparisons(&self) -> Vec<Comparison> {
        self.iter().flat_map(E::comparisons).collect()
    }
}

impl<E: Evidence> Evidence for Vec<E> {
    fn checks(&self, context: &Context) -> Vec<Check> {
        self.iter().flat_map(|evidence| evidence.checks(context)).collect()
    }

    fn comparisons(&self) -> Vec<Comparison> {
        self.iter().flat_map(E::comparisons).collect()
    }
}
