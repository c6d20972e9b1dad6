//! Compares the finger as a lattice of rigid bodies and springs, settled by the physics engine rapier, with the finger as beams.
//!
//! The springs have the stiffnesses EA / l, 12 EI / l^3 and EI / l of the beams' own sections, and no parameter is fitted. The comparison
//! therefore verifies solver and co-rotational kinematics, not Euler-Bernoulli theory.

use super::ProblemError;
use crate::check::SETTLED_LATTICE;
use crate::lattice::accuracy::{LoadGrid, beam_shapes, lattice_shapes, settled_shapes, worst_by_force};
use crate::prelude::*;

/// Source of checks whose reference is the lattice solved by finray's Newton method, which finds the shapes of least energy without rapier.
pub const NEWTON: &str = "spring lattice, Newton";
/// Quantity of all checks.
const QUANTITY: &str = "largest displacement difference / largest displacement";
/// Number of segments per plate member.
pub const FINENESS: usize = 2;
/// Discretisation error of the lattice against beams, relative. The lattice's segments bend only at their middles. For small rotations the segments
/// deflect like beams, so the error vanishes with the load. The relative difference between lattice and beams is odd in the rotations, so it grows
/// with the force F as a F + b F^3. For two segments per plate member, a = 2.5e-4 / N and b = 2.4e-5 / N^3 describe the difference from 0.1 to 5 N,
/// within 5 %. Both coefficients, a and b, fall with the third to fourth power of the segments' length. The constants allow 25 % more.
const COARSENESS_PER_N: f64 = 3.1e-4;
const COARSENESS_PER_N3: f64 = 3e-5;
/// Error of settling, relative to the largest displacement. 32 solver sweeps per time step cause 6e-5 (measured by varying their number). The
/// criterion by which the bodies count as at rest causes 2e-5.
const SETTLING_TOLERANCE: f64 = 1e-4;
/// A tiny force, N. Co-rotational terms change displacements by a relative amount of at most 0.12 per newton (MuJoCo shows the same at 0.01 N).
const TINY_FORCE_N: f64 = 1e-4;
const TINY_FORCE_TOLERANCE: f64 = 0.13 * TINY_FORCE_N;

/// Checks on the paper's finger: lattice against converged beams and linear theory, settling against equilibrium, and bitwise reproducibility.
///
/// # Errors
/// [`ProblemError`] if a load has no equilibrium or the lattice does not settle.
pub fn checks(finger: &Finger) -> Result<Vec<Check>, ProblemError> {
    let lattice = Lattice::new(finger, FINENESS)?;
    let name = |what: &str| format!("{what}, {FINENESS} segments per plate member");
    let mut checks = Vec::new();

    let grid = LoadGrid::full(finger);
    let beams = beam_shapes(finger, &grid, Kinematics::Corotational)?;
    let errors = worst_by_force(&beams, &lattice_shapes(&lattice, &grid)?, grid.forces_n.len());
    for (force_n, error) in grid.forces_n.iter().zip(errors) {
        let problem = name(&format!(
            "equilibrium of the lattice against equilibrium of beams, {force_n} N, every node, -60 to 60 deg"
        ));
        checks.push(Check::new(Kind::Internal, problem, NEWTON, QUANTITY, 0.0, error, tolerance(*force_n)));
    }

    let tiny = LoadGrid { forces_n: vec![TINY_FORCE_N], ..grid };
    let linear = beam_shapes(finger, &tiny, Kinematics::Linear)?;
    let error = worst_by_force(&linear, &lattice_shapes(&lattice, &tiny)?, 1)[0];
    let problem = name(&format!("equilibrium of the lattice against linear beams, {TINY_FORCE_N} N"));
    checks.push(Check::new(Kind::Internal, problem, NEWTON, QUANTITY, 0.0, error, TINY_FORCE_TOLERANCE));

    let few = LoadGrid::few(finger);
    let (settled, ..) = settled_shapes(&lattice, &few)?;
    let equilibria = lattice_shapes(&lattice, &few)?;
    let error = worst(worst_by_force(&equilibria, &settled, few.forces_n.len()));
    let problem = name("settled lattice against the equilibrium of the same lattice, up to 5 N");
    checks.push(Check::new(Kind::External, problem, SETTLED_LATTICE, QUANTITY, 0.0, error, SETTLING_TOLERANCE));

    let beams = beam_shapes(finger, &few, Kinematics::Corotational)?;
    for (&force_n, error) in few.forces_n.iter().zip(worst_by_force(&beams, &settled, few.forces_n.len())) {
        let problem = name(&format!("settled lattice against beams, {force_n} N, some nodes and directions"));
        checks.push(Check::new(Kind::External, problem, SETTLED_LATTICE, QUANTITY, 0.0, error, tolerance(force_n)));
    }

    let (node, angle_deg) = few.directions()[0];
    let force_n = few.forces_n[0];
    let again = lattice.settle(&[Load::at_node(node, finger.direction(angle_deg) * force_n)])?.shape;
    let changed = bits(&settled[0][0]).zip(bits(&again)).filter(|(a, b)| a != b).count();
    let problem = name(&format!("lattice settled twice, {force_n} N at node {node}"));
    checks.push(Kind::Internal.on(problem, "itself").counts("nodes whose bits differ", 0, changed));
    Ok(checks)
}

fn tolerance(force_n: f64) -> f64 {
    COARSENESS_PER_N * force_n + COARSENESS_PER_N3 * force_n.powi(3)
}

fn bits(shape: &FingerShape) -> impl Iterator<Item = [u64; 3]> {
    shape.motions().iter().map(|m| [m.displacement.x, m.displacement.y, m.rotation].map(f64::to_bits))
}

/// Difference of linear theory from the lattice for each force; the difference is expected to grow with the force.
///
/// # Errors
/// [`ProblemError`] if a load has no equilibrium.
pub fn comparisons(finger: &Finger) -> Result<Vec<Comparison>, ProblemError> {
    let lattice = Lattice::new(finger, FINENESS)?;
    let grid = LoadGrid::full(finger);
    let linear = beam_shapes(finger, &grid, Kinematics::Linear)?;
    let errors = worst_by_force(&lattice_shapes(&lattice, &grid)?, &linear, grid.forces_n.len());
    let comparison = |(force_n, ours): (&f64, f64)| Comparison {
        problem: format!("linear beams against the lattice, {force_n} N, every node, -60 to 60 deg"),
        source: NEWTON.to_owned(),
        quantity: QUANTITY.to_owned(),
        reference: 0.0,
        ours,
    };
    Ok(grid.forces_n.iter().zip(errors).map(comparison).collect())
}
