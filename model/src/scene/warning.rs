//! Warnings about a valid scene that probably does not describe the real finger.

use super::Scene;
use crate::finger::{FingerDescription, SIDE_FACE_ERROR, SideFaces};
use crate::keys::{BACK, FINGER, FRONT, RIBS};
use crate::mesh::{Load, Mesh};
use crate::{Finger, Kinematics, statics};
use std::fmt;

/// Young's modulus of diamond, MPa, rounded down. A larger modulus is probably in another unit.
const STIFFEST_MPA: f64 = 1e6;
const PA_A_MPA: f64 = 1e6;

/// A reason why a scene probably does not describe the real finger.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SceneWarning {
    /// A modulus is larger than any material's.
    Modulus {
        /// The key of the modulus.
        key: String,
        /// Its value, MPa.
        found_mpa: f64,
    },
    /// The scene does not state the side faces, and free side faces would matter.
    SideFaces {
        /// Ratio of the compliance with free side faces to that in plane strain, less 1; for a force on the middle of the front plate.
        softer: f64,
    },
    /// The scene does not state how well the modulus is known, so that the default of a plastic holds.
    AssumedModulus {
        /// Relative standard deviation of the moduli, dimensionless.
        sd: f64,
    },
}

impl Scene {
    /// Reasons why the scene probably does not describe the real finger. Programs show them once, before they compute with the finger.
    pub fn warnings(&self) -> Vec<SceneWarning> {
        let d = self.finger.description();
        let moduli = [
            (FRONT.youngs_modulus_mpa.path(), Some(d.front.youngs_modulus_mpa)),
            (BACK.youngs_modulus_mpa.path(), Some(d.back.youngs_modulus_mpa)),
            (RIBS.youngs_modulus_mpa.path(), d.ribs.strip.map(|strip| strip.youngs_modulus_mpa)),
        ];
        let of_modulus = |(key, found): (String, Option<f64>)| {
            found.filter(|mpa| *mpa > STIFFEST_MPA).map(|found_mpa| SceneWarning::Modulus { key, found_mpa })
        };
        let least = self.model_error.share().max(SIDE_FACE_ERROR);
        let softer = softer_with_free_faces(&self.finger).filter(|softer| *softer > least);
        moduli
            .into_iter()
            .filter_map(of_modulus)
            .chain(softer.map(|softer| SceneWarning::SideFaces { softer }))
            .chain(
                self.stiffness_error
                    .is_assumed
                    .then_some(SceneWarning::AssumedModulus { sd: self.stiffness_error.modulus }),
            )
            .collect()
    }
}

/// How much softer free side faces would make a finger whose side faces are not stated; `None` if they are stated or cannot matter.
fn softer_with_free_faces(finger: &Finger) -> Option<f64> {
    let d = finger.description();
    if d.side_faces.is_some() || d.poissons_ratio <= 0.0 {
        return None;
    }
    let free = Finger::new(FingerDescription { side_faces: Some(SideFaces::Free), ..d.clone() }).ok()?;
    let node = finger.contact_nodes().nth(finger.contact_nodes().len() / 2)?;
    let along = finger.direction(0.0);
    let compliance = |finger: &Finger| {
        let shape = statics::solve(&Mesh::key_nodes(finger), &[Load::at_node(node, along)], Kinematics::Linear);
        shape.map(|shape| shape.motion(node).displacement.dot(&along))
    };
    Some(compliance(&free).ok()? / compliance(finger).ok()? - 1.0)
}

impl SceneWarning {
    /// Whether the reason concerns only sensed forces.
    pub fn is_of_sensing(&self) -> bool {
        matches!(self, SceneWarning::AssumedModulus { .. })
    }

    /// Whether a calibration of the moduli removes the reason.
    pub fn is_of_stiffness(&self) -> bool {
        matches!(self, SceneWarning::SideFaces { .. } | SceneWarning::AssumedModulus { .. })
    }
}

impl fmt::Display for SceneWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SceneWarning::Modulus { key, found_mpa } => write!(
                f,
                "{key} is {found_mpa:e} MPa, stiffer than diamond; did you mean {} MPa?",
                found_mpa / PA_A_MPA
            ),
            SceneWarning::SideFaces { softer } => write!(
                f,
                "{} is not stated: the finger is computed in plane strain, and forces are {:.1} % too large if its side faces are free; \
                 state \"free\", or \"fixed\" if they are held or if the moduli were calibrated with this scene",
                FINGER.side_faces.path(),
                100.0 * softer
            ),
            SceneWarning::AssumedModulus { sd } => write!(
                f,
                "{} is not stated: intervals of forces allow for {:.0} % (standard deviation), as for any printed or moulded finger; \
                 `finray calibrate --weight` measures the modulus with one hung weight; state 0 if it was measured on this finger",
                FINGER.youngs_modulus_sigma.path(),
                100.0 * sd
            ),
        }
    }
}
