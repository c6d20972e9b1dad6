//! Fingers solved by OpenSees 3.7.1 (elasticBeamColumn; Linear and Corotational transformations).
//!
//! OpenSees shares the theory with the model (Euler-Bernoulli beams of the same EA and EI, co-rotation, strain of the chord), but no code. OpenSees
//! and the model must agree to the printed digits. The comparison verifies the solver, not the theory.

use super::ProblemError;
use crate::prelude::*;
use finray_model::finger::{Joints, RigidEnds};

/// Tolerance of linear displacements, relative to the case's largest displacement: OpenSees prints nine digits.
pub const LINEAR_TOLERANCE: f64 = 1e-8;
/// Tolerance of co-rotational displacements, relative to the case's largest displacement. OpenSees prints nine digits, and both Newton iterations
/// stop within 1e-9 of the solution.
pub const COROTATIONAL_TOLERANCE: f64 = 1e-8;

/// Tolerance of linear displacements of spring steel, relative to the case's largest displacement. On fine meshes, rounding errors grow with the fourth
/// power of the node count, and steel plates are thousands of times stiffer in tension than in bending.
const STEEL_LINEAR_TOLERANCE: f64 = 1e-7;

/// A finger that OpenSees solved: name, scene, table, and tolerance of its linear displacements.
#[derive(Debug, Clone, Copy)]
pub struct OpenSeesFinger {
    /// Name of the scene and table in `fixtures/opensees`.
    pub name: &'static str,
    /// Text of the scene.
    pub scene: &'static str,
    /// The table.
    pub csv: &'static str,
    /// Tolerance of linear displacements, relative to the case's largest displacement.
    pub linear_tolerance: f64,
}

macro_rules! fingers {
    ($($name:literal: $scene:ident, $csv:ident, $linear_tolerance:expr;)+) => {
        /// The fingers that OpenSees solved apart from the paper's finger. Together they use every key of the beam model except tapers.
        pub const FINGERS: &[OpenSeesFinger] = &[$(OpenSeesFinger {
            name: $name,
            scene: finray_fixtures::$scene,
            csv: finray_fixtures::$csv,
            linear_tolerance: $linear_tolerance,
        }),+];
    };
}

fingers! {
    "asymmetric": ASYMMETRIC_SCENE, OPENSEES_ASYMMETRIC, LINEAR_TOLERANCE;
    "hinged": HINGED_SCENE, OPENSEES_HINGED, LINEAR_TOLERANCE;
    "rigid-ribs": RIGID_RIBS_SCENE, OPENSEES_RIGID_RIBS, LINEAR_TOLERANCE;
    "hinged-rigid": HINGED_RIGID_SCENE, OPENSEES_HINGED_RIGID, STEEL_LINEAR_TOLERANCE;
    "brackets": BRACKETS_SCENE, OPENSEES_BRACKETS, LINEAR_TOLERANCE;
    "brackets-joined": BRACKETS_JOINED_SCENE, OPENSEES_BRACKETS_JOINED, LINEAR_TOLERANCE;
    "brackets-rigid": BRACKETS_RIGID_SCENE, OPENSEES_BRACKETS_RIGID, STEEL_LINEAR_TOLERANCE;
    "clips": CLIPS_SCENE, OPENSEES_CLIPS, STEEL_LINEAR_TOLERANCE;
    "arms": ARMS_SCENE, OPENSEES_ARMS, LINEAR_TOLERANCE;
    "all-keys": ALL_KEYS_SCENE, OPENSEES_ALL_KEYS, LINEAR_TOLERANCE;
}

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

/// Checks on the paper's finger with the paper's two meshes: two checks per kinematics and mesh, over all cases.
pub(crate) fn paper_checks(paper: &Finger) -> Result<Vec<Check>, ProblemError> {
    let deviations = deviations(paper, finray_fixtures::OPENSEES_PAPER)?;
    let mut groups: Vec<(Kinematics, usize)> = deviations.iter().map(|d| (d.kinematics, d.mesh_nodes)).collect();
    groups.dedup();
    let of_group = |(kinematics, mesh_nodes)| {
        let group = deviations.iter().filter(|d| d.kinematics == kinematics && d.mesh_nodes == mesh_nodes);
        checks_of(
            "paper finger",
            &format!("{mesh_nodes} nodes"),
            kinematics,
            LINEAR_TOLERANCE,
            &group.collect::<Vec<_>>(),
        )
    };
    Ok(groups.into_iter().flat_map(of_group).collect())
}

