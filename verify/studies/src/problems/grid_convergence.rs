//! Observed order of convergence and grid convergence index.
//!
//! Source: P. J. Roache, J. Fluids Eng. 116 (1994) 405-413; I. B. Celik et al., J. Fluids Eng. 130 (2008) 078001.
//!
//! The expected orders follow from the angle phi by which an element bends; phi is proportional to the element's length h. The relative error of its
//! chord is of order phi^2 with chord strain and phi^4 with shallow-arch strain, which gives orders 2 and 4. The shallow-arch strain also ignores
//! that an elongated beam has more length to bend. The resulting error is phi^2 times the strain. On very fine meshes of elongated beams the order
//! therefore falls to 2. The error of phi^2 times the strain is small here, because the strain is 1e-4 to 1e-3.

use super::{ProblemError, elastica};
use crate::prelude::*;

/// Factor of safety for three meshes (Roache).
const SAFETY: f64 = 1.25;
/// The grid convergence index uses at most this order, which both strain measures reach on any mesh.
const FORMAL_ORDER: f64 = 2.0;
/// Tolerance of the observed order (dimensionless) for an inextensible cantilever: the effect of the next error term on meshes of 4 to 16 elements.
pub const CANTILEVER_TOLERANCE: f64 = 0.1;
/// Tolerance of the observed order (dimensionless) for the finger at 3 N. The finger's elements differ in length, and the error term of second order
/// begins to matter.
pub const FINGER_TOLERANCE: f64 = 0.25;
/// Load of the cantilever, P L^2 / EI, perpendicular to its axis.
const CANTILEVER_LOAD: f64 = 2.0;
/// Force on the finger, N.
const FORCE_N: f64 = 3.0;
/// Loaded nodes: beside the tip, in the middle, near the base.
const NODES: [usize; 3] = [14, 19, 24];
/// Elements per member of the three meshes whose grid convergence index is checked.
const ELEMENTS: [usize; 3] = [4, 8, 16];
/// Numbers of nodes: the paper's two meshes, and a finer mesh as reference for the index.
const NODE_COUNTS: [usize; 3] = [25, 684, 5000];
/// Tolerance of the displacement on 684 nodes, relative to the displacement. An element bends by up to 0.02 rad under a strain of up to 1e-3, so the
/// error of phi^2 times the strain is up to 4e-7 in each of the twelve members along a plate.
pub const FINE_MESH_TOLERANCE: f64 = 1e-5;
/// Tolerance of the grid convergence index on 5000 nodes, relative to the displacement; small compared with [`FINE_MESH_TOLERANCE`].
pub const FINEST_MESH_TOLERANCE: f64 = 1e-6;

/// Values of one quantity on three meshes, the coarsest first, and their extrapolation to the mesh-independent solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridConvergence {
    /// Numbers of nodes of the meshes.
    pub nodes: [usize; 3],
    /// Value of the quantity on each mesh, in the quantity's own unit.
    pub values: [f64; 3],
    /// Observed order of convergence, dimensionless; NaN if the values do not differ.
    pub order: f64,
    /// Mesh-independent value by Richardson extrapolation, in the unit of the values.
    pub extrapolated: f64,
    /// Grid convergence index: estimated error of the finest mesh times a factor of safety of 1.25, relative to the value on that mesh. The index uses
    /// the observed order, but at most 2, an order that errors reach on any mesh.
    pub index: f64,
}

impl GridConvergence {
    /// Procedure of Celik et al., eqs (3) to (7). `sizes` are representative element lengths in any common unit. The order p solves p ln(r21) =
    /// |ln|e32 / e21| + q(p)|, with q(p) = ln((r21^p - s) / (r32^p - s)) and s = sign(e32 / e21). Here r are ratios of sizes and e differences of
    /// values; p is found by fixed-point iteration.
    pub fn of(nodes: [usize; 3], sizes: [f64; 3], values: [f64; 3]) -> GridConvergence {
        let [r32, r21] = [sizes[0] / sizes[1], sizes[1] / sizes[2]];
        let [e32, e21] = [values[0] - values[1], values[1] - values[2]];
        let sign = (e32 / e21).signum();
        let q = |p: f64| ((r21.powf(p) - sign) / (r32.powf(p) - sign)).ln();
        let mut order = (e32 / e21).abs().ln().abs() / r21.ln();
        for _ in 0..50 {
            order = ((e32 / e21).abs().ln() + q(order)).abs() / r21.ln();
        }
        let left = |order: f64| e21 / (r21.powf(order) - 1.0);
        let extrapolated = values[2] - left(order);
        let index = SAFETY * (left(order.min(FORMAL_ORDER)) / values[2]).abs();
        GridConvergence { nodes, values, order, extrapolated, index }
    }
}

