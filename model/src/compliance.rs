//! Displacements of the markers under unit forces: the columns of the compliance matrix that sensing needs.
//!
//! With one element per member, the solution of the linear finger is exact at the key nodes, so the coarsest mesh suffices. Only two kinds of members
//! are approximated: members of tapered plates, and members within which a zone starts or ends. For a member of a tapered plate, or a member within
//! which a zone starts or ends, the solution uses the mean compliances of the member.

use crate::element::quarter_turn;
use crate::finger::{Finger, NodeId};
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::{Load, LoadError, Mesh};
use crate::statics::{Statics, StaticsError};
use crate::{Kinematics, Vector};
use nalgebra::{Matrix3, Vector3};
use std::sync::OnceLock;

/// Displacement of each key node's marker under each of several loads, mm. For a load of 1 N or 1 N mm, the displacement is the compliance in mm/N or
/// 1/N.
#[derive(Debug, Clone, PartialEq)]
pub struct Compliance {
    /// Displacements, indexed by load and then by key node from 0.
    columns: Vec<Vec<Vector>>,
}

impl Compliance {
    /// Solves the linear finger (eq. (5) of Xu et al. 2021) for each load; all loads share one factorisation.
    ///
    /// # Errors
    /// [`StaticsError`] for a load at an invalid point, or for a finger whose stiffness cannot be factorised.
    pub fn new(finger: &Finger, loads: &[Load]) -> Result<Compliance, StaticsError> {
        let mesh = Mesh::key_nodes(finger);
        let frame_loads = loads.iter().map(|load| mesh.frame_load(load)).collect::<Result<Vec<_>, _>>()?;
        let motions = Statics::ladder(&mesh, Kinematics::Linear).unit_motions(&frame_loads)?;
        let markers: Vec<_> = (1..=finger.key_node_count()).map(|node| mesh.marker_node(NodeId(node))).collect();
        let column = |motion: FrameMotion| markers.iter().map(|marker| motion.displacements[*marker]).collect();
        Ok(Compliance { columns: motions.into_iter().map(column).collect() })
    }

    /// Number of loads.
    pub fn load_count(&self) -> usize {
        self.columns.len()
    }

    /// Displacement of a node's marker under the load of index `load`, mm, finger frame.
    pub fn displacement(&self, node: NodeId, load: usize) -> Vector {
        self.columns[load][node.0 - 1]
    }
}

/// Compliance of the linear finger for forces and moments on its key nodes. The solutions for unit loads on the key nodes are reused for many loads.
///
/// A load between two key nodes is replaced by its consistent nodal loads on these two nodes. For the cubic beam, this replacement of the load leaves
/// the displacements of all key nodes exactly unchanged. One solution per key node therefore suffices for loads at any point. Each solution is
/// computed when a load first needs it.
#[derive(Debug, Clone)]
pub struct NodalCompliance {
    mesh: Mesh,
    at_rest: FrameMotion,
    /// Solution for unit loads on each key node.
    nodes: Vec<OnceLock<Result<Blocks, StaticsError>>>,
}

/// A 3 x 3 matrix per key node. The rows of a matrix are displacement x, y (mm) and rotation (rad); its columns are the loads 1 N along x, 1 N along
/// y and 1 N mm on the loaded node.
type Blocks = Vec<Matrix3<f64>>;

/// Index of a key node, counted from 0, and the load on this node: force x, y (N) and moment (N mm).
type NodalLoad = (usize, Vector3<f64>);

impl NodalCompliance {
    /// Meshes the finger. Solutions are computed on demand.
    pub fn new(finger: &Finger) -> NodalCompliance {
        let mesh = Mesh::key_nodes(finger);
        let nodes = vec![OnceLock::new(); finger.key_node_count()];
        NodalCompliance { at_rest: FrameMotion::at_rest(mesh.frame()), mesh, nodes }
    }

    /// The finger that has this compliance.
    pub fn finger(&self) -> &Finger {
        self.mesh.finger()
    }

    /// Displacement (x, y, mm) and rotation (rad) of every key node under a load.
    ///
    /// # Errors
    /// [`StaticsError`] as for [`Compliance::new`].
    pub fn motions(&self, load: &Load) -> Result<Vec<Vector3<f64>>, StaticsError> {
        let mut sums = vec![Vector3::zeros(); self.nodes.len()];
        for (node, force) in self.nodal_loads(load)?.into_iter().flatten() {
            for (sum, block) in sums.iter_mut().zip(self.blocks(node)?) {
                *sum += block * force;
            }
        }
        Ok(sums)
    }

    /// The compliance for several loads. The result equals the result of [`Compliance::new`] up to rounding.
    ///
    /// # Errors
    /// [`StaticsError`] as for [`Compliance::new`].
    pub fn columns(&self, loads: &[Load]) -> Result<Compliance, StaticsError> {
        let finger = self.finger();
        let offsets: Vec<_> =
            (1..=self.nodes.len()).map(|node| quarter_turn(finger.marker_offset(NodeId(node)))).collect();
        let markers = |motions: Vec<Vector3<f64>>| {
            motions.iter().zip(&offsets).map(|(motion, offset)| motion.xy() + offset * motion.z).collect()
        };
        let column = |load| Ok(markers(self.motions(load)?));
        Ok(Compliance { columns: loads.iter().map(column).collect::<Result<_, StaticsError>>()? })
    }

    /// Converts a load to equivalent loads on free key nodes: both ends of the loaded member, or the one node that carries the load.
    fn nodal_loads(&self, load: &Load) -> Result<[Option<NodalLoad>; 2], LoadError> {
        let frame = self.mesh.frame();
        // A load on a clamped node causes no motion.
        let free =
            |node: usize, force: Vector3<f64>| (!self.finger().is_clamped(NodeId(node + 1))).then_some((node, force));
        Ok(match self.mesh.frame_load(load)? {
            FrameLoad::Interior { member, xi, force } => {
                let gradient = frame.interior_load(&self.at_rest, member, Kinematics::Linear, xi, force).gradient;
                let [first, second] = frame.members()[member].ends.map(|end| end.node);
                [free(first, -gradient.fixed_rows::<3>(0)), free(second, -gradient.fixed_rows::<3>(3))]
            }
            on_node => {
                let (end, force, moment_nmm) = on_node.at_end(frame);
                let gradient = frame.end_load(&self.at_rest, end, force, moment_nmm, true).gradient;
                [free(end.node, -gradient.fixed_rows::<3>(0)), None]
            }
        })
    }

    /// Motions of all key nodes under unit loads on the key node of index `node`, counted from 0.
    fn blocks(&self, node: usize) -> Result<&[Matrix3<f64>], StaticsError> {
        let solved = self.nodes[node].get_or_init(|| {
            let unit = |force, moment_nmm| FrameLoad::Node { node, force, moment_nmm };
            let units = [unit(Vector::x(), 0.0), unit(Vector::y(), 0.0), unit(Vector::zeros(), 1.0)];
            let motions = Statics::ladder(&self.mesh, Kinematics::Linear).unit_motions(&units)?;
            let rows = |motion: &FrameMotion, key_node: usize| {
                let rotation = motion.rotations[self.mesh.frame().rotation_of(key_node)];
                motion.displacements[key_node].push(rotation)
            };
            let block = |key_node| Matrix3::from_fn(|row, column| rows(&motions[column], key_node)[row]);
            Ok((0..self.nodes.len()).map(block).collect())
        });
        solved.as_deref().map_err(|error| *error)
    }
}
