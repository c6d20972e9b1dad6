//! The Cramer-Rao bound of contact forces: the smallest covariance that independent noise of the markers' coordinates allows, at the true forces.

use crate::prelude::*;
use finray_model::statics::Ladder;
use finray_numerics::optimise::covariance;

/// Forces (N) at contacts as loads on a mesh.
///
/// # Errors
/// [`LoadError`] for a contact off the finger.
pub(super) fn loads(mesh: &Mesh, contacts: &[Contact], forces_n: &[f64]) -> Result<Vec<FrameLoad>, LoadError> {
    let load = |(contact, force_n): (&Contact, &f64)| mesh.frame_load(&contact.load(mesh.finger(), *force_n));
    contacts.iter().zip(forces_n).map(load).collect()
}

/// Coordinates (x, y) of the marked nodes, in the unit of `of_nodes`, which has one vector per key node.
pub fn marker_coordinates(finger: &Finger, of_nodes: &[Vector]) -> DVector<f64> {
    let nodes = finger.marked_nodes();
    DVector::from_iterator(2 * nodes.len(), nodes.flat_map(|node| <[f64; 2]>::from(of_nodes[node.0 - 1])))
}

/// Motion of a mesh under forces (N) at contacts, and derivatives (mm/N) of the displacements of the marked nodes with respect to the forces: two rows
/// (x, y) per marked node, one column per force. `statics` stays linearised at the motion. `None` if the finger has no equilibrium.
///
/// # Errors
/// [`LoadError`] for a contact off the finger.
pub fn linearised_markers(
    statics: &mut Statics<Ladder>,
    mesh: &Mesh,
    contacts: &[Contact],
    forces_n: &[f64],
) -> Result<Option<(FrameMotion, DMatrix<f64>)>, LoadError> {
    let finger = mesh.finger();
    let (of_forces, unit_loads) =
        (loads(mesh, contacts, forces_n)?, loads(mesh, contacts, &vec![1.0; contacts.len()])?);
    let found = statics.equilibrium(&of_forces).ok().map(|found| found.motion);
    let Some(motion) = found.filter(|motion| statics.linearise(motion, &of_forces)) else { return Ok(None) };
    let mut of_nodes = vec![Vector::zeros(); finger.key_node_count()];
    let column = |unit_load: &FrameLoad| {
        statics.equations_mut().added_load(&motion, unit_load, &mut of_nodes);
        marker_coordinates(finger, &of_nodes)
    };
    let columns: Vec<DVector<f64>> = unit_loads.iter().map(column).collect();
    Ok(Some((motion, DMatrix::from_columns(&columns))))
}

/// Cramer-Rao bound of forces. An estimator that reaches the bound responds to small noise as least squares on the linearised finger does.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceBound {
    /// Pseudo-inverse of the derivatives of the markers, N/mm: one row per force, two columns per marker.
    gain: DMatrix<f64>,
}

impl ForceBound {
    /// The bound for derivatives from [`linearised_markers`]. `None` if the forces are not identifiable.
    pub fn new(derivatives: &DMatrix<f64>) -> Option<ForceBound> {
        Some(ForceBound { gain: covariance(derivatives)? * derivatives.transpose() })
    }

    /// Smallest standard deviation of each force, N, under noise of standard deviation `noise_mm` (mm) in each coordinate.
    pub fn sigmas_n(&self, noise_mm: f64) -> Vec<f64> {
        self.gain.row_iter().map(|row| noise_mm * row.norm()).collect()
    }

    /// Smallest standard deviation of the sum of all forces, N.
    pub fn sum_sigma_n(&self, noise_mm: f64) -> f64 {
        noise_mm * self.gain.row_sum().norm()
    }

    /// Errors of the forces, N, to first order in errors of the markers (mm).
    pub fn response_n(&self, errors_mm: &DVector<f64>) -> DVector<f64> {
        &self.gain * errors_mm
    }
}
