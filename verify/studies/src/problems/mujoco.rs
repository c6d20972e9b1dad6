//! Fingers solved by MuJoCo 4.0.0 (discrete elastic rods between rigid rods), and a cylinder pushed into the paper's finger.
//!
//! MuJoCo shares neither discretisation (its rods bend only at vertices) nor code with the beams. MuJoCo's rods have the same EA and EI as the beams,
//! so both models converge to the same limit. The comparison verifies solver and kinematics, not the beam theory behind EA and EI.

use super::{ProblemError, ProblemResults};
use crate::check::difference;
use crate::exports::mujoco::{ContactStep, PAPER, PROGRAM, TouchedRod, contact_steps};
use crate::exports::{ExportedFinger, StaticCase};
use crate::prelude::*;
use crate::truths::{LATTICE_FINENESS, Truth};

/// Source of all checks.
const SOURCE: &str = "MuJoCo";
/// Quantity of most checks.
const DISPLACEMENT: &str = "largest displacement difference / largest displacement";
const ROTATION: &str = "largest rotation difference (rad)";

/// Tolerance of displacements under single forces, relative to the case's largest displacement. The case nearest to a limit load (tip, 5 N at -60
/// deg) differs by 1.6e-4; the export states an uncertainty of 2e-3 for this case.
pub const STATIC_TOLERANCE: f64 = 2e-4;
/// Tolerance of displacements in cases for which the export states an uncertainty up to `CERTAIN`. MuJoCo's extrapolated shapes and the shapes of the
/// beams differ by 1e-5 on a uniform finger. MuJoCo's shapes and the shapes of the beams differ by 3.1e-5 if a zone ends inside elements, because
/// such elements have an average stiffness.
pub const CERTAIN_TOLERANCE: f64 = 4e-5;
/// A case counts as certain up to this stated uncertainty, relative to the largest displacement. For a larger uncertainty, the export used a finer
/// mesh.
const CERTAIN: f64 = 2e-4;
/// Tolerance of rotations, rad: [`CERTAIN_TOLERANCE`] times displacements of about 20 mm, divided by 12 mm between two ribs.
pub const ROTATION_TOLERANCE_RAD: f64 = CERTAIN_TOLERANCE * 20.0 / 12.0;
/// Tolerance of a difference, as a multiple of the sum of both solvers' uncertainties; these uncertainties are estimates, not bounds. At 0.01 N,
/// rounding causes a difference of 1.7 times the sum of the uncertainties.
pub const UNCERTAINTIES: f64 = 2.0;
/// Smallest exported force, N, for which the error of linear theory is shown.
const LINEAR_FORCE_N: f64 = 0.01;
/// Tolerance of displacements under the exported contact forces, relative to the step's largest displacement. MuJoCo's shapes (extrapolated from 16
/// and 32 segments) and the shapes of the beams (32 elements per member) differ by 5e-6; the tolerance is twice this value.
pub const CONTACT_TOLERANCE: f64 = 1e-5;
/// Elements per member of the two meshes of beams from which shapes are extrapolated. The error falls with the square of the element length.
const ELEMENTS: [usize; 2] = [16, 32];

/// A case of the export, and the deviation of the beams' solution from it.
#[derive(Debug, Clone)]
pub struct CaseDeviation {
    /// The case.
    pub case: StaticCase,
    /// Largest difference of a key node's displacement, relative to the largest displacement.
    pub displacement: f64,
    /// Largest difference of a key node's rotation, rad.
    pub rotation_rad: f64,
    /// Largest difference of a displacement or rotation, divided by the sum of both solvers' uncertainties; dimensionless.
    pub uncertainties: f64,
}

/// Solves every case of an exported finger with converged beams.
pub(crate) fn deviations(exported: &ExportedFinger) -> Result<Vec<CaseDeviation>, ProblemError> {
    let (finger, cases) = (exported.finger()?, exported.cases()?);
    let meshes = ELEMENTS.map(|elements| Mesh::with_elements_per_member(&finger, elements));
    let directions: Vec<&[StaticCase]> =
        cases.chunk_by(|a, b| (a.node, a.angle_deg) == (b.node, b.angle_deg)).collect();
    let by_direction: Vec<Vec<CaseDeviation>> =
        directions.into_par_iter().map(|cases| direction_deviations(&meshes, cases)).collect::<Result<_, _>>()?;
    Ok(by_direction.concat())
}

