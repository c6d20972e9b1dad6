//! Shapes of fingers under single forces, computed by other programs and read from exported tables.
//!
//! Entry points: [`mujoco::PROGRAM`] solves the same beams by another formulation; [`calculix::PROGRAM`] solves fingers as plane continua.

pub mod calculix;
mod differences;
pub mod mujoco;

use differences::differences;
pub use differences::{Difference, Solved};

use crate::prelude::*;

/// Why a shipped table of another program could not be used.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The table cannot be read.
    #[error("cannot read a shipped table: {0}")]
    Table(#[from] csv::Error),
    /// The scene of the exported finger cannot be read.
    #[error("cannot read the scene of an exported finger: {0}")]
    Scene(#[from] SceneError),
    /// A case does not list every key node in order.
    #[error("a table must list the finger's {key_nodes} key nodes in order, but {case} does not")]
    Nodes {
        /// Name of the faulty case.
        case: String,
        /// Number of key nodes of the finger.
        key_nodes: usize,
    },
}

/// A program, and the fingers whose shapes it computed.
#[derive(Debug)]
pub struct Program {
    /// Name of the program.
    pub name: &'static str,
    /// All exported fingers. At most one of the exports applies to a given scene's finger.
    pub fingers: &'static [ExportedFinger],
    /// Model whose shapes the program computed.
    solved: Solved,
}

impl Program {
    /// The export whose shapes are those of the scene's finger, regardless of names; `None` if no export applies.
    pub fn export_of(&self, scene: &Scene) -> Option<&'static ExportedFinger> {
        self.nearest(scene).and_then(|(exported, differences)| differences.is_empty().then_some(exported))
    }

    /// The exported finger that shares most keys with the scene's finger, and the keys that differ; `None` if no shipped scene can be read.
    pub fn nearest(&self, scene: &Scene) -> Option<(&'static ExportedFinger, Vec<Difference>)> {
        let compared = self
            .fingers
            .iter()
            .filter_map(|exported| Some((exported, differences(scene, &exported.scene().ok()?, self.solved))));
        compared.min_by_key(|(_, differences)| differences.len())
    }

    /// Names of the exported fingers, separated by commas.
    pub fn names(&self) -> String {
        self.fingers.iter().map(|exported| exported.name).collect::<Vec<_>>().join(", ")
    }
}

/// A finger whose shapes under single forces were exported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExportedFinger {
    /// Name of the exported table.
    pub name: &'static str,
    scene: &'static str,
    csv: &'static str,
}

/// Equilibrium of a finger under one dead force on a node.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticCase {
    /// The loaded node.
    pub node: NodeId,
    /// Direction of the force, degrees from the undeformed inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Magnitude of the force, N.
    pub force_n: f64,
    /// Force vector in the finger frame, N.
    pub force: Vector,
    /// Displacements and rotations of the key nodes.
    pub shape: FingerShape,
    /// Uncertainty that the export states for each displacement, mm.
    pub uncertainty_mm: f64,
    /// Uncertainty that the export states for each rotation, rad; `None` if it states none.
    pub uncertainty_rad: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct StaticRow {
    case: usize,
    load: usize,
    force_n: f64,
    angle_deg: f64,
    fx_n: f64,
    fy_n: f64,
    node: usize,
    ux_mm: f64,
    uy_mm: f64,
    theta_rad: f64,
    uncertainty_mm: f64,
    uncertainty_rad: Option<f64>,
}

impl ExportedFinger {
    /// The exported finger.
    ///
    /// # Errors
    /// [`ExportError`] if the shipped scene cannot be read.
    pub fn finger(&self) -> Result<Finger, ExportError> {
        Ok(self.scene()?.finger)
    }

    /// Text of the exported finger's scene.
    pub fn text(&self) -> &'static str {
        self.scene
    }

    /// The scene of the exported finger.
    ///
    /// # Errors
    /// [`ExportError`] if the shipped scene cannot be read.
    pub fn scene(&self) -> Result<Scene, ExportError> {
        Ok(Scene::from_toml(self.scene)?)
    }

    /// All exported cases, ordered by node, direction and ascending force.
    ///
    /// # Errors
    /// [`ExportError`] if the shipped table cannot be read.
    pub fn cases(&self) -> Result<Vec<StaticCase>, ExportError> {
        let finger = self.finger()?;
        let rows: Vec<StaticRow> = rows(self.csv)?;
        rows.chunk_by(|a, b| a.case == b.case)
            .map(|case| {
                let first = &case[0];
                let motions = case.iter().map(|row| (row.node, [row.ux_mm, row.uy_mm, row.theta_rad]));
                Ok(StaticCase {
                    node: NodeId(first.load),
                    angle_deg: first.angle_deg,
                    force_n: first.force_n,
                    force: Vector::new(first.fx_n, first.fy_n),
                    shape: shape(&finger, || format!("{}, case {}", self.name, first.case), motions)?,
                    uncertainty_mm: first.uncertainty_mm,
                    uncertainty_rad: first.uncertainty_rad,
                })
            })
            .collect()
    }
}

fn rows<R: for<'a> Deserialize<'a>>(csv: &str) -> Result<Vec<R>, ExportError> {
    Ok(csv::Reader::from_reader(csv.as_bytes()).deserialize().collect::<Result<_, _>>()?)
}

fn shape(
    finger: &Finger,
    case: impl Fn() -> String,
    motions: impl Iterator<Item = (usize, [f64; 3])>,
) -> Result<FingerShape, ExportError> {
    let motions: Vec<(usize, [f64; 3])> = motions.collect();
    let key_nodes = finger.key_node_count();
    if !motions.iter().map(|(node, _)| *node).eq(1..=key_nodes) {
        return Err(ExportError::Nodes { case: case(), key_nodes });
    }
    Ok(FingerShape::new(finger, false, |node| {
        let [ux, uy, theta] = motions[node.0 - 1].1;
        (Vector::new(ux, uy), theta)
    }))
}
