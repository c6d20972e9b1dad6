//! True finger: the scene's finger with linear statics. The mesh of key nodes gives the exact solution if every member has uniform stiffness.

use super::{MeshTruth, TruthId, TruthRow};
use finray_model::{Kinematics, Mesh};

pub(super) const ROW: TruthRow = TruthRow {
    name: "linear",
    label: "linear finger",
    help: "The finger with linear statics",
    kinematics: Some(Kinematics::Linear),
    mesh: |finger| Ok(Mesh::key_nodes(finger)),
    on: |mesh, _| Ok(Box::new(MeshTruth::new(TruthId::Linear, mesh, Kinematics::Linear)?)),
};
