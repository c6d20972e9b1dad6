//! Displacements of the key nodes under unit forces: the columns of the compliance that sensing needs, and no others.
//!
//! The linear finger is exact at its key nodes with one element a member, so the coarsest mesh serves.

use crate::finger::{Finger, NodeId};
use crate::mesh::{Load, Mesh};
use crate::statics::{Statics, StaticsError};
use crate::{Kinematics, Vector};

/// Displacement of every key node under each of some unit loads, mm per N (and per N mm of a moment).
#[derive(Debug, Clone, PartialEq)]
pub struct Compliance {
    /// By load, then by key node.
    columns: Vec<Vec<Vector>>,
}

impl Compliance {
    /// Solves the linear finger (eq. (5) of Xu et al. 2021) for each load: one factorisation, one solution a load.
    ///
    /// # Errors
    /// [`StaticsError`] for a load that is not on the finger, or a finger whose stiffness cannot be factorised.
    pub fn new(finger: &Finger, loads: &[Load]) -> Result<Compliance, StaticsError> {
        let mesh = Mesh::key_nodes(finger);
        let frame_loads = loads.iter().map(|load| mesh.frame_load(load)).collect::<Result<Vec<_>, _>>()?;
        let motions = Statics::ladder(&mesh, Kinematics::Linear).unit_motions(&frame_loads)?;
        let key_nodes = finger.key_node_count();
        Ok(Compliance { columns: motions.into_iter().map(|m| m.displacements[..key_nodes].to_vec()).collect() })
    }

    /// Number of loads.
    pub fn load_count(&self) -> usize {
        self.columns.len()
    }

    /// Displacement of a node under load `load`, mm per unit.
    pub fn displacement(&self, node: NodeId, load: usize) -> Vector {
        self.columns[load][node.0 - 1]
    }
}
