//! Fingers solved by OpenSees 3.7.1 (elasticBeamColumn; Linear and Corotational transformations).
//!
//! OpenSees shares the theory with the model (Euler-Bernoulli beams of the same EA and EI, co-rotation, strain of the chord), but no code. OpenSees
//! and the model must agree to the printed digits. The comparison verifies the solver, not the theory.

use super::ProblemError;
use crate::prelude::*;

/// Tolerance of linear displacements, relative to the case's largest displacement: OpenSees prints nine digits.
pub const LINEAR_TOLERANCE: f64 = 1e-8;
/// Tolerance of co-rotational displacements, relative to the case's largest displacement. OpenSees prints nine digits, and both Newton iterations
/// stop within 1e-9 of the solution.
pub const COROTATIONAL_TOLERANCE: f64 = 1e-8;

/// One row of a reference file: a key node in a load case.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Row {
    case: usize,
    kinematics: String,
    mesh_nodes: usize,
    load: usize,
    fx_n: f64,
    fy_n: f64,
    #[serde(default)]
    m_nmm: f64,
    node: usize,
    ux_mm: f64,
    uy_mm: f64,
    theta_rad: f64,
    /// Displacement of a rib's joint, mm, for fingers whose brackets hold the ribs off the plates.
    hinge_ux_mm: Option<f64>,
    hinge_uy_mm: Option<f64>,
}

impl Row {
    fn displacement(&self) -> Vector {
        Vector::new(self.ux_mm, self.uy_mm)
    }

    fn hinge_displacement(&self) -> Option<Vector> {
        Some(Vector::new(self.hinge_ux_mm?, self.hinge_uy_mm?))
    }
}

/// A load case of the reference file, and the deviation of the model's solution from it.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseDeviation {
    /// Number of the case in the reference file.
    pub case: usize,
    /// Kinematics of the case.
    pub kinematics: Kinematics,
    /// Number of nodes of the mesh.
    pub mesh_nodes: usize,
    /// Largest difference of the displacement of a key node or joint, relative to the largest displacement.
    pub displacement: f64,
    /// Largest difference of a key node's rotation, rad.
    pub rotation_rad: f64,
}

/// Solves every case of a reference file with the model.
///
/// # Errors
/// [`ProblemError`] if the file is not a valid table from OpenSees or a case cannot be solved.
pub fn deviations(finger: &Finger, reference_csv: &str) -> Result<Vec<CaseDeviation>, ProblemError> {
    let rows: Vec<Row> = csv::Reader::from_reader(reference_csv.as_bytes()).deserialize().collect::<Result<_, _>>()?;
    rows.chunk_by(|a, b| a.case == b.case).map(|case| deviation(finger, case)).collect()
}

fn deviation(finger: &Finger, rows: &[Row]) -> Result<CaseDeviation, ProblemError> {
    let first = &rows[0];
    let kinematics = match first.kinematics.as_str() {
        "linear" => Kinematics::Linear,
        "corotational" => Kinematics::CorotationalChord,
        other => return Err(ProblemError::Reference(format!("unknown kinematics {other}"))),
    };
    let mesh = Mesh::with_nodes(finger, first.mesh_nodes)?;
    let force = Vector::new(first.fx_n, first.fy_n);
    let load = Load::Node { node: NodeId(first.load), force, moment_nmm: first.m_nmm };
    let shape = statics::solve(&mesh, &[load], kinematics)?;
    let ours = |row: &Row| shape.motion(NodeId(row.node));
    let largest = worst(rows.iter().map(|row| row.displacement().norm()));
    let of_node = |row: &Row| (ours(row).displacement - row.displacement()).norm();
    let of_joint = |row: &Row| row.hinge_displacement().map(|theirs| (ours(row).hinge_displacement - theirs).norm());
    let displacement = worst(rows.iter().map(of_node).chain(rows.iter().filter_map(of_joint)));
    let rotation_rad = worst(rows.iter().map(|row| (ours(row).rotation - row.theta_rad).abs()));
    Ok(CaseDeviation {
        case: first.case,
        kinematics,
        mesh_nodes: first.mesh_nodes,
        displacement: displacement / largest,
        rotation_rad,
    })
}

/// Checks on the paper's finger with the paper's two meshes: one check per kinematics and mesh, over all cases.
pub(crate) fn paper_checks(paper: &Finger) -> Result<Vec<Check>, ProblemError> {
    let deviations = deviations(paper, finray_fixtures::OPENSEES_PAPER)?;
    let mut groups: Vec<(Kinematics, usize)> = deviations.iter().map(|d| (d.kinematics, d.mesh_nodes)).collect();
    groups.dedup();
    Ok(groups
        .into_iter()
        .flat_map(|(kinematics, mesh_nodes)| {
            let group = deviations.iter().filter(|d| d.kinematics == kinematics && d.mesh_nodes == mesh_nodes);
            let (name, tolerance) = match kinematics {
                Kinematics::Linear => ("linear", LINEAR_TOLERANCE),
                _ => ("co-rotational (chord strain)", COROTATIONAL_TOLERANCE),
            };
            let problem = format!("paper finger, {name}, {mesh_nodes} nodes, {} load cases", group.clone().count());
            let over_all = |figure: fn(&CaseDeviation) -> f64| worst(group.clone().map(figure));
            [
                ("largest displacement difference / largest displacement", over_all(|d| d.displacement)),
                ("largest rotation difference (rad)", over_all(|d| d.rotation_rad)),
            ]
            .map(|(quantity, ours)| {
                Check::new(Kind::External, problem.clone(), "OpenSees", quantity, 0.0, ours, tolerance)
            })
        })
        .collect())
}

/// Difference of the linear finger from the co-rotational finger by case, without tolerance. This difference explains errors of linear sensing.
pub(crate) fn linear_against_corotational(paper: &Finger) -> Result<Vec<Comparison>, ProblemError> {
    let rows: Vec<Row> =
        csv::Reader::from_reader(finray_fixtures::OPENSEES_PAPER.as_bytes()).deserialize().collect::<Result<_, _>>()?;
    let mesh = Mesh::key_nodes(paper);
    let mut comparisons = Vec::new();
    for case in rows.chunk_by(|a, b| a.case == b.case).filter(|case| case[0].kinematics == "corotational") {
        let force = Vector::new(case[0].fx_n, case[0].fy_n);
        let node = NodeId(case[0].load);
        let linear = statics::solve(&mesh, &[Load::at_node(node, force)], Kinematics::Linear)?;
        let Some(loaded) = case.iter().find(|row| row.node == node.0) else { continue };
        comparisons.push(Comparison {
            problem: format!("paper finger, {:.2} N at node {node}: linear against co-rotational", force.norm()),
            source: "OpenSees".to_owned(),
            quantity: "displacement of the loaded node (mm)".to_owned(),
            reference: Vector::new(loaded.ux_mm, loaded.uy_mm).norm(),
            ours: linear.motion(node).displacement.norm(),
        });
    }
    Ok(comparisons)
}
