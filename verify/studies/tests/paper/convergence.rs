//! Mesh refinement: co-rotational solutions on successively finer meshes against the converged solution.
//!
//! Every member is divided into 1, 2, 4, ... elements. The differences between the three finest solutions give the observed order p. Richardson
//! extrapolation of the two finest solutions gives the converged solution. Roache's grid convergence index bounds the error of the finest mesh.
//!
//! Source: Roache, Perspective: A Method for Uniform Reporting of Grid Refinement Studies, J. Fluids Eng. 116 (1994).

use super::{CheckRow, assert_all_pass, record_checks, same};
use finray_model::statics::Statics;
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector};
use finray_studies::check::{Check, Kind, worst};
use finray_studies::settings::ReportForces;
use finray_studies::truths::fine_mesh;
use finray_tests::{assert_recorded, is_full_study, paper};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Loaded nodes, one at a time.
const NODES: std::ops::RangeInclusive<usize> = 14..=24;
/// Elements per member of the finest mesh, of 4597 nodes.
const FINEST: usize = 128;
/// Factor of safety of the grid convergence index for three meshes (Roache 1994).
const SAFETY: f64 = 1.25;
/// Observed orders are limited to this range. An order outside this range results from rounding or chance.
const ORDERS: [f64; 2] = [0.5, 4.0];
/// Tolerances of the errors under 3 N on the meshes of key nodes, of two elements per member and of 684 nodes, relative to the largest displacement,
/// and of the estimated error of the finest mesh: a tenth of the smallest mesh tolerance.
const TOLERANCES: [(&str, f64); 3] =
    [("key nodes alone", 1e-2), ("two elements per member", 6e-3), ("684 nodes", 1e-5)];
const REFERENCE_TOLERANCE: f64 = 1e-6;

/// Worst figures over the loaded nodes on one mesh under one force.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    pub mesh_nodes: usize,
    pub elements_a_member: Option<usize>,
    pub force_n: f64,
    /// Largest difference of a displacement from the converged one, relative to the largest displacement.
    pub error: f64,
    pub least_order: f64,
    pub greatest_order: f64,
    /// Grid convergence index of the finest mesh.
    pub left_on_finest_mesh: f64,
}

fn difference(a: &[Vector], b: &[Vector]) -> f64 {
    worst(a.iter().zip(b).map(|(a, b)| (a - b).norm()))
}

/// Displacements of the key nodes (mm) under a force along the normal at a node, by force.
fn path(mesh: &Mesh, node: usize, forces_n: &[f64]) -> Vec<Vec<Vector>> {
    let finger = mesh.finger();
    let load = mesh.frame_load(&Load::at_node(NodeId(node), finger.direction(0.0))).expect("a free node");
    let (equilibria, lost) = Statics::ladder(mesh, Kinematics::Corotational).path(&[load], forces_n);
    assert!(lost.is_none(), "{lost:?}");
    equilibria.into_iter().map(|found| found.motion.displacements[..finger.key_node_count()].to_vec()).collect()
}

/// Errors of the solutions under one load, each mesh of the first `doubled` with twice the elements of the one before; the observed order, and the
/// grid convergence index.
fn refine(solutions: &[&Vec<Vector>], doubled: usize) -> (Vec<f64>, f64, f64) {
    let [.., coarse, middle, fine] = solutions[..doubled] else { unreachable!("three meshes") };
    let largest = worst(fine.iter().map(|u| u.norm()));
    let last = difference(middle, fine);
    let order = (difference(coarse, middle) / last).log2();
    assert!(order > 0.0, "the differences shrink");
    let gain = 1.0 / (order.clamp(ORDERS[0], ORDERS[1]).exp2() - 1.0);
    let converged: Vec<Vector> = fine.iter().zip(middle).map(|(f, m)| f + (f - m) * gain).collect();
    (solutions.iter().map(|u| difference(u, &converged) / largest).collect(), order, SAFETY * gain * last / largest)
}

fn rows(forces_n: &[f64]) -> Vec<Row> {
    let finger = paper();
    let doubled = (0..).map(|power| 1 << power).take_while(|n| *n <= FINEST);
    let mut meshes: Vec<_> = doubled.map(|n| (Some(n), Mesh::with_elements_per_member(&finger, n))).collect();
    let count = meshes.len();
    meshes.push((None, fine_mesh(&finger).expect("684 nodes")));
    let solve = |node| meshes.iter().map(|(_, mesh)| path(mesh, node, forces_n)).collect::<Vec<_>>();
    let solutions: Vec<Vec<Vec<Vec<Vector>>>> = NODES.into_par_iter().map(solve).collect();
    let mut rows = Vec::new();
    for (nth, &force_n) in forces_n.iter().enumerate() {
        let of_node =
            |by_mesh: &Vec<Vec<Vec<Vector>>>| refine(&by_mesh.iter().map(|path| &path[nth]).collect::<Vec<_>>(), count);
        let found: Vec<_> = solutions.iter().map(of_node).collect();
        let [least_order, greatest_order] = super::ends(found.iter().map(|of| of.1));
        rows.extend(meshes.iter().enumerate().map(|(i, (elements_a_member, mesh))| Row {
            mesh_nodes: mesh.node_count(),
            elements_a_member: *elements_a_member,
            force_n,
            error: worst(found.iter().map(|of| of.0[i])),
            least_order,
            greatest_order,
            left_on_finest_mesh: worst(found.iter().map(|of| of.2)),
        }));
    }
    rows
}

/// The tolerances of coarse meshes follow from their errors, so the report shows no verdict on them.
fn without_measured_tolerance(check: Check) -> CheckRow {
    let row = CheckRow::from(check);
    let is_coarse = ["key nodes alone", "two elements per member"].iter().any(|mesh| row.problem.starts_with(mesh));
    CheckRow { tolerance: row.tolerance.filter(|_| !is_coarse), ..row }
}

/// Finer meshes err less, and the errors under 3 N on three meshes are within their tolerances.
#[test]
fn finer_meshes_err_less() {
    let agree = |a: &Row, b: &Row| (a.mesh_nodes, a.force_n) == (b.mesh_nodes, b.force_n) && same(a.error, b.error);
    let [others @ .., largest_n] = ReportForces::PAPER.of_maps_n();
    let of = rows(&[largest_n]);
    let errors: Vec<f64> = of.iter().filter(|row| row.elements_a_member.is_some()).map(|row| row.error).collect();
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    let shapes = "largest displacement difference / largest displacement";
    let on = |name: &str| format!("{name}, co-rotational, {largest_n} N along the normal");
    let named = [&of[0], &of[1], &of[of.len() - 1]].into_iter().zip(TOLERANCES);
    let mut checks: Vec<Check> = named
        .map(|(row, (name, tolerance))| {
            Kind::Internal.on(on(name), "Richardson extrapolation").vanishes(shapes, row.error, tolerance)
        })
        .collect();
    let left = Kind::Internal.on(on("4597 nodes"), "grid convergence index");
    checks.push(left.vanishes(
        "estimated error / largest displacement",
        of[0].left_on_finest_mesh,
        REFERENCE_TOLERANCE,
    ));
    assert_all_pass(&checks);
    record_checks(
        &["Richardson extrapolation", "grid convergence index"],
        checks.into_iter().map(without_measured_tolerance).collect(),
    );
    assert_recorded("convergence.csv", |row: &Row| row.force_n == largest_n, of, agree);
    if is_full_study() {
        assert_recorded("convergence.csv", |row: &Row| row.force_n < largest_n, rows(&others), agree);
    }
}
