//! Shapes of three fingers computed by MuJoCo, read from exported tables. MuJoCo uses another formulation (discrete elastic rods between rigid
//! rods) and independent code. `fixtures/mujoco/README.md` describes the export and its accuracy.

use crate::prelude::*;

/// Why a shipped table from MuJoCo could not be used.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The table cannot be read.
    #[error("cannot read MuJoCo's table: {0}")]
    Table(#[from] csv::Error),
    /// The scene of the exported finger cannot be read.
    #[error("cannot read the scene of MuJoCo's finger: {0}")]
    Scene(String),
    /// A case does not list every key node in order.
    #[error("MuJoCo's table must list the finger's {key_nodes} key nodes in order, but {case} does not")]
    Nodes {
        /// Name of the faulty case.
        case: String,
        /// Number of key nodes of the finger.
        key_nodes: usize,
    },
}

/// A finger whose shapes under single forces were exported from MuJoCo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExportedFinger {
    /// Name of the exported table.
    pub name: &'static str,
    scene: &'static str,
    csv: &'static str,
}

/// All exported fingers.
pub const FINGERS: [ExportedFinger; 3] = [
    ExportedFinger { name: "paper", scene: finray_fixtures::PAPER_SCENE, csv: finray_fixtures::MUJOCO_PAPER },
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
];

/// Equilibrium of a finger under one dead force on a node, by MuJoCo.
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
    /// Uncertainty that the export states for each rotation, rad.
    pub uncertainty_rad: f64,
}

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

/// Equilibrium of the paper's finger with a rigid cylinder pushed into it, by MuJoCo.
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
    uncertainty_rad: f64,
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

impl ExportedFinger {
    /// The export of the finger that equals `finger`, regardless of names; `None` if no exported finger equals it.
    pub fn of(finger: &Finger) -> Option<&'static ExportedFinger> {
        FINGERS.iter().find(|exported| exported.finger().is_ok_and(|known| known == *finger))
    }

    /// The exported finger.
    ///
    /// # Errors
    /// [`ExportError`] if the shipped scene cannot be read.
    pub fn finger(&self) -> Result<Finger, ExportError> {
        let scene = Scene::from_toml(self.scene).map_err(|error| ExportError::Scene(error.to_string()))?;
        Ok(scene.finger)
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

/// All steps of all pushes of a cylinder into the paper's finger.
///
/// # Errors
/// [`ExportError`] if the shipped table cannot be read.
pub fn contact_steps() -> Result<Vec<ContactStep>, ExportError> {
    let finger = FINGERS[0].finger()?;
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
