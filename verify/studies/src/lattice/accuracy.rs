//! Error of the lattice against converged beams, and computation time of the lattice, for each fineness.

use crate::prelude::*;

/// Elements per member of converged beams. Doubling this number changes displacements of the paper's finger under 5 N by at most 1e-6, relative.
pub const CONVERGED_ELEMENTS: usize = 32;

/// Grid of loads under which lattice and beams are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadGrid {
    /// Loaded nodes.
    pub nodes: Vec<NodeId>,
    /// Directions, degrees from the inward normal, positive towards the tip.
    pub angles_deg: Vec<f64>,
    /// Forces, N, ascending.
    pub forces_n: Vec<f64>,
}

impl LoadGrid {
    /// All contact nodes except the tip, directions from -60 to 60 degrees, forces from 0.1 to 5 N.
    pub fn full(finger: &Finger) -> LoadGrid {
        LoadGrid {
            nodes: finger.contact_nodes().skip(1).collect(),
            angles_deg: (-4..=4).map(|i| 15.0 * f64::from(i)).collect(),
            forces_n: vec![0.1, 0.5, 1.0, 2.0, 3.0, 5.0],
        }
    }

    /// A few loads for slow computations, in directions that the full grid does not contain.
    pub fn few(finger: &Finger) -> LoadGrid {
        let nodes: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
        let every = nodes.len().div_ceil(3).max(1);
        LoadGrid {
            nodes: nodes.into_iter().step_by(every).collect(),
            angles_deg: vec![-50.0, 10.0],
            forces_n: vec![2.0, 5.0],
        }
    }

    /// Every pair of node and direction (degrees). Shapes over a grid of loads are listed in this order.
    pub fn directions(&self) -> Vec<(NodeId, f64)> {
        self.nodes.iter().flat_map(|&node| self.angles_deg.iter().map(move |&angle_deg| (node, angle_deg))).collect()
    }
}

/// Shapes of converged beams over a grid of loads, indexed by node and direction, then force.
pub(crate) fn beam_shapes(
    finger: &Finger,
    grid: &LoadGrid,
    kinematics: Kinematics,
) -> Result<Vec<Vec<FingerShape>>, StaticsError> {
    let mesh = Mesh::with_elements_per_member(finger, CONVERGED_ELEMENTS);
    let shapes = |&(node, angle_deg): &(NodeId, f64)| {
        let load = mesh.frame_load(&Load::at_node(node, finger.direction(angle_deg)))?;
        let (equilibria, stopped) = Statics::ladder(&mesh, kinematics).path(&[load], &grid.forces_n);
        match stopped {
            Some(error) => Err(error),
            None => Ok(equilibria.iter().map(|equilibrium| mesh.shape(&equilibrium.motion)).collect()),
        }
    };
    grid.directions().par_iter().map(shapes).collect()
}

/// Shapes of least energy of a lattice over a grid of loads, indexed like [`beam_shapes`].
pub(crate) fn lattice_shapes(lattice: &Lattice, grid: &LoadGrid) -> Result<Vec<Vec<FingerShape>>, LatticeError> {
    grid.directions().par_iter().map(|at| lattice_path(lattice, at, grid)).collect()
}

/// Shapes of a lattice at one node and direction, by force.
fn lattice_path(lattice: &Lattice, at: &(NodeId, f64), grid: &LoadGrid) -> Result<Vec<FingerShape>, LatticeError> {
    match lattice.path(&[load(lattice.finger(), at, 1.0)], &grid.forces_n)? {
        (shapes, None) => Ok(shapes),
        (_, Some(lost)) => Err(lost),
    }
}

/// A force (N) on a node in a direction (degrees from the inward normal).
pub(super) fn load(finger: &Finger, &(node, angle_deg): &(NodeId, f64), force_n: f64) -> Load {
    Load::at_node(node, finger.direction(angle_deg) * force_n)
}

/// Largest difference of a key node's displacement between two shapes, relative to the reference's largest displacement, dimensionless.
pub fn difference(reference: &FingerShape, other: &FingerShape) -> f64 {
    let pairs = reference.motions().iter().zip(other.motions());
    worst(pairs.map(|(a, b)| (a.displacement - b.displacement).norm())) / reference.largest_displacement_mm()
}

/// Largest [`difference`] over all nodes and directions, dimensionless, for each of the `forces` forces.
pub fn worst_by_force(reference: &[Vec<FingerShape>], other: &[Vec<FingerShape>], forces: usize) -> Vec<f64> {
    let at = |force: usize| worst(reference.iter().zip(other).map(|(a, b)| difference(&a[force], &b[force])));
    (0..forces).map(at).collect()
}