/// Checks on the further fingers whose beams have features of `finger`, or on all of them for the paper's finger: two checks per finger and kinematics.
pub(crate) fn feature_checks(finger: &Finger) -> Result<Vec<Check>, ProblemError> {
    let mut checks = Vec::new();
    for OpenSeesFinger { name, scene, csv, linear_tolerance } in FINGERS {
        let solved = Scene::from_toml(scene).map_err(|error| ProblemError::Reference(error.to_string()))?.finger;
        let is_shared = |feature: &Feature| (feature.is_in)(finger) && (feature.is_in)(&solved);
        if !is_papers_finger(finger) && !FEATURES.iter().any(is_shared) {
            continue;
        }
        let deviations = deviations(&solved, csv)?;
        for kinematics in [Kinematics::Linear, Kinematics::CorotationalChord] {
            let group: Vec<_> = deviations.iter().filter(|d| d.kinematics == kinematics).collect();
            checks.extend(checks_of(&format!("finger {name}"), "two meshes", kinematics, *linear_tolerance, &group));
        }
    }
    Ok(checks)
}

fn checks_of(
    finger: &str,
    meshes: &str,
    kinematics: Kinematics,
    linear_tolerance: f64,
    group: &[&CaseDeviation],
) -> [Check; 2] {
    let (name, tolerance) = match kinematics {
        Kinematics::Linear => ("linear", linear_tolerance),
        _ => ("co-rotational (chord strain)", COROTATIONAL_TOLERANCE),
    };
    let subject = Kind::External.on(format!("{finger}, {name}, {meshes}, {} load cases", group.len()), "OpenSees");
    let over_all = |figure: fn(&CaseDeviation) -> f64| worst(group.iter().map(|deviation| figure(deviation)));
    [
        ("largest displacement difference / largest displacement", over_all(|d| d.displacement)),
        ("largest rotation difference (rad)", over_all(|d| d.rotation_rad)),
    ]
    .map(|(quantity, ours)| subject.vanishes(quantity, ours, tolerance))
}

/// A feature of the beam model that a finger may have: the keys that state it.
pub struct Feature {
    keys: &'static str,
    is_in: fn(&Finger) -> bool,
}

/// Features that distinguish fingers from the paper's uniform finger.
const FEATURES: &[Feature] = &[
    Feature {
        keys: "unequal plates",
        is_in: |f| {
            let d = f.description();
            d.front != d.back || d.front_length_mm != d.back_length_mm
        },
    },
    Feature { keys: "poissons_ratio", is_in: |f| f.description().poissons_ratio != 0.0 },
    Feature { keys: "rod_arm_mm", is_in: |f| f.description().rod_arm_mm != 0.0 },
    Feature { keys: "rib_arm_mm", is_in: |f| f.description().rib_arm_mm.is_some() },
    Feature { keys: "clamp_arm_mm", is_in: |f| f.description().clamp_arm_mm.is_some() },
    Feature { keys: "shear_correction", is_in: |f| f.description().shear_correction != 0.0 },
    Feature { keys: "tip_thickness_mm", is_in: |f| f.tapers(Plate::Front) || f.tapers(Plate::Back) },
    Feature {
        keys: "rigid_base_mm, rigid_tip_mm",
        is_in: |f| f.description().rigid_ends.iter().any(|ends| *ends != RigidEnds::default()),
    },
    Feature { keys: "hinged ribs", is_in: |f| f.description().ribs.joints == Joints::Hinged },
    Feature { keys: "undeformable ribs", is_in: |f| f.rib_count() > 0 && f.description().ribs.strip.is_none() },
    Feature { keys: "ribs of several thicknesses", is_in: |f| f.description().ribs.thicknesses_mm.is_some() },
    Feature { keys: "bracket_mm", is_in: |f| f.has_brackets() },
    Feature { keys: "clip_mm", is_in: |f| f.description().ribs.clip_mm != [0.0; 2] },
    Feature { keys: "zones", is_in: |f| !f.description().zones.is_empty() },
    Feature { keys: "shared junctions", is_in: |f| f.has_shared_junctions() },
];

/// Features of a finger that OpenSees verifies on other fingers, and features that no other program verifies.
pub fn verified_features(finger: &Finger) -> [Vec<&'static str>; 2] {
    let solved: Vec<Finger> = FINGERS.iter().filter_map(|it| Some(Scene::from_toml(it.scene).ok()?.finger)).collect();
    let present = FEATURES.iter().filter(|feature| (feature.is_in)(finger));
    let (verified, not): (Vec<&Feature>, Vec<&Feature>) = present.partition(|feature| solved.iter().any(feature.is_in));
    [verified, not].map(|features| features.into_iter().map(|feature| feature.keys).collect())
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
