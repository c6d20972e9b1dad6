//! The Cramer-Rao bound of contact forces: the smallest covariance that independent noise of the markers' coordinates allows, at the true forces.

use crate::prelude::*;
use finray_model::statics::Ladder;
use finray_numerics::optimise::covariance;

/// Forces (N) at contacts as loads on a mesh; `None` if a contact is not on the mesh.
pub(super) fn loads(mesh: &Mesh, contacts: &[Contact], forces_n: &[f64]) -> Option<Vec<FrameLoad>> {
    let load = |(c, f): (&Contact, &f64)| mesh.frame_load(&c.load(mesh.finger(), *f)).ok();
    contacts.iter().zip(forces_n).map(load).collect()
}

/// Motion of a mesh under forces (N) at contacts, and derivatives (mm/N) of the displacements of the marked nodes with respect to the forces: two rows
/// (x, y) per marked node, one column per force. `None` if the finger has no equilibrium, or a contact is off the finger.
pub fn linearised_markers(
    statics: &mut Statics<Ladder>,
    mesh: &Mesh,
    contacts: &[Contact],
    forces_n: &[f64],
) -> Option<(FrameMotion, DMatrix<f64>)> {
    let finger = mesh.finger();
    let loads_of = |forces_n: &[f64]| loads(mesh, contacts, forces_n);
    let loads = loads_of(forces_n)?;
    let motion = statics.equilibrium(&loads).ok()?.motion;
    statics.linearise(&motion, &loads).then_some(())?;
    let mut of_nodes = vec![Vector::zeros(); finger.key_node_count()];
    let columns = loads_of(&vec![1.0; contacts.len()])?.into_iter().map(|unit_load| {
        statics.equations_mut().added_load(&motion, &unit_load, &mut of_nodes);
        let of_markers = finger.marked_nodes().map(|node| of_nodes[node.0 - 1]);
        DVector::from_iterator(2 * finger.marked_nodes().len(), of_markers.flat_map(|moved| [moved.x, moved.y]))
    });
    let columns: Vec<DVector<f64>> = columns.collect();
    Some((motion, DMatrix::from_columns(&columns)))
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