/// Error and computation time of the lattice at one fineness.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FinenessRow {
    /// Number of segments in a plate member of mean length.
    pub fineness: usize,
    /// Number of rigid bodies.
    pub bodies: usize,
    /// Number of springs.
    pub springs: usize,
    /// Forces, N.
    pub forces_n: Vec<f64>,
    /// Largest difference of the lattice's equilibrium from converged beams, relative to the largest displacement; one entry per force.
    pub errors: Vec<f64>,
    /// Mean time of Newton's method for all forces at one node and direction, ms on one core.
    pub newton_ms: f64,
    /// Error and time of settling (simulation until rest by the physics engine); `None` if not requested.
    pub settling: Option<SettlingCost>,
}

/// Error of a settled lattice against the equilibrium that Newton's method finds for it, and computation time of settling.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SettlingCost {
    /// Largest difference of a settled lattice from its equilibrium by Newton's method, relative to the largest displacement, dimensionless.
    pub error: f64,
    /// Largest number of steps to rest under one load.
    pub steps: usize,
    /// Mean time of settling under one load, ms on one core.
    pub ms: f64,
}

/// Why an accuracy study could not be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum AccuracyError {
    /// The lattice cannot be built, has no equilibrium, or does not settle.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// The beams have no equilibrium.
    #[error(transparent)]
    Beams(#[from] StaticsError),
}

/// Computes error and time for each fineness. Newton's method solves the loads of `grid`; settling uses the loads that `settled` returns for the
/// fineness.
///
/// Times refer to one core: the timed computations run in sequence on one thread.
///
/// # Errors
/// [`AccuracyError`] if a load has no equilibrium or a lattice does not settle.
pub fn study(
    finger: &Finger,
    finenesses: &[usize],
    grid: &LoadGrid,
    settled: impl Fn(usize) -> Option<LoadGrid>,
) -> Result<Vec<FinenessRow>, AccuracyError> {
    let beams = beam_shapes(finger, grid, Kinematics::Corotational)?;
    let row = |&fineness: &usize| {
        let lattice = Lattice::new(finger, fineness)?;
        let start = Instant::now();
        let paths = grid.directions().into_iter().map(|at| lattice_path(&lattice, &at, grid));
        let shapes = paths.collect::<Result<Vec<_>, _>>()?;
        let newton_ms = 1e3 * start.elapsed().as_secs_f64() / shapes.len() as f64;
        let settling = settled(fineness).map(|loads| settling_cost(&lattice, &loads)).transpose()?;
        Ok(FinenessRow {
            fineness,
            bodies: lattice.assembly().bodies.len(),
            springs: lattice.assembly().springs.len(),
            forces_n: grid.forces_n.clone(),
            errors: worst_by_force(&beams, &shapes, grid.forces_n.len()),
            newton_ms,
            settling,
        })
    };
    finenesses.iter().map(row).collect()
}

fn settling_cost(lattice: &Lattice, loads: &LoadGrid) -> Result<SettlingCost, LatticeError> {
    let equilibria = lattice_shapes(lattice, loads)?;
    let (shapes, steps, ms) = settled_shapes(lattice, loads)?;
    Ok(SettlingCost { error: worst(worst_by_force(&equilibria, &shapes, loads.forces_n.len())), steps, ms })
}

/// Settles a lattice under every load of a grid, in sequence. Returns three values: the shapes (by node and direction, then force), the largest
/// number of steps to rest, and the mean time under one load, ms.
pub(crate) fn settled_shapes(
    lattice: &Lattice,
    grid: &LoadGrid,
) -> Result<(Vec<Vec<FingerShape>>, usize, f64), LatticeError> {
    let (mut steps, start) = (0, Instant::now());
    let mut settle = |at: &(NodeId, f64), force_n: f64| {
        let settled = lattice.settle(&[load(lattice.finger(), at, force_n)])?;
        steps = steps.max(settled.steps);
        Ok(settled.shape)
    };
    let mut shapes = Vec::new();
    for at in grid.directions() {
        let column = grid.forces_n.iter().map(|&force_n| settle(&at, force_n));
        shapes.push(column.collect::<Result<Vec<_>, LatticeError>>()?);
    }
    let count = (shapes.len() * grid.forces_n.len()).max(1);
    Ok((shapes, steps, 1e3 * start.elapsed().as_secs_f64() / count as f64))
}
