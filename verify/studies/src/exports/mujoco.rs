//! Shapes computed by MuJoCo for three fingers, and for the paper's finger with a cylinder pushed into it. MuJoCo models each member as a discrete
//! elastic rod between the rigid rods at key nodes, with code that is independent of finray. `fixtures/mujoco/README.md` describes the export and its
//! accuracy.

use super::{ExportError, ExportedFinger, Program, Solved, rows, shape};
use crate::prelude::*;

/// The paper's finger.
pub const PAPER: ExportedFinger =
    ExportedFinger { name: "paper", scene: finray_fixtures::PAPER_SCENE, csv: finray_fixtures::MUJOCO_PAPER };

/// The fingers that MuJoCo solved. An export applies only to the finger with the same beams.
pub const PROGRAM: Program = Program {
    name: "MuJoCo",
    fingers: &[
        PAPER,
        ExportedFinger {
            name: "asymmetric",
            scene: finray_fixtures::ASYMMETRIC_SCENE,
            csv: finray_fixtures::MUJOCO_ASYMMETRIC,
        },
        ExportedFinger {
            name: "soft-zone",
            scene: finray_fixtures::SOFT_ZONE_SCENE,
            csv: finray_fixtures::MUJOCO_SOFT_ZONE,
        },
    ],
    solved: Solved::Beams,
};

/// A rigid rod in contact with the cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchedRod {
    /// Key node of the rod.
    pub node: NodeId,
    /// Contact force on the rod in the finger frame, N.
    pub force: Vector,
    /// Moment of the contact force about the rod's centre, N mm. Zero up to rounding if there is no friction.
    pub moment_nmm: f64,
}

/// Equilibrium, computed by MuJoCo, of the paper's finger with a rigid cylinder pushed into it.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactStep {
    /// Number of the push. A push is a series of steps with one cylinder.
    pub push: usize,
    /// Displacement of the cylinder towards the finger since first contact, mm.
    pub depth_mm: f64,
    /// Coefficient of friction between cylinder and finger, dimensionless.
    pub friction: f64,
    /// Displacements and rotations of the key nodes.
    pub shape: FingerShape,
    /// Rods that carry a contact force, from tip to base.
    pub touched: Vec<TouchedRod>,
    /// Uncertainty that the export states for each displacement, mm.
    pub uncertainty_mm: f64,
}

#[derive(Debug, Deserialize)]
struct ContactRow {
    push: usize,
    friction: f64,
    depth_mm: f64,
    node: usize,
    ux_mm: f64,
    uy_mm: f64,
    theta_rad: f64,
    fx_n: f64,
    fy_n: f64,
    m_nmm: f64,
    uncertainty_mm: f64,
}

/// All steps of all pushes of a cylinder into the paper's finger.
///
/// # Errors
/// [`ExportError`] if the shipped table cannot be read.
pub fn contact_steps() -> Result<Vec<ContactStep>, ExportError> {
    let finger = PAPER.finger()?;
    let rows: Vec<ContactRow> = rows(finray_fixtures::MUJOCO_CONTACT)?;
    rows.chunk_by(|a, b| (a.push, a.depth_mm) == (b.push, b.depth_mm))
        .map(|step| {
            let first = &step[0];
            let name = || format!("push {}, {} mm", first.push, first.depth_mm);
            let motions = step.iter().map(|row| (row.node, [row.ux_mm, row.uy_mm, row.theta_rad]));
            let touched = step.iter().map(|row| TouchedRod {
                node: NodeId(row.node),
                force: Vector::new(row.fx_n, row.fy_n),
                moment_nmm: row.m_nmm,
            });
            Ok(ContactStep {
                push: first.push,
                depth_mm: first.depth_mm,
                friction: first.friction,
                shape: shape(&finger, name, motions)?,
                touched: touched.filter(|rod| rod.force != Vector::zeros()).collect(),
                uncertainty_mm: first.uncertainty_mm,
            })
        })
        .collect()
}
