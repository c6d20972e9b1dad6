//! Mesh refinement: co-rotational solutions on successively finer meshes against the converged solution.
//!
//! Every member is divided into 1, 2, 4, ... elements. The differences between the three finest solutions give the observed order p. Richardson
//! extrapolation of the two finest solutions gives the converged solution. Roache's grid convergence index bounds the error of the finest mesh.
//!
//! Source: Roache, Perspective: A Method for Uniform Reporting of Grid Refinement Studies, J. Fluids Eng. 116 (1994).

use super::{Context, Evidence};
use crate::prelude::*;
use crate::truths::FINE_MESH_NODES;

/// Force at which the mesh errors of the paper's finger are checked, N.
const CHECKED_FORCE_N: f64 = ReportForces::PAPER.drawn_n();
/// Approximate number of nodes that are loaded, one at a time.
const LOADED_NODES: usize = 12;
/// Factor of safety of the grid convergence index for three meshes (Roache 1994).
const SAFETY: f64 = 1.25;
/// Observed orders are limited to this range. An order outside this range results from rounding or chance.
const ORDERS: [f64; 2] = [0.5, 4.0];
/// This constant and the next two are the tolerances of the errors on three meshes of the paper's finger, relative to the largest displacement.
const KEY_NODES_TOLERANCE: f64 = 1e-2;
const TWO_ELEMENTS_TOLERANCE: f64 = 6e-3;
const FINE_MESH_TOLERANCE: f64 = 1e-4;
/// Tolerance of the estimated error of the finest mesh, relative to the largest displacement: a tenth of the smallest mesh tolerance.
const REFERENCE_TOLERANCE: f64 = 0.1 * FINE_MESH_TOLERANCE;

/// A mesh of the refinement study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshSize {
    /// Number of nodes.
    pub nodes: usize,
    /// Elements of every member; `None` for the paper's fine mesh, whose elements have about equal lengths.
    pub elements_a_member: Option<usize>,
}

/// Errors of the solutions under one load on all meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Largest difference of a key node's displacement from the converged displacement, relative to the largest displacement, by mesh.
    pub errors: Vec<f64>,
    /// Observed order of convergence in the element length, dimensionless; `None` if the differences do not shrink.
    pub order: Option<f64>,
    /// Grid convergence index: estimated error of the finest mesh, relative to the largest displacement, dimensionless.
    pub left: f64,
}

/// A force along the front plate's inward normal, with its solutions on every mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinedLoad {
    /// Node on which the force acts.
    pub node: NodeId,
    /// Force along the inward normal, N.
    pub force_n: f64,
    /// Errors on every mesh; `None` if a mesh has no equilibrium under the force.
    pub refinement: Option<Refinement>,
}

/// Results of the refinement study: meshes, and loads solved on each of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// Meshes by number of nodes.
    pub meshes: Vec<MeshSize>,
    /// Loads by node, then force.
    pub loads: Vec<RefinedLoad>,
}

/// A load on one mesh, as a row of the report's table.
#[derive(Debug, Serialize)]
pub struct ConvergenceRow {
    load_node: NodeId,
    force_n: f64,
    mesh_nodes: usize,
    elements_a_member: Option<usize>,
    error: Option<f64>,
    observed_order: Option<f64>,
    left_on_finest_mesh: Option<f64>,
}

impl Evidence for Convergence {
    fn checks(&self, context: &Context) -> Vec<Check> {
        if context.is_paper { self.checks() } else { Vec::new() }
    }
}

pub(crate) fn run(context: &Context) -> Result<Convergence, MeshSizeError> {
    context.progress.part("convergence", loaded_nodes(context.finger).len());
    let (first, most_nodes) = context.effort.choose((3, 2500), (0, 5000));
    let forces_n = &context.checked_forces().of_maps_n()[first..];
    convergence(context.finger, forces_n, most_nodes, &|| context.progress.step())
}