fn direction_deviations(meshes: &[Mesh; 2], cases: &[StaticCase]) -> Result<Vec<CaseDeviation>, ProblemError> {
    let forces_n: Vec<f64> = cases.iter().map(|case| case.force_n).collect();
    let unit = Load::at_node(cases[0].node, cases[0].force / cases[0].force_n);
    let path = |mesh: &Mesh| -> Result<Vec<FingerShape>, ProblemError> {
        let load = mesh.frame_load(&unit).map_err(statics::StaticsError::from)?;
        let (equilibria, stopped) = Statics::ladder(mesh, Kinematics::Corotational).path(&[load], &forces_n);
        match stopped {
            Some(error) => Err(error.into()),
            None => Ok(equilibria.iter().map(|equilibrium| mesh.shape(&equilibrium.motion)).collect()),
        }
    };
    let (coarse, fine) = (path(&meshes[0])?, path(&meshes[1])?);
    let finger = meshes[0].finger();
    let shapes = coarse.iter().zip(&fine);
    Ok(cases.iter().zip(shapes).map(|(case, (coarse, fine))| deviation(finger, case, coarse, fine)).collect())
}

fn deviation(finger: &Finger, case: &StaticCase, coarse: &FingerShape, fine: &FingerShape) -> CaseDeviation {
    let ours = FingerShape::new(finger, false, |node| {
        let (c, f) = (coarse.motion(node), fine.motion(node));
        (f.displacement + (f.displacement - c.displacement) / 3.0, f.rotation + (f.rotation - c.rotation) / 3.0)
    });
    let (off_mm, off_rad) = apart(&ours, &case.shape);
    let (our_mm, our_rad) = apart(&ours, fine);
    let stated =
        (off_mm / (case.uncertainty_mm + our_mm)).max(off_rad / (case.uncertainty_rad.unwrap_or_default() + our_rad));
    CaseDeviation {
        case: case.clone(),
        displacement: off_mm / case.shape.largest_displacement_mm(),
        rotation_rad: off_rad,
        uncertainties: stated,
    }
}

/// Largest differences of displacements (mm) and rotations (rad).
fn apart(a: &FingerShape, b: &FingerShape) -> (f64, f64) {
    let pairs = || a.motions().iter().zip(b.motions());
    (
        worst(pairs().map(|(a, b)| (a.displacement - b.displacement).norm())),
        worst(pairs().map(|(a, b)| (a.rotation - b.rotation).abs())),
    )
}

pub(super) fn solve(finger: &Finger) -> Result<ProblemResults, ProblemError> {
    let Some(exported) = PROGRAM.export_of(&Scene::of_finger(finger.clone())) else { return Ok(Vec::new().into()) };
    let mut results =
        ProblemResults { checks: static_checks(exported)?, comparisons: vec![of_linear_theory(exported)?] };
    if is_papers_finger(finger) {
        results.checks.extend(contact_checks()?);
        results.comparisons.extend(triangle()?);
    }
    Ok(results)
}

/// Checks of one exported finger: all exported forces against converged beams.
///
/// # Errors
/// [`ProblemError`] if the export cannot be read or a case has no equilibrium.
pub fn static_checks(exported: &ExportedFinger) -> Result<Vec<Check>, ProblemError> {
    let deviations = deviations(exported)?;
    let over_all = |figure: fn(&CaseDeviation) -> f64| worst(deviations.iter().map(figure));
    let largest_n = worst(deviations.iter().map(|deviation| deviation.case.force_n));
    let problem = format!("finger {}, co-rotational, {} forces up to {largest_n} N", exported.name, deviations.len());
    let check =
        |quantity, ours, tolerance| Check::new(Kind::External, problem.clone(), SOURCE, quantity, 0.0, ours, tolerance);
    let is_certain = |d: &&CaseDeviation| d.case.uncertainty_mm <= CERTAIN * d.case.shape.largest_displacement_mm();
    let certain: Vec<f64> = deviations.iter().filter(is_certain).map(|d| d.displacement).collect();
    let problem_certain = format!("{problem}: {} of them known to {CERTAIN}", certain.len());
    let certain =
        Check::new(Kind::External, problem_certain, SOURCE, DISPLACEMENT, 0.0, worst(certain), CERTAIN_TOLERANCE);
    Ok(vec![
        certain,
        check(DISPLACEMENT, over_all(|d| d.displacement), STATIC_TOLERANCE),
        check(ROTATION, over_all(|d| d.rotation_rad), ROTATION_TOLERANCE_RAD),
        check("largest difference / uncertainties stated", over_all(|d| d.uncertainties), UNCERTAINTIES)
            .in_stated_uncertainties(),
    ])
}

