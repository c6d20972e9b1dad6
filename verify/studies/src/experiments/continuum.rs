//! Errors of beam theory: beams compared with the same finger as a plane continuum, solved by CalculiX.
//!
//! Slender beams neglect the extent of the rods, plane strain and shear. The deviation is an error of the theory, not of a solver, so no tolerance
//! applies.

use super::{Context, Evidence, ExperimentError};
use crate::check::worst;
use crate::exports::calculix::{self, PAPER, PAPER_PLAIN};
use crate::exports::{ExportedFinger, StaticCase};
use crate::prelude::*;
use crate::problems::ProblemError;
use crate::statistics::median;
use crate::truths::fine_mesh;
use finray_model::finger::FingerDescription;

/// Largest force of the comparison, N: the largest force in the paper's gripper tests. Shapes computed by CalculiX are available up to 5 N.
pub const LARGEST_FORCE_N: f64 = 3.0;

/// Deviation of beams from the continuum under one force.
#[derive(Debug, Clone)]
pub struct Deviation {
    /// The force, and the shape of the continuum.
    pub case: StaticCase,
    /// Largest difference of a key node's displacement, relative to the largest displacement of the continuum.
    pub displacement: f64,
    /// Key node with the largest difference.
    pub at: NodeId,
    /// Ratio of the beams' displacements to the continuum's displacements, by least squares over all key nodes.
    pub scale: f64,
}

/// Properties that a beam model shares with the continuum. Each variant includes the properties of all earlier variants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Constants {
    /// Only Young's modulus.
    Modulus,
    /// Also Poisson's ratio: the modulus of the beams is E / (1 - nu^2).
    PlaneStrain,
    /// Also rigid arms at the key nodes, and shear deformation.
    ArmsAndShear,
}

impl Constants {
    /// All variants, from fewest to most properties.
    pub const ALL: [Constants; 3] = [Constants::Modulus, Constants::PlaneStrain, Constants::ArmsAndShear];

    /// The beam model in words.
    pub fn in_words(self) -> &'static str {
        match self {
            Constants::Modulus => "beams with E",
            Constants::PlaneStrain => "beams with E / (1 - nu^2)",
            Constants::ArmsAndShear => "beams with E / (1 - nu^2), rod arms and shear",
        }
    }

    /// The beam model with only these properties of `finger`, which itself has all properties.
    ///
    /// # Errors
    /// [`ProblemError`] if the result is no valid finger.
    pub fn of(self, finger: &Finger) -> Result<Finger, ProblemError> {
        let all = finger.description().clone();
        let description = match self {
            Constants::Modulus => FingerDescription {
                poissons_ratio: 0.0,
                side_faces: None,
                rod_arm_mm: 0.0,
                rib_arm_mm: None,
                clamp_arm_mm: None,
                fillets: None,
                shear_correction: 0.0,
                ..all
            },
            Constants::PlaneStrain => FingerDescription {
                side_faces: None,
                rod_arm_mm: 0.0,
                rib_arm_mm: None,
                clamp_arm_mm: None,
                fillets: None,
                shear_correction: 0.0,
                ..all
            },
            Constants::ArmsAndShear => all,
        };
        Finger::new(description).map_err(|error| ProblemError::Reference(error.to_string()))
    }
}

/// Deviations of one beam model from the continuum over all forces up to [`LARGEST_FORCE_N`] that do not act on the tip.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BeamTheoryRow {
    /// Name of the continuum's exported table.
    pub continuum: &'static str,
    /// Properties that the beams share with the continuum.
    pub constants: Constants,
    /// Number of forces.
    pub cases: usize,
    /// Median over the forces of the largest difference of a displacement, relative to the largest displacement.
    pub median: f64,
    /// Largest difference of a displacement over all forces, relative to the largest displacement.
    pub worst: f64,
    /// Loaded node of the case with the largest difference.
    pub load: usize,
    /// Key node with the largest difference.
    pub node: usize,
    /// Median over the forces of the ratio of the beams' displacements to the continuum's displacements.
    pub scale: f64,
}

/// Results on the continuum of a scene's finger.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ContinuumStudy {
    /// Deviations of beams from the continuum, one row for each set of beam properties ([`Constants`]). For the paper's finger, rows with deviations
    /// from the continuum without rods follow. Empty if CalculiX did not solve the finger.
    pub rows: Vec<BeamTheoryRow>,
}

impl ContinuumStudy {
    /// Deviations of beams with these constants from the continuum of the scene's finger; for the paper's finger, from the continuum with rods.
    pub fn of(&self, constants: Constants) -> Option<&BeamTheoryRow> {
        self.rows.iter().find(|row| row.constants == constants)
    }

