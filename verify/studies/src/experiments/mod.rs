//! Experiments on fingers, estimators and models: one file for each, with its own type of results.
//!
//! Each experiment of the report has a function `run`, which takes the [`Context`] and earlier results; [`study`](crate::study) lists the
//! experiments.

pub mod camera;
pub mod changes;
pub mod contact_scene;
pub mod continuum;
pub mod coverage;
pub mod explain;
pub mod grasp;
pub mod maps;
pub mod measured;
pub mod networks;
pub mod noise;
pub mod recorded;
pub mod shapes;
pub mod situations;
pub mod table_two;

use crate::prelude::*;
use crate::problems::ProblemError;
use crate::truths::MeshTruth;
use contact_scene::study::SceneWithOutline;
use finray_model::estimators::network::Networks;
use finray_model::measurement::MeasurementError;
use finray_model::sensing::network::NetworkError;
use grasp::GraspError;

/// Input of every experiment of a report.
#[derive(Clone, Copy)]
pub struct Context<'c> {
    /// The scene, with its object's outline.
    pub given: &'c SceneWithOutline,
    /// The finger of the scene.
    pub finger: &'c Finger,
    /// Whether the finger is the paper's finger. Only this finger has reference values.
    pub is_paper: bool,
    /// Standard deviation of the camera noise of one coordinate, mm.
    pub noise_mm: f64,
    /// Forces of maps and drawings, and of the explanations of maps.
    pub forces: ReportForces,
    /// Amount of computation.
    pub effort: Effort,
    /// The finger's [fine mesh](crate::truths::fine_mesh).
    pub fine: &'c Mesh,
    /// The co-rotational finger on the fine mesh.
    pub corotational: &'c MeshTruth<'c>,
    /// The shipped networks.
    pub networks: &'c Networks,
    /// Progress callbacks.
    pub progress: &'c dyn Progress,
}

impl Context<'_> {
    /// Forces for experiments with fixed reference figures; see [`ReportForces::checked`].
    pub fn checked_forces(&self) -> ReportForces {
        self.forces.checked(self.is_paper)
    }

    /// Noise levels, mm: 0, and the camera's noise if it is above 0.
    pub fn noise_levels_mm(&self) -> Vec<f64> {
        if self.noise_mm > 0.0 { vec![0.0, self.noise_mm] } else { vec![0.0] }
    }
}

/// Why an experiment could not be completed.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// A finger cannot be meshed.
    #[error(transparent)]
    Mesh(#[from] MeshSizeError),
    /// A finger cannot be solved.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// A contact is not on the finger.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A contact cannot be sensed.
    #[error(transparent)]
    Sensing(#[from] SensingError),
    /// A sensor refuses, or does not support the contacts.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// A network cannot be read.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A network cannot be trained.
    #[cfg(feature = "train")]
    #[error(transparent)]
    Train(#[from] finray_train::TrainError),
    /// A shipped scene cannot be read.
    #[error("cannot read a shipped scene: {0}")]
    Scene(#[from] SceneError),
    /// A grasp cannot be set up.
    #[error(transparent)]
    Grasp(#[from] GraspError),
    /// Markers do not form a valid measurement.
    #[error(transparent)]
    Markers(#[from] MeasurementError),
    /// A reference problem cannot be solved.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The finger has no equilibrium under a force.
    #[error("the finger cannot carry {force_n:.3} N at node {node}")]
    NotCarried {
        /// The loaded node.
        node: NodeId,
        /// The force, N.
        force_n: f64,
    },
}

/// Evidence from results: checks, and comparisons without tolerance.
pub trait Evidence {
    /// Checks of figures against references, with tolerances.
    fn checks(&self, _context: &Context) -> Vec<Check> {
        Vec::new()
    }

    /// Figures that are expected to differ from their references.
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
