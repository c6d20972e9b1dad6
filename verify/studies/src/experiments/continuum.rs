//! What beam theory neglects: beams against the same finger as a plane continuum of CalculiX.
//!
//! Beams lack the rods' extent, plane strain and shear. The deviation is one of the theory, not of a solver: no tolerance applies.

use crate::check::worst;
use crate::exports::{ExportedFinger, StaticCase};
use crate::prelude::*;
use crate::problems::ProblemError;
use finray_model::finger::FingerDescription;

/// Largest force of the comparison, N: the largest of the paper's gripper tests. CalculiX's shapes exist up to 5 N.
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
    /// Displacements of the beams as a multiple of those of the continuum, by least squares over all key nodes.
    pub scale: f64,
}

/// Properties of the continuum that a beam model has. Each variant includes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Constants {
    /// Young's modulus alone.
    Modulus,
    /// Poisson's ratio too: E / (1 - nu^2).
    PlaneStrain,
    /// Rigid arms at the key nodes too.
    Arms,
}

impl Constants {
    /// All variants, from fewest to most properties.
    pub const ALL: [Constants; 3] = [Constants::Modulus, Constants::PlaneStrain, Constants::Arms];

    /// The beam model with these properties of `finger`, which has all of them.
    ///
    /// # Errors
    /// [`ProblemError`] if this is no valid finger.
    pub fn of(self, finger: &Finger) -> Result<Finger, ProblemError> {
        let all = finger.description().clone();
        let description = match self {
            Constants::Modulus => FingerDescription { poissons_ratio: 0.0, rod_arm_mm: 0.0, ..all },
            Constants::PlaneStrain => FingerDescription { rod_arm_mm: 0.0, ..all },
            Constants::Arms => all,
        };
        Finger::new(description).map_err(|error| ProblemError::Reference(error.to_string()))
    }
}

/// Deviations of co-rotational beams on `mesh` from the exported shapes, for all forces up to [`LARGEST_FORCE_N`] that do not act on the tip. Forces
/// that the beams cannot carry are left out.
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