    /// Deviations of beams with these constants from the paper's continuum without rods.
    pub fn without_rods(&self, constants: Constants) -> Option<&BeamTheoryRow> {
        self.rows.iter().rfind(|row| row.constants == constants)
    }
}

impl Evidence for ContinuumStudy {
    fn comparisons(&self) -> Vec<Comparison> {
        let of_row = |row: &BeamTheoryRow| {
            let figures = [("median of largest", row.median), ("largest", row.worst)];
            figures.map(|(statistic, ours)| Comparison {
                problem: format!(
                    "continuum {}, {} forces up to {LARGEST_FORCE_N} N: {}",
                    row.continuum,
                    row.cases,
                    row.constants.in_words()
                ),
                source: calculix::PROGRAM.name.to_owned(),
                quantity: format!("{statistic} displacement difference / largest displacement"),
                reference: 0.0,
                ours,
            })
        };
        self.rows.iter().flat_map(of_row).collect()
    }
}

/// Compares beams with the continuum of a scene's finger.
pub(crate) fn run(context: &Context) -> Result<ContinuumStudy, ExperimentError> {
    // The paper states neither Poisson's ratio nor arms of its finger; the continua with and without rods assume them.
    let exports: Vec<&ExportedFinger> = match context.is_paper {
        true => vec![&PAPER, &PAPER_PLAIN],
        false => calculix::PROGRAM.export_of(&context.given.scene).into_iter().collect(),
    };
    context.progress.part("continuum", exports.len());
    let mut rows = Vec::new();
    for export in exports {
        let finger = export.finger().map_err(ProblemError::from)?;
        for constants in Constants::ALL {
            let mesh = fine_mesh(&constants.of(&finger)?)?;
            rows.extend(row(export.name, constants, &deviations(export, &mesh)?));
        }
        context.progress.step();
    }
    Ok(ContinuumStudy { rows })
}

fn row(continuum: &'static str, constants: Constants, deviations: &[Deviation]) -> Option<BeamTheoryRow> {
    let worst = deviations.iter().max_by(|a, b| a.displacement.total_cmp(&b.displacement))?;
    Some(BeamTheoryRow {
        continuum,
        constants,
        cases: deviations.len(),
        median: median(deviations.iter().map(|deviation| deviation.displacement))?,
        worst: worst.displacement,
        load: worst.case.node.0,
        node: worst.at.0,
        scale: median(deviations.iter().map(|deviation| deviation.scale))?,
    })
}

/// Deviations of co-rotational beams on `mesh` from the exported shapes, for all forces up to [`LARGEST_FORCE_N`] that do not act on the tip. Forces
/// that the beams cannot carry are omitted.
///
/// # Errors
/// [`ProblemError`] if the export cannot be read.
pub fn deviations(exported: &ExportedFinger, mesh: &Mesh) -> Result<Vec<Deviation>, ProblemError> {
    let (finger, mut cases) = (mesh.finger(), exported.cases()?);
    cases.retain(|case| case.force_n <= LARGEST_FORCE_N && case.node != finger.tip());
    let directions: Vec<&[StaticCase]> =
        cases.chunk_by(|a, b| (a.node, a.angle_deg) == (b.node, b.angle_deg)).collect();
    let under = |cases: &&[StaticCase]| -> Result<Vec<Deviation>, ProblemError> {
        let forces_n: Vec<f64> = cases.iter().map(|case| case.force_n).collect();
        let unit = Load::at_node(cases[0].node, cases[0].force / cases[0].force_n);
        let load = mesh.frame_load(&unit).map_err(StaticsError::from)?;
        let (equilibria, _) = Statics::ladder(mesh, Kinematics::Corotational).path(&[load], &forces_n);
        let shapes = equilibria.iter().map(|equilibrium| mesh.shape(&equilibrium.motion));
        Ok(cases.iter().zip(shapes).map(|(case, shape)| deviation(case, &shape)).collect())
    };
    let by_direction: Vec<Vec<Deviation>> = directions.par_iter().map(under).collect::<Result<_, _>>()?;
    Ok(by_direction.concat())
}

fn deviation(case: &StaticCase, beams: &FingerShape) -> Deviation {
    let pairs = || case.shape.motions().iter().zip(beams.motions()).map(|(a, b)| (a.displacement, b.displacement));
    let differences: Vec<f64> = pairs().map(|(continuum, beams)| (beams - continuum).norm()).collect();
    let at = differences.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(at, _)| at);
    let common: f64 = pairs().map(|(continuum, beams)| continuum.dot(&beams)).sum();
    let squares: f64 = pairs().map(|(continuum, _)| continuum.norm_squared()).sum();
    Deviation {
        case: case.clone(),
        displacement: worst(differences) / case.shape.largest_displacement_mm(),
        at: NodeId(at + 1),
        scale: common / squares,
    }
}
