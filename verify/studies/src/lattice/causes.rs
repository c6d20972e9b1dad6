//! Causes of the lattice's error against beams: lattice and beams are compared with one property changed at a time.

use super::accuracy::{AccuracyError, LoadGrid, beam_shapes, difference, lattice_shapes, load, worst_by_force};
use crate::prelude::*;
use finray_lattice::energy::{BodyMotion, Energy};
use finray_lattice::settling::{Precision, SWEEPS, Settling};
use finray_lattice::springs::AxialSprings;

/// Stiffness factor at which axial springs count as rigid. A factor 100 times as large changes displacements of the paper's finger by 1e-3, relative.
pub const AS_GOOD_AS_RIGID: f64 = 1e3;

/// Axial springs to compare, with their names. The first entry has the axial springs that are equivalent to a beam.
pub const AXIAL_SPRINGS: [(&str, AxialSprings); 4] = [
    ("as a beam's", AxialSprings::OF_A_BEAM),
    ("fixed at the segments' ends", AxialSprings { inset: 0.0, ..AxialSprings::OF_A_BEAM }),
    ("a thousand times as stiff", AxialSprings { stiffness: AS_GOOD_AS_RIGID, ..AxialSprings::OF_A_BEAM }),
    ("left out", AxialSprings { stiffness: 0.0, ..AxialSprings::OF_A_BEAM }),
];

/// Error of the lattice with one setting of its axial springs.
#[derive(Debug, Clone, PartialEq)]
pub struct AxialRow {
    /// Setting of the springs, in words.
    pub name: &'static str,
    /// The axial springs.
    pub axial: AxialSprings,
    /// Largest difference from converged beams per force, relative to the largest displacement; `None` if a load has no equilibrium.
    pub errors: Option<Vec<f64>>,
}

/// Compares the lattice with each of [`AXIAL_SPRINGS`] against converged beams over a grid of loads.
///
/// # Errors
/// [`AccuracyError`] if the beams have no equilibrium or no lattice can be built.
pub fn axial(finger: &Finger, fineness: usize, grid: &LoadGrid) -> Result<Vec<AxialRow>, AccuracyError> {
    let beams = beam_shapes(finger, grid, Kinematics::Corotational)?;
    let row = |&(name, axial): &(&'static str, AxialSprings)| -> Result<AxialRow, AccuracyError> {
        let lattice = Lattice::with_axial_springs(finger, fineness, axial)?;
        let errors = match lattice_shapes(&lattice, grid) {
            Ok(shapes) => Some(worst_by_force(&beams, &shapes, grid.forces_n.len())),
            Err(LatticeError::NoEquilibrium { .. }) => None,
            Err(error) => return Err(error.into()),
        };
        Ok(AxialRow { name, axial, errors })
    };
    AXIAL_SPRINGS.par_iter().map(row).collect()
}

/// Settings of settling to compare: sweeps over the springs per step, and precision of the positions. The default number of sweeps is `SWEEPS`.
pub const SETTLINGS: [(usize, Precision); 5] = [
    (8, Precision::Double),
    (16, Precision::Double),
    (SWEEPS, Precision::Double),
    (2 * SWEEPS, Precision::Double),
    (SWEEPS, Precision::Single),
];
/// A lattice counts as not settled after this number of steps, several times the number that the paper's finger needs.
const MOST_STEPS: usize = 20_000;

/// Error of settling with one setting, against the lattice's equilibrium by Newton's method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SettlingRow {
    /// Sweeps over the springs in one step.
    pub sweeps: usize,
    /// Floating-point precision of the positions.
    pub positions: Precision,
    /// Largest difference from the equilibria, relative to the largest displacement; `None` if the lattice does not settle under a load.
    pub error: Option<f64>,
    /// Largest number of steps to rest; `None` if the lattice does not settle under a load.
    pub steps: Option<usize>,
}

/// Settles a lattice (simulates it until rest) with each of [`SETTLINGS`] under all loads of a grid.
///
/// # Errors
/// [`LatticeError`] if a load has no equilibrium or settling fails for another reason than too many steps.
pub fn settling(lattice: &Lattice, grid: &LoadGrid) -> Result<Vec<SettlingRow>, LatticeError> {
    let shapes = lattice_shapes(lattice, grid)?;
    let directions = grid.directions();
    let of_direction = |(at, column): (&(NodeId, f64), &Vec<FingerShape>)| {
        let loads = grid.forces_n.iter().map(|&force_n| load(lattice.finger(), at, force_n));
        loads.zip(column.clone()).collect::<Vec<_>>()
    };
    let cases: Vec<(Load, FingerShape)> = directions.iter().zip(&shapes).flat_map(of_direction).collect();
    let row = |&(sweeps, positions): &(usize, Precision)| -> Result<SettlingRow, LatticeError> {
        let settle = |(load, shape): &(Load, FingerShape)| {
            let settled = lattice.settle_as(&[*load], Settling { sweeps, positions, most_steps: MOST_STEPS });
            match settled {
                Ok(settled) => Ok(Some((difference(shape, &settled.shape), settled.steps))),
                Err(LatticeError::NotSettled { .. }) => Ok(None),
                Err(error) => Err(error),
            }
        };
        let settled: Vec<Option<(f64, usize)>> = cases.par_iter().map(settle).collect::<Result<_, _>>()?;
        let all: Option<Vec<(f64, usize)>> = settled.into_iter().collect();
        Ok(SettlingRow {
            sweeps,
            positions,
            error: all.as_ref().map(|all| worst(all.iter().map(|(error, _)| *error))),
            steps: all.and_then(|all| all.iter().map(|(_, steps)| *steps).max()),
        })
    };
    SETTLINGS.par_iter().map(row).collect()
}

/// Imbalance caused by rounding alone: the largest unbalanced force on a body, relative to the load. For each load of a grid, the positions and
/// rotations of the bodies at equilibrium are rounded once to the given precision.
///
/// # Errors
/// [`LatticeError`] if a load has no equilibrium.
pub fn out_of_balance(lattice: &Lattice, grid: &LoadGrid, positions: Precision) -> Result<f64, LatticeError> {
    let energy = Energy::new(lattice.assembly());
    let share = |at: &(NodeId, f64), force_n: f64| -> Result<f64, LatticeError> {
        let loads = lattice.body_loads(&[load(lattice.finger(), at, force_n)])?;
        let mut motions = vec![BodyMotion::default(); lattice.assembly().bodies.len()];
        energy.follow(&mut motions, &loads, 0.0, 1.0)?;
        for (motion, body) in motions.iter_mut().zip(&lattice.assembly().bodies) {
            let position = (body.position + motion.displacement).map(|x| positions.round(x));
            motion.displacement = position - body.position;
            let (sine, cosine) = motion.rotation.sin_cos();
            motion.rotation = positions.round(sine).atan2(positions.round(cosine));
        }
        let left = energy.expand(&motions, &loads, 1.0).gradient;
        // Each body has three entries: two force components and a moment, which is ignored.
        Ok(worst(left.chunks(3).map(|body| body[0].hypot(body[1]))) / force_n)
    };
    let cases: Vec<_> =
        grid.directions().into_iter().flat_map(|at| grid.forces_n.iter().map(move |&force_n| (at, force_n))).collect();
    let shares: Vec<f64> = cases.par_iter().map(|(at, force_n)| share(at, *force_n)).collect::<Result<_, _>>()?;
    Ok(worst(shares))
}