/// Displacement of the loaded node, mm, under 3 N along the inward normal.
fn displacement(mesh: &Mesh, node: NodeId, kinematics: Kinematics) -> Result<f64, ProblemError> {
    let load = Load::at_node(node, mesh.finger().direction(0.0) * FORCE_N);
    Ok(statics::solve(mesh, &[load], kinematics)?.motion(node).displacement.norm())
}

/// Grid convergence of a node's displacement (mm) under 3 N along the inward normal.
pub(crate) fn of_finger(
    meshes: [&Mesh; 3],
    node: NodeId,
    kinematics: Kinematics,
) -> Result<GridConvergence, ProblemError> {
    // Elements of one mesh differ in length, but all meshes divide the same members, so the inverse number of elements serves as size.
    let sizes = meshes.map(|mesh| 1.0 / mesh.frame().members().len() as f64);
    let mut values = [0.0; 3];
    for (value, mesh) in values.iter_mut().zip(meshes) {
        *value = displacement(mesh, node, kinematics)?;
    }
    Ok(GridConvergence::of(meshes.map(Mesh::node_count), sizes, values))
}

/// Grid convergence of the deflection of an inextensible cantilever. With the shallow-arch strain, the error of this deflection has no term of second
/// order.
fn of_cantilever(kinematics: Kinematics) -> Result<GridConvergence, ProblemError> {
    let mut values = [0.0; 3];
    for (value, elements) in values.iter_mut().zip(ELEMENTS) {
        [*value, ..] = elastica::solve(CANTILEVER_LOAD, 90.0, elements, kinematics)?;
    }
    Ok(GridConvergence::of(ELEMENTS.map(|n| n + 1), ELEMENTS.map(|n| 1.0 / n as f64), values))
}

/// Checks of the observed orders, of the grid convergence index against the error relative to 5000 nodes, and of the meshes with 684 and 5000 nodes.
pub(crate) fn checks(finger: &Finger) -> Result<Vec<Check>, ProblemError> {
    let [coarse, medium, fine] = ELEMENTS.map(|elements| Mesh::with_elements_per_member(finger, elements));
    let meshes = [&coarse, &medium, &fine];
    let mut checks = Vec::new();
    for (kinematics, name, order) in
        [(Kinematics::Corotational, "shallow-arch strain", 4.0), (Kinematics::CorotationalChord, "chord strain", 2.0)]
    {
        let on_finger = of_finger(meshes, NodeId(NODES[1]), kinematics)?;
        for (what, convergence, tolerance) in [
            ("cantilever", of_cantilever(kinematics)?, CANTILEVER_TOLERANCE),
            ("paper finger, 3 N at node 19", on_finger, FINGER_TOLERANCE),
        ] {
            let problem = format!("{what}, {name}, 4, 8, 16 elements per member");
            let subject = Kind::Analytical.on(problem, "error terms");
            checks.push(subject.is("order of convergence", order, convergence.order, tolerance));
        }
    }
    let mut by_nodes = Vec::new();
    for nodes in NODE_COUNTS {
        by_nodes.push(Mesh::with_nodes(finger, nodes)?);
    }
    let [coarsest, papers, finest] = &by_nodes[..] else { return Ok(checks) };
    for node in NODES.map(NodeId) {
        let bounded = of_finger(meshes, node, Kinematics::Corotational)?;
        let convergence = of_finger([coarsest, papers, finest], node, Kinematics::Corotational)?;
        let [_, on_papers, on_finest] = convergence.values;
        let mut row = |nodes: usize, source: &str, quantity, ours: f64, tolerance| {
            let problem = format!("paper finger, {FORCE_N} N at node {node}, {nodes} nodes");
            checks.push(Check::new(Kind::Internal, problem, source, quantity, 0.0, ours.abs(), tolerance));
        };
        let error = "relative error of the displacement";
        let left = bounded.values[2] / on_finest - 1.0;
        row(bounded.nodes[2], "5000 nodes; tolerance: grid convergence index", error, left, bounded.index);
        row(NODE_COUNTS[1], "5000 nodes", error, on_papers / on_finest - 1.0, FINE_MESH_TOLERANCE);
        let index = "grid convergence index";
        row(NODE_COUNTS[2], "25, 684, 5000 nodes", index, convergence.index, FINEST_MESH_TOLERANCE);
    }
    Ok(checks)
}
