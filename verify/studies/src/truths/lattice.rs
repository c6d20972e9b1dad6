//! The finger as rigid bodies and springs.

use super::{Truth, TruthId, TruthRow};
use crate::prelude::*;

pub(super) const ROW: TruthRow = TruthRow {
    name: "lattice",
    label: "lattice",
    help: "The finger as rigid bodies and springs, four segments between two key nodes, in the shape of least energy: the engine \
           settles in the same within 0.05 %, in seconds instead of milliseconds",
    kinematics: None,
    is_far_from_corotational: false,
    has_study: true,
    mesh: |finger| Ok(Mesh::key_nodes(finger)),
    on: |mesh| Ok(Box::new(LatticeTruth::new(mesh.finger())?)),
};

/// Segments of a plate's member between two key nodes: within 0.01 % of converged beams under 2 N, 0.04 % under 5 N.
const FINENESS: usize = 4;

/// A lattice in equilibrium.
///
/// Its shapes are those of least energy, by Newton's method in milliseconds; the engine settles within 0.05 % in seconds.
#[derive(Debug, Clone)]
pub struct LatticeTruth {
    lattice: Lattice,
}

impl LatticeTruth {
    /// Builds the lattice of a finger.
    ///
    /// # Errors
    /// [`LatticeError`] if the finger has more ribs than a lattice can be built for.
    pub fn new(finger: &Finger) -> Result<LatticeTruth, LatticeError> {
        Ok(LatticeTruth { lattice: Lattice::new(finger, FINENESS)? })
    }
}

impl Truth for LatticeTruth {
    fn id(&self) -> TruthId {
        TruthId::Lattice
    }

    fn shapes(&self, contact: &Contact, forces_n: &[f64]) -> Vec<FingerShape> {
        let load = contact.unit_load(self.lattice.finger());
        self.lattice.path(&[load], forces_n).map(|(shapes, _)| shapes).unwrap_or_default()
    }
}
