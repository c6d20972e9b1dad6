//! True fingers that consist of shapes exported from another program, without interpolation.

use super::{Positions, Truth, TruthError, TruthId, TruthRow};
use crate::exports::{ExportError, Program, StaticCase, calculix, mujoco};
use crate::prelude::*;

pub(super) const MUJOCO: TruthRow = TruthRow {
    name: "mujoco",
    label: "MuJoCo",
    help: "The finger as solved by MuJoCo: shapes of three fingers, exported for certain contact nodes, directions and \
        forces; other positions and directions (--places, --step-deg) are not available",
    kinematics: None,
    mesh: |finger| Ok(Mesh::key_nodes(finger)),
    on: |mesh| exported(TruthId::Mujoco, &mujoco::PROGRAM, mesh.finger()),
};

pub(super) const CONTINUUM: TruthRow = TruthRow {
    name: "continuum",
    label: "continuum",
    help: "The finger as a plane continuum with stiff rods, solved by CalculiX: exported shapes of seven fingers, with \
        the same limits as mujoco. The continuum has the material of its export (nu = 0.45); poissons_ratio, \
        rod_arm_mm, rib_arm_mm, clamp_arm_mm, fillet_mm, shear_correction and a common factor on all moduli of the scene do not change the continuum",
    kinematics: None,
    mesh: |finger| Ok(Mesh::key_nodes(finger)),
    on: |mesh| exported(TruthId::Continuum, &calculix::PROGRAM, mesh.finger()),
};

fn exported(id: TruthId, program: &'static Program, finger: &Finger) -> Result<Box<dyn Truth + 'static>, TruthError> {
    let truth = ExportedTruth::new(id, program, finger).map_err(|error| TruthError::NotExported(id, error))?;
    Ok(Box::new(truth))
}

/// Tolerance within which positions (mm), directions (degrees) and forces (N) count as equal.
pub const SAME: f64 = 1e-9;

/// Why an export has no shapes for a request.
#[derive(Debug, thiserror::Error)]
pub enum NotExported {
    /// The finger was not exported.
    #[error("{coverage}; this scene has another finger", coverage = .0.coverage())]
    Finger(&'static Program),
    /// The force was not exported.
    #[error("{program}'s shapes of the finger {finger} were exported for forces of {exported} N, not for {asked} N")]
    Force {
        /// Name of the program.
        program: &'static str,
        /// Name of the export.
        finger: &'static str,
        /// Requested force, N.
        asked: f64,
        /// All exported forces, N, as text.
        exported: String,
    },
    /// The shipped table cannot be read.
    #[error(transparent)]
    Table(#[from] ExportError),
}

/// Exported shapes of a finger, by node, direction and force.
#[derive(Debug, Clone)]
pub struct ExportedTruth {
    id: TruthId,
    program: &'static Program,
    finger: Finger,
    name: &'static str,
    cases: Vec<StaticCase>,
}

impl ExportedTruth {
    /// Reads the shapes of a finger that `program` exported, as the true finger `id`.
    ///
    /// # Errors
    /// [`NotExported::Finger`] for a finger that was not exported; [`NotExported::Table`] if the shipped table cannot be read.
    pub fn new(id: TruthId, program: &'static Program, finger: &Finger) -> Result<ExportedTruth, NotExported> {
        let exported = program.export_of(finger).ok_or(NotExported::Finger(program))?;
        Ok(ExportedTruth { id, program, finger: finger.clone(), name: exported.name, cases: exported.cases()? })
    }

    fn require_force(&self, force_n: f64) -> Result<(), NotExported> {
        let forces = growing(self.cases.iter().map(|case| case.force_n));
        if forces.iter().any(|force| (force - force_n).abs() < SAME) {
            return Ok(());
        }
        let exported = forces.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        Err(NotExported::Force { program: self.program.name, finger: self.name, asked: force_n, exported })
    }

    fn case(&self, contact: &Contact, force_n: f64) -> Option<&StaticCase> {
        let position = |node: NodeId| self.finger.front_position_mm(node).unwrap_or(f64::NAN);
        let asked = contact.position_mm(&self.finger)?;
        self.cases.iter().find(|case| {
            let apart = [position(case.node) - asked, case.angle_deg - contact.angle_deg, case.force_n - force_n];
            apart.iter().all(|difference| difference.abs() < SAME)
        })
    }
}

fn growing(figures: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut figures: Vec<f64> = figures.collect();
    figures.sort_by(f64::total_cmp);
    figures.dedup_by(|a, b| (*a - *b).abs() < SAME);
    figures
}

impl Truth for ExportedTruth {
    fn id(&self) -> TruthId {
        self.id
    }

    fn no_shape(&self) -> &'static str {
        "no shape was exported: the exporting program found no equilibrium under this force, or its shape is too uncertain"
    }

    /// Exported positions and directions, both ascending. A request for a force that was not exported is an error.
    fn positions(&self, forces_n: &[f64]) -> Result<Option<Positions>, TruthError> {
        for &force_n in forces_n {
            self.require_force(force_n).map_err(|error| TruthError::NotExported(self.id, error))?;
        }
        let positions = self.cases.iter().filter_map(|case| self.finger.front_position_mm(case.node));
        Ok(Some((growing(positions), growing(self.cases.iter().map(|case| case.angle_deg)))))
    }

    /// The list ends before the first force that was not exported, for example because the finger cannot carry it.
    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape> {
        forces_n.iter().map_while(|&force_n| Some(self.case(contact, force_n)?.shape.clone())).collect()
    }
}
