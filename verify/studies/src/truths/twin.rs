//! True finger: the paper's finger with a softer base and tip, fitted to the paper's Table I. Other fits are possible: see
//! [`experiments::twin`](crate::experiments::twin).

use super::{MeshTruth, TruthId, TruthRow, fine_mesh};
use crate::prelude::*;

pub(super) const ROW: TruthRow = TruthRow {
    name: "twin",
    label: "softer ends",
    help: "The paper's finger with a softer base and tip, co-rotational: one of several fits to the paper's Table I; for \
        the paper's scene alone",
    kinematics: None,
    mesh: |finger| Ok(fine_mesh(&twin_of(finger)?)?),
    on: |mesh, _| Ok(Box::new(MeshTruth::new(TruthId::Twin, mesh, Kinematics::Corotational)?)),
};

/// Why a finger has no digital twin.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TwinError {
    /// The finger is not the paper's.
    #[error("only the paper's finger (fixtures/scenes/paper.toml) has a digital twin; this scene has another finger")]
    NotThePapersFinger,
    /// A shipped scene cannot be read.
    #[error("cannot read a shipped scene: {0}")]
    Scene(#[from] SceneError),
}

/// Digital twin of the paper's finger.
///
/// # Errors
/// [`TwinError`] if the finger is not the paper's finger, or if the shipped scene cannot be read.
pub fn twin_of(finger: &Finger) -> Result<Finger, TwinError> {
    if !is_papers_finger(finger) {
        return Err(TwinError::NotThePapersFinger);
    }
    Ok(Scene::from_toml(finray_fixtures::TWIN_SCENE)?.finger)
}