/// Solves ascending forces (N) on meshes of up to `most_nodes` nodes; loads without equilibrium leave gaps. `progress` is called after each loaded
/// node. Fails if the fine mesh cannot be built.
pub(crate) fn convergence(
    finger: &Finger,
    forces_n: &[f64],
    most_nodes: usize,
    progress: &(dyn Fn() + Sync),
) -> Result<Convergence, MeshSizeError> {
    let mut meshes = doubled_meshes(finger, most_nodes);
    let doubled = meshes.len();
    if finger.key_node_count() < FINE_MESH_NODES {
        meshes.push((None, Mesh::with_nodes(finger, FINE_MESH_NODES)?));
    }
    let mut order: Vec<usize> = (0..meshes.len()).collect();
    order.sort_by_key(|&i| meshes[i].1.node_count());
    let loads = loaded_nodes(finger)
        .into_par_iter()
        .flat_map_iter(|node| {
            let solutions: Vec<_> = meshes.iter().map(|(_, mesh)| path(mesh, node, forces_n)).collect();
            progress();
            let order = &order;
            forces_n.iter().enumerate().map(move |(i, &force_n)| {
                let solved: Option<Vec<&[Vector]>> =
                    solutions.iter().map(|path| path.get(i).map(Vec::as_slice)).collect();
                let refinement = solved.and_then(|solved| refine(&solved, doubled, order));
                RefinedLoad { node, force_n, refinement }
            })
        })
        .collect();
    let size = |&i: &usize| MeshSize { nodes: meshes[i].1.node_count(), elements_a_member: meshes[i].0 };
    Ok(Convergence { meshes: order.iter().map(size).collect(), loads })
}

/// Contact nodes except the tip, at most 12, evenly spaced; the tip if it is the only contact node.
pub fn loaded_nodes(finger: &Finger) -> Vec<NodeId> {
    let nodes: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
    if nodes.is_empty() {
        return vec![finger.tip()];
    }
    nodes.iter().copied().step_by(nodes.len().div_ceil(LOADED_NODES)).collect()
}

/// Meshes with 1, 2, 4, ... elements per member, up to `most_nodes` nodes. There are at least three meshes, because an observed order requires three.
fn doubled_meshes(finger: &Finger, most_nodes: usize) -> Vec<(Option<usize>, Mesh)> {
    let mut meshes: Vec<(Option<usize>, Mesh)> = Vec::new();
    let mut elements = 1;
    loop {
        let mesh = Mesh::with_elements_per_member(finger, elements);
        if meshes.len() >= 3 && mesh.node_count() > most_nodes {
            return meshes;
        }
        meshes.push((Some(elements), mesh));
        elements *= 2;
    }
}

/// Displacements of the key nodes (mm) under ascending forces (N), up to the last equilibrium.
fn path(mesh: &Mesh, node: NodeId, forces_n: &[f64]) -> Vec<Vec<Vector>> {
    let unit = Load::at_node(node, mesh.finger().direction(0.0));
    let Ok(load) = mesh.frame_load(&unit) else { return Vec::new() };
    let (equilibria, _) = Statics::ladder(mesh, Kinematics::Corotational).path(&[load], forces_n);
    let key_nodes = mesh.finger().key_node_count();
    equilibria.into_iter().map(|found| found.motion.displacements[..key_nodes].to_vec()).collect()
}

/// Errors of the solutions, in the sequence of solution numbers in `order`. In the first `doubled` solutions, each mesh has twice as many elements as
/// the mesh before.
fn refine(solutions: &[&[Vector]], doubled: usize, order: &[usize]) -> Option<Refinement> {
    let [.., coarse, middle, fine] = solutions[..doubled] else { return None };
    let largest = worst(fine.iter().map(|u| u.norm()));
    let (before, last) = (difference(coarse, middle), difference(middle, fine));
    let observed = (before / last).log2();
    let observed = (observed > 0.0 && observed.is_finite()).then_some(observed);
    // Without shrinking differences, no extrapolation is possible.
    let gain = observed.map_or(0.0, |p| 1.0 / (p.clamp(ORDERS[0], ORDERS[1]).exp2() - 1.0));
    let converged: Vec<Vector> = fine.iter().zip(middle).map(|(f, m)| f + (f - m) * gain).collect();
    let left = if observed.is_some() { SAFETY * gain * last } else { before.max(last) };
    Some(Refinement {
        errors: order.iter().map(|&i| difference(solutions[i], &converged) / largest).collect(),
        order: observed,
        left: left / largest,
    })
}

fn difference(a: &[Vector], b: &[Vector]) -> f64 {
    worst(a.iter().zip(b).map(|(a, b)| (a - b).norm()))
}

