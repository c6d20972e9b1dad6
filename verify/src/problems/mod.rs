//! Reference problems: one short file each, with its source, its reference values and its tolerance.
//!
//! Every problem answers with [`Check`](crate::check::Check)s or [`Comparison`](crate::check::Comparison)s. The report shows them
//! and the tests demand that they pass.

pub mod elastic_line;
pub mod elastica;
pub mod energy_balance;
pub mod full_circle;
pub mod grid_convergence;
pub mod lattice;
pub mod lee_frame;
pub mod mujoco;
pub mod opensees;
pub mod refinement;
pub mod rigid_rotation;
pub mod tangent;
pub mod toggle;

use crate::lattice::accuracy::AccuracyError;
use finray_model::statics::StaticsError;

/// A reference problem that could not be computed at all.
#[derive(Debug, thiserror::Error)]
pub enum ProblemError {
    /// A shipped reference file is not what it should be.
    #[error("reference data: {0}")]
    Reference(String),
    /// The problem's own finger or frame has no solution.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// The finger's lattice has no equilibrium, or does not settle.
    #[error(transparent)]
    Lattice(#[from] crate::lattice::LatticeError),
    /// A table exported from MuJoCo is not what it should be.
    #[error(transparent)]
    Export(#[from] crate::mujoco::ExportError),
    /// The problem's own mesh cannot be made.
    #[error(transparent)]
    Mesh(#[from] finray_model::mesh::MeshSizeError),
}

impl From<AccuracyError> for ProblemError {
    fn from(error: AccuracyError) -> ProblemError {
        match error {
            AccuracyError::Lattice(error) => error.into(),
            AccuracyError::Beams(error) => error.into(),
        }
    }
}

impl From<csv::Error> for ProblemError {
    fn from(error: csv::Error) -> ProblemError {
        ProblemError::Reference(error.to_string())
    }
}