/// Error of linear theory under the smallest exported force, without tolerance: it is an error of the theory, not of a solver.
fn of_linear_theory(exported: &ExportedFinger) -> Result<Comparison, ProblemError> {
    let mesh = Mesh::with_elements_per_member(&exported.finger()?, ELEMENTS[1]);
    let cases = exported.cases()?;
    let small: Vec<&StaticCase> = cases.iter().filter(|case| case.force_n <= LINEAR_FORCE_N).collect();
    let mut differences = Vec::new();
    for case in &small {
        let linear = statics::solve(&mesh, &[Load::at_node(case.node, case.force)], Kinematics::Linear)?;
        differences.push(difference(&case.shape, &linear));
    }
    let problem = format!("finger {}, linear, {} forces of {LINEAR_FORCE_N} N", exported.name, small.len());
    let (source, quantity) = (SOURCE.to_owned(), DISPLACEMENT.to_owned());
    Ok(Comparison { problem, source, quantity, reference: 0.0, ours: worst(differences) })
}

/// Compares MuJoCo's shape at one step of a push with beams on `mesh` under the exported contact forces. Returns the largest difference of a key
/// node's displacement, relative to the largest displacement.
pub(crate) fn contact_deviation(mesh: &Mesh, step: &ContactStep) -> Result<f64, ProblemError> {
    let load = |rod: &TouchedRod| Load::Node { node: rod.node, force: rod.force, moment_nmm: rod.moment_nmm };
    let loads: Vec<Load> = step.touched.iter().map(load).collect();
    let ours = statics::solve(mesh, &loads, Kinematics::Corotational)?;
    Ok(difference(&step.shape, &ours))
}

/// Checks on a cylinder pushed into the paper's finger: beams under MuJoCo's contact forces have MuJoCo's shape.
///
/// # Errors
/// [`ProblemError`] if the table cannot be read or a step has no equilibrium.
pub fn contact_checks() -> Result<Vec<Check>, ProblemError> {
    let mesh = Mesh::with_elements_per_member(&PAPER.finger()?, ELEMENTS[1]);
    let steps = contact_steps()?;
    let pushes: Vec<&[ContactStep]> = steps.chunk_by(|a, b| a.push == b.push).collect();
    let check = |steps: &[ContactStep]| {
        let of_steps: Vec<f64> =
            steps.par_iter().map(|step| contact_deviation(&mesh, step)).collect::<Result<_, _>>()?;
        let problem =
            format!("paper finger, push {} with a cylinder, contact forces of {} steps", steps[0].push, steps.len());
        Ok(Check::new(Kind::External, problem, SOURCE, DISPLACEMENT, 0.0, worst(of_steps), CONTACT_TOLERANCE))
    };
    pushes.into_iter().map(check).collect()
}

/// Pairwise differences of beams, lattice and MuJoCo under each force on the paper's finger, without tolerance.
///
/// # Errors
/// [`ProblemError`] if the table cannot be read.
pub fn triangle() -> Result<Vec<Comparison>, ProblemError> {
    let finger = PAPER.finger()?;
    let lattice = Lattice::new(&finger, LATTICE_FINENESS)?;
    let cases = PAPER.cases()?;
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS[1]);
    let mut forces_n: Vec<f64> = cases.iter().map(|case| case.force_n).collect();
    forces_n.sort_by(f64::total_cmp);
    forces_n.dedup();
    let mut comparisons = Vec::new();
    for force_n in forces_n {
        let of_force: Vec<&StaticCase> = cases.iter().filter(|case| case.force_n == force_n).collect();
        let sides = of_force.par_iter().map(|case| -> Result<[f64; 3], ProblemError> {
            let contact = Contact { angle_deg: case.angle_deg, ..Contact::at_node(case.node) };
            let beams = statics::solve(&mesh, &[Load::at_node(case.node, case.force)], Kinematics::Corotational)?;
            let springs = lattice.shapes(&contact, &[force_n]);
            let springs = springs.first().ok_or(ProblemError::Reference("the lattice has no equilibrium".into()))?;
            Ok([difference(&case.shape, &beams), difference(&case.shape, springs), difference(&beams, springs)])
        });
        let sides: Vec<[f64; 3]> = sides.collect::<Result<_, _>>()?;
        let pairs = [("beams", SOURCE), ("lattice", SOURCE), ("lattice", "beams")];
        comparisons.extend(pairs.iter().enumerate().map(|(side, (one, other))| Comparison {
            problem: format!("paper finger, {} forces of {force_n} N: {one} against {other}", of_force.len()),
            source: (*other).to_owned(),
            quantity: DISPLACEMENT.to_owned(),
            reference: 0.0,
            ours: worst(sides.iter().map(|sides| sides[side])),
        }));
    }
    Ok(comparisons)
}