impl Convergence {
    /// Forces of the study, N.
    pub fn forces_n(&self) -> Vec<f64> {
        let Some(first) = self.loads.first() else { return Vec::new() };
        self.loads.iter().take_while(|load| load.node == first.node).map(|load| load.force_n).collect()
    }

    fn refinements(&self, force_n: f64) -> impl Iterator<Item = &Refinement> {
        self.loads.iter().filter(move |load| load.force_n == force_n).filter_map(|load| load.refinement.as_ref())
    }

    /// Largest relative error on a mesh over the loaded nodes under `force_n` (N); `None` if no such load has an equilibrium on every mesh.
    pub fn error(&self, mesh: usize, force_n: f64) -> Option<f64> {
        let errors: Vec<f64> = self.refinements(force_n).map(|refinement| refinement.errors[mesh]).collect();
        (!errors.is_empty()).then(|| worst(errors))
    }

    /// Largest relative estimated error of the finest mesh over the loaded nodes under `force_n` (N); `None` if no such load has an equilibrium on
    /// every mesh.
    pub fn left(&self, force_n: f64) -> Option<f64> {
        let left: Vec<f64> = self.refinements(force_n).map(|refinement| refinement.left).collect();
        (!left.is_empty()).then(|| worst(left))
    }

    /// Smallest and largest observed order over the loaded nodes under `force_n` (N); `None` if no load has an order.
    pub fn orders(&self, force_n: f64) -> Option<[f64; 2]> {
        let orders: Vec<f64> = self.refinements(force_n).filter_map(|refinement| refinement.order).collect();
        let smallest = orders.iter().copied().reduce(f64::min)?;
        Some([smallest, worst(orders)])
    }

    /// Number of nodes at which at least one mesh has no equilibrium under `force_n` (N).
    pub fn gaps(&self, force_n: f64) -> usize {
        self.loads.iter().filter(|load| load.force_n == force_n && load.refinement.is_none()).count()
    }

    /// Errors by load and mesh, as rows of the CSV file.
    pub fn rows(&self) -> impl Iterator<Item = ConvergenceRow> + '_ {
        self.loads.iter().flat_map(move |load| {
            self.meshes.iter().enumerate().map(move |(i, mesh)| ConvergenceRow {
                load_node: load.node,
                force_n: load.force_n,
                mesh_nodes: mesh.nodes,
                elements_a_member: mesh.elements_a_member,
                error: load.refinement.as_ref().map(|refinement| refinement.errors[i]),
                observed_order: load.refinement.as_ref().and_then(|refinement| refinement.order),
                left_on_finest_mesh: load.refinement.as_ref().map(|refinement| refinement.left),
            })
        })
    }

    /// Checks of the paper's finger at 3 N: every load has an equilibrium, and the errors on three meshes are small.
    pub fn checks(&self) -> Vec<Check> {
        let mesh = |wanted: fn(&MeshSize) -> bool| self.meshes.iter().position(wanted);
        let error = |mesh: Option<usize>| mesh.and_then(|i| self.error(i, CHECKED_FORCE_N)).unwrap_or(f64::NAN);
        let on = |name: &str, source: &str| {
            Kind::Internal.on(format!("{name}, co-rotational, {CHECKED_FORCE_N} N along the normal"), source)
        };
        let check = |name: &str, error: f64, tolerance: f64| {
            let quantity = "largest displacement difference / largest displacement";
            on(name, "Richardson extrapolation").vanishes(quantity, error, tolerance)
        };
        let finest = self.meshes.last().map_or(0, |mesh| mesh.nodes);
        let left = self.left(CHECKED_FORCE_N).unwrap_or(f64::NAN);
        vec![
            check("key nodes alone", error(mesh(|m| m.elements_a_member == Some(1))), KEY_NODES_TOLERANCE),
            check("two elements per member", error(mesh(|m| m.elements_a_member == Some(2))), TWO_ELEMENTS_TOLERANCE),
            check("684 nodes", error(mesh(|m| m.elements_a_member.is_none())), FINE_MESH_TOLERANCE),
            on(&format!("{finest} nodes"), "grid convergence index").vanishes(
                "estimated error / largest displacement",
                left,
                REFERENCE_TOLERANCE,
            ),
            on("all meshes", "the finger carries them").counts(
                "loads without equilibrium",
                0,
                self.gaps(CHECKED_FORCE_N),
            ),
        ]
    }
}
