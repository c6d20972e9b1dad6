//! Displacements under loads, with the reasons why they may be inaccurate.

use crate::Kinematics;
use crate::mesh::{FingerShape, Load, Mesh, MeshSizeError};
use crate::scene::Scene;
use crate::statics::{self, Statics, StaticsError};
use crate::validity::{Validity, ValidityWarning};
use std::fmt;

/// The mesh of the key nodes is checked against a mesh with this number of elements per member.
const CHECKED_ELEMENTS: usize = 8;
/// [`MeshWarning::Coarse`] is reported if the mesh of the key nodes displaces a key node with an error above this share of the largest displacement. Xu
/// et al. (2021) use the mesh of the key nodes for their finger; its error is below this share while strains are small.
const COARSE: f64 = 0.1;

/// Displacements of a finger under loads, with the reasons why they may be inaccurate.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedShape {
    /// Displacements of the key nodes.
    pub shape: FingerShape,
    /// Reason why the mesh of the key nodes may be too coarse. `None` if the finer mesh agrees, or if the caller gave the number of mesh nodes.
    pub mesh_warning: Option<MeshWarning>,
    /// Violated assumptions of the beam model.
    pub validity: Vec<ValidityWarning>,
}

/// Reason why the mesh of the key nodes may be too coarse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeshWarning {
    /// The finer mesh has no equilibrium.
    NoResult {
        /// Number of nodes of the finer mesh.
        nodes: usize,
        /// Reason why the finer mesh has no equilibrium.
        reason: StaticsError,
    },
    /// A key node has a different displacement on the finer mesh.
    Coarse {
        /// Number of nodes of the finer mesh.
        nodes: usize,
        /// Largest displacement on the finer mesh, mm.
        largest_mm: f64,
        /// Largest distance between the positions of a key node on the two meshes, mm.
        error_mm: f64,
    },
}

/// Reason why displacements cannot be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CheckedShapeError {
    /// The number of mesh nodes is out of range.
    #[error(transparent)]
    Mesh(#[from] MeshSizeError),
    /// There is no equilibrium.
    #[error(transparent)]
    Statics(#[from] StaticsError),
}

impl CheckedShape {
    /// The displacements of a scene's finger under dead loads. Without `mesh_nodes`, the mesh consists of the key nodes and is compared with a finer
    /// mesh.
    ///
    /// # Errors
    /// [`CheckedShapeError`] for a wrong number of mesh nodes, a wrong load, or loads without an equilibrium.
    pub fn under(
        scene: &Scene,
        loads: &[Load],
        kinematics: Kinematics,
        mesh_nodes: Option<usize>,
    ) -> Result<CheckedShape, CheckedShapeError> {
        let finger = &scene.finger;
        let mesh = match mesh_nodes {
            None => Mesh::key_nodes(finger),
            Some(nodes) => Mesh::with_nodes(finger, nodes)?,
        };
        let frame_loads = loads.iter().map(|load| mesh.frame_load(load)).collect::<Result<Vec<_>, _>>();
        let frame_loads = frame_loads.map_err(StaticsError::from)?;
        let motion = Statics::ladder(&mesh, kinematics).accurate_equilibrium(&frame_loads)?.motion;
        let shape = mesh.shape(&motion);
        let mesh_warning = if mesh_nodes.is_some() { None } else { MeshWarning::of(&shape, scene, loads, kinematics) };
        let validity = Validity::of(&mesh, &motion, kinematics, &frame_loads).warnings(&scene.strain_limits);
        Ok(CheckedShape { shape, mesh_warning, validity })
    }

    /// Every reason why the displacements may be inaccurate, in words.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.mesh_warning.iter().map(ToString::to_string).chain(self.validity.iter().map(ToString::to_string))
    }
}

impl MeshWarning {
    /// Compares a shape on the mesh of the key nodes with the shape on a finer mesh. `None` if the two shapes agree.
    fn of(shape: &FingerShape, scene: &Scene, loads: &[Load], kinematics: Kinematics) -> Option<MeshWarning> {
        let finer = Mesh::with_elements_per_member(&scene.finger, CHECKED_ELEMENTS);
        let nodes = finer.node_count();
        let finer = match statics::solve(&finer, loads, kinematics) {
            Ok(finer) => finer,
            Err(reason) => return Some(MeshWarning::NoResult { nodes, reason }),
        };
        let pairs = shape.motions().iter().zip(finer.motions());
        let error_mm = pairs.map(|(a, b)| (a.displacement - b.displacement).norm()).fold(0.0, f64::max);
        let largest_mm = finer.largest_displacement_mm();
        (error_mm > COARSE * largest_mm).then_some(MeshWarning::Coarse { nodes, largest_mm, error_mm })
    }
}

impl fmt::Display for MeshWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MeshWarning::NoResult { nodes, reason } => write!(
                f,
                "the mesh of the key nodes may be too coarse: a finer mesh of {nodes} nodes has no result: {reason}; choose {nodes} mesh nodes"
            ),
            MeshWarning::Coarse { nodes, largest_mm, error_mm } => write!(
                f,
                "the mesh of the key nodes is too coarse: on a finer mesh of {nodes} nodes the largest displacement is \
                 {largest_mm:.3} mm, and the displacement of a key node differs by {error_mm:.3} mm; choose {nodes} mesh nodes"
            ),
        }
    }
}
