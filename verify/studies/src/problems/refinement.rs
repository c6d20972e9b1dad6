//! Comparison of the paper's two meshes, with 25 and 684 nodes.
//!
//! Linear frame theory is exact at nodes, so a finer mesh changes only the rounding errors. The paper reports a difference of 0.26 % between the
//! meshes (sec. III).

use super::ProblemError;
use crate::check::difference;
use crate::prelude::*;
use crate::sampling::scatter::sampled_nodes;
use crate::truths::fine_mesh;

/// Tolerance between the meshes, relative to the largest displacement: the rounding error of a double-precision solution on 684 nodes. The rounding
/// error grows with about the fourth power of the number of nodes.
pub const ROUNDING_TOLERANCE: f64 = 1e-8;
/// Force on the linear finger, N. The displacements of the linear finger are proportional to the force, so any value is suitable.
const ANY_FORCE_N: f64 = ReportForces::PAPER.drawn_n();
/// Directions, degrees from the inward normal.
const ANGLES_DEG: [f64; 3] = [-45.0, 0.0, 45.0];

/// Largest difference of a key node's displacement between two meshes, relative to the largest displacement, over three directions of the force
/// `force_n` (N).
fn refined(
    finger: &Finger,
    meshes: [&Mesh; 2],
    (node, force_n): (NodeId, f64),
    kinematics: Kinematics,
) -> Result<f64, ProblemError> {
    let differences = ANGLES_DEG.map(|angle_deg| -> Result<f64, ProblemError> {
        let load = Load::at_node(node, finger.direction(angle_deg) * force_n);
        let [coarse, fine] = meshes.map(|mesh| statics::solve(mesh, &[load], kinematics));
        Ok(difference(&fine?, &coarse?))
    });
    Ok(worst(differences.into_iter().collect::<Result<Vec<_>, _>>()?))
}

/// Largest difference between the linear finger's two meshes, relative to the largest displacement, over loads along the front plate.
pub(crate) fn linear_difference(finger: &Finger) -> Result<f64, ProblemError> {
    let (coarse, fine) = (Mesh::key_nodes(finger), fine_mesh(finger)?);
    let differences = sampled_nodes(finger)
        .into_iter()
        .map(|node| refined(finger, [&coarse, &fine], (node, ANY_FORCE_N), Kinematics::Linear));
    Ok(worst(differences.collect::<Result<Vec<_>, _>>()?))
}

/// Checks that the linear finger does not depend on the mesh. Returns no checks for fingers with tapered plates, or with zones, because a zone may
/// end inside an element.
pub(crate) fn checks(finger: &Finger) -> Result<Vec<Check>, ProblemError> {
    let tapers = [Plate::Front, Plate::Back].into_iter().any(|plate| finger.tapers(plate));
    if tapers || !finger.description().zones.is_empty() {
        return Ok(Vec::new());
    }
    let [coarse, fine] = [finger.key_node_count(), fine_mesh(finger)?.node_count()];
    let problem = format!("mesh of {coarse} against mesh of {fine} nodes, linear, loads along the front plate");
    let quantity = "largest displacement difference / largest displacement";
    let exact = Kind::Internal.on(problem, "nodal exactness of linear frames");
    Ok(vec![exact.vanishes(quantity, linear_difference(finger)?, ROUNDING_TOLERANCE)])
}

/// Difference of the coarse co-rotational mesh from the fine mesh under a force (N), by loaded node.
pub(crate) fn comparisons(finger: &Finger, force_n: f64) -> Result<Vec<Comparison>, ProblemError> {
    let (coarse, fine) = (Mesh::key_nodes(finger), fine_mesh(finger)?);
    let mut comparisons = Vec::new();
    for (kinematics, name) in
        [(Kinematics::CorotationalChord, "chord strain"), (Kinematics::Corotational, "shallow-arch strain")]
    {
        for node in sampled_nodes(finger) {
            let Ok(ours) = refined(finger, [&coarse, &fine], (node, force_n), kinematics) else { continue };
            comparisons.push(Comparison {
                problem: format!(
                    "mesh of {} against mesh of {} nodes, co-rotational ({name}), {force_n} N at node {node}",
                    finger.key_node_count(),
                    fine.node_count()
                ),
                source: "own fine mesh".to_owned(),
                quantity: "largest displacement difference / largest displacement".to_owned(),
                reference: 0.0,
                ours,
            });
        }
    }
    Ok(comparisons)
}
