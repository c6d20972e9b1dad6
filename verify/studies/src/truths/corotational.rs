//! True finger: the scene's finger on a fine mesh, with co-rotational statics.

use super::{MeshTruth, TruthId, TruthRow, fine_mesh};
use finray_model::Kinematics;

pub(super) const ROW: TruthRow = TruthRow {
    name: "corotational",
    label: "uniform finger",
    help: "The finger with co-rotational statics, on a mesh of 684 nodes, or of four elements per member if that gives \
        more nodes",
    kinematics: Some(Kinematics::Corotational),
    mesh: |finger| Ok(fine_mesh(finger)?),
    on: |mesh, _| Ok(Box::new(MeshTruth::new(TruthId::Corotational, mesh, Kinematics::Corotational)?)),
};
