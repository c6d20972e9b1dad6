//! Reference problems: one short file for each, with source, reference values and tolerance.
//!
//! Every problem returns [`Check`]s or [`Comparison`]s, which report and tests use. A new problem needs a file and a line in [`ALL`].

pub mod elastic_line;
pub mod elastica;
pub mod energy_balance;
pub mod full_circle;
pub mod grid_convergence;
pub mod gripper_camera;
pub mod lee_frame;
pub mod linkage;
pub mod mujoco;
pub mod opensees;
pub mod refinement;
pub mod rigid_rotation;
pub mod tangent;
pub mod toggle;

use crate::exports;
use crate::prelude::*;

/// Every problem, in the report's order.
pub const ALL: &[Problem] = &[
    problem("elastica of a cantilever", |_| true, |_, _| Ok(elastica::checks()?.into())),
    problem("cantilever bent into a circle by an end moment", |_| true, |_, _| Ok(full_circle::checks()?.into())),
    problem("Lee frame", |_| true, |_, _| Ok(lee_frame::checks()?.into())),
    problem("toggle frame", |_| true, |_, _| Ok(toggle::checks()?.into())),
    problem(
        "meshes of the finger",
        |_| true,
        |finger, forces| {
            let comparisons = refinement::comparisons(finger, forces.drawn_n())?;
            Ok(ProblemResults { checks: refinement::checks(finger)?, comparisons })
        },
    ),
    problem("OpenSees on the paper's finger", is_papers_finger, |finger, _| {
        let comparisons = opensees::linear_against_corotational(finger)?;
        Ok(ProblemResults { checks: opensees::paper_checks(finger)?, comparisons })
    }),
    problem(
        "OpenSees on fingers with the same features",
        |_| true,
        |finger, _| Ok(opensees::feature_checks(finger)?.into()),
    ),
    problem("rigid rotation", is_papers_finger, |finger, _| Ok(rigid_rotation::checks(finger).into())),
    problem("derivatives of the energy", is_papers_finger, |finger, _| Ok(tangent::checks(finger)?.into())),
    problem("energy and work", is_papers_finger, |finger, _| Ok(energy_balance::checks(finger)?.into())),
    problem("order of convergence", is_papers_finger, |finger, _| Ok(grid_convergence::checks(finger)?.into())),
    problem(
        "MuJoCo's shapes",
        |finger| exports::mujoco::PROGRAM.export_of(&Scene::of_finger(finger.clone())).is_some(),
        |finger, _| mujoco::solve(finger),
    ),
    problem("linkage", is_papers_finger, |finger, _| Ok(linkage::checks(finger, &linkage::shipped()?).into())),
    problem("camera on the gripper", is_papers_finger, |finger, _| {
        Ok(gripper_camera::checks(finger, &linkage::shipped()?)?.into())
    }),
];

/// A problem with a known solution.
#[derive(Debug, Clone, Copy)]
pub struct Problem {
    /// Name of the problem.
    pub name: &'static str,
    /// Whether the problem has reference values for a finger.
    pub applies_to: fn(&Finger) -> bool,
    /// Solves the problem. Problems without fixed forces use the report's forces.
    pub solve: Solve,
}

type Solve = fn(&Finger, ReportForces) -> Result<ProblemResults, ProblemError>;

const fn problem(name: &'static str, applies_to: fn(&Finger) -> bool, solve: Solve) -> Problem {
    Problem { name, applies_to, solve }
}

/// Results of problems.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProblemResults {
    /// Checks of figures against references, with tolerances.
    pub checks: Vec<Check>,
    /// Figures that are expected to differ from their references.
    pub comparisons: Vec<Comparison>,
}

impl From<Vec<Check>> for ProblemResults {
    fn from(checks: Vec<Check>) -> ProblemResults {
        ProblemResults { checks, comparisons: Vec::new() }
    }
}

/// Solves, in parallel, the problems of [`ALL`] that apply to a finger.
pub(crate) fn solve_all(finger: &Finger, forces: ReportForces) -> Result<ProblemResults, ProblemError> {
    let applying = ALL.par_iter().with_max_len(1).filter(|problem| (problem.applies_to)(finger));
    let solved: Vec<ProblemResults> =
        applying.map(|problem| (problem.solve)(finger, forces)).collect::<Result<_, _>>()?;
    Ok(solved.into_iter().fold(ProblemResults::default(), |mut all, one| {
        all.checks.extend(one.checks);
        all.comparisons.extend(one.comparisons);
        all
    }))
}

/// Why a reference problem could not be solved.
#[derive(Debug, thiserror::Error)]
pub enum ProblemError {
    /// A shipped reference file is invalid.
    #[error("cannot use reference data: {0}")]
    Reference(String),
    /// The finger or frame of the problem has no equilibrium.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// The finger's lattice has no equilibrium.
    #[error(transparent)]
    Lattice(#[from] finray_lattice::LatticeError),
    /// A table exported from another program is invalid.
    #[error(transparent)]
    Export(#[from] exports::ExportError),
    /// The mesh of the problem cannot be built.
    #[error(transparent)]
    Mesh(#[from] finray_model::mesh::MeshSizeError),
}

impl From<csv::Error> for ProblemError {
    fn from(error: csv::Error) -> ProblemError {
        ProblemError::Reference(error.to_string())
    }
}
