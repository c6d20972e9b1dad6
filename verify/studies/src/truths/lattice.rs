//! True finger: the scene's finger as rigid bodies and springs.

use super::{Truth, TruthId, TruthRow};
use crate::prelude::*;

pub(super) const ROW: TruthRow = TruthRow {
    name: "lattice",
    label: "lattice",
    help: "The finger as rigid bodies and springs, four segments between two key nodes, in the shape of least energy: the engine needs \
           seconds to settle within 0.05 % of this shape, instead of milliseconds",
    kinematics: None,
    is_far_from_corotational: false,
    has_study: true,
    mesh: |finger| Ok(Mesh::key_nodes(finger)),
    on: |mesh| Ok(Box::new(LatticeTruth::new(mesh.finger())?)),
};

/// Number of segments of a plate member between two key nodes. Shapes then differ from converged beams by 0.01 % under 2 N, and 0.04 % under 5 N.
const FINENESS: usize = 4;

/// A finger as a lattice of rigid bodies and springs, in equilibrium.
///
/// Newton's method finds shapes of least energy in milliseconds. The physics engine needs seconds to settle within 0.05 % of these shapes.
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
