//! The elastic energy of the bent finger equals the work of its load.
//!
//! Source: conservation of energy. With the displacement u of the loaded node along the force F, the work is F u(F) minus the integral of u over F,
//! by Boole's rule.

use super::ProblemError;
use crate::prelude::*;
use finray_model::statics::{Statics, elastic_energy};

/// Full load, N.
const FORCE_N: f64 = 3.0;
/// Loaded nodes: beside the tip, in the middle, near the base.
const NODES: [usize; 3] = [14, 19, 24];
/// Number of intervals of the quadrature.
const STEPS: usize = 64;
/// Tolerance of energy against work, relative to the work. Simpson's rule alone has an error of at most 4e-10 here, estimated as its difference from
/// the result with half as many intervals, divided by 15. Boole's rule, which extrapolates Simpson's rule, is much more accurate. The rest of the
/// tolerance covers the convergence error of Newton's method.
pub const TOLERANCE: f64 = 1e-10;

/// Elastic energy and work of the load, N mm.
fn solve(mesh: &Mesh, node: NodeId) -> Result<[f64; 2], ProblemError> {
    let force = mesh.finger().direction(0.0) * FORCE_N;
    let load = mesh.frame_load(&Load::at_node(node, force)).map_err(|error| ProblemError::Statics(error.into()))?;
    let multiples: Vec<f64> = (1..=STEPS).map(|i| i as f64 / STEPS as f64).collect();
    let (path, failed) = Statics::ladder(mesh, Kinematics::Corotational).path(&[load], &multiples);
    if let Some(error) = failed {
        return Err(error.into());
    }
    let moved: Vec<f64> = std::iter::once(0.0)
        .chain(path.iter().map(|at| force.dot(&at.motion.displacements[mesh.frame_node(node)])))
        .collect();
    let work = |every: usize| {
        let u: Vec<f64> = moved.iter().step_by(every).copied().collect();
        let simpson: f64 = u.windows(3).step_by(2).map(|w| (w[0] + 4.0 * w[1] + w[2]) / 3.0).sum();
        moved[STEPS] - simpson * every as f64 / STEPS as f64
    };
    let energy = elastic_energy(mesh.frame(), &path[STEPS - 1].motion, Kinematics::Corotational);
    Ok([energy, work(1) + (work(1) - work(2)) / 15.0])
}

/// One check for each loaded node.
pub(crate) fn checks(finger: &Finger) -> Result<Vec<Check>, ProblemError> {
    let mesh = Mesh::key_nodes(finger);
    let mut checks = Vec::new();
    for node in NODES.map(NodeId) {
        let [energy, work] = solve(&mesh, node)?;
        let problem = format!("paper finger, {FORCE_N} N at node {node}");
        let subject = Kind::Internal.on(problem, "work of the load along its path");
        checks.push(subject.is("elastic energy (N mm)", work, energy, TOLERANCE * work));
    }
    Ok(checks)
}
