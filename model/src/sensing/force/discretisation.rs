//! Discretisation error of estimated forces, computed by comparison with a finer mesh.

use super::estimate::NonlinearEstimate;
use super::estimator::NonlinearEstimator;
use super::problem::State;
use crate::finger::Plate;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::{Contact, ContactQuestion, SensingError, Warning};
use crate::statics::{Ladder, Statics};
use crate::{Finger, Kinematics};

/// The finer mesh divides each element into this number of parts. Members of a single element need more parts (`DIVISIONS_OF_SINGLE`), because their
/// errors do not yet decrease with the square of the element length.
const DIVISIONS: usize = 2;
const DIVISIONS_OF_SINGLE: usize = 4;
/// A stored error is reused for an estimate with nearly the same forces, positions and directions. The largest accepted differences are this share of
/// the largest force, the share `SAME_POSITION` of the plate's length, and the angle `SAME_ANGLE_DEG`. The limits for reuse may be wide, because a
/// computed error of the mesh is only accurate to about a third.
const SAME_FORCE: f64 = 0.12;
const SAME_POSITION: f64 = 0.02;
const SAME_ANGLE_DEG: f64 = 3.0;
/// All stored errors are cleared when there are this many.
const MOST_KEPT: usize = 256;

/// Computes the error of estimated forces due to the mesh, by comparison with a finer mesh.
///
/// # Requirements
/// Requires an estimator on a mesh of the same finger, and the last estimate of this estimator.
///
/// # Reference
/// Under the estimated forces, the displacements of the finer mesh exceed those of the coarse mesh by d. The coarse mesh needs the additional forces
/// A^+ d to reach the same displacements, where A^+ is the pseudo-inverse of A. A contains the derivatives of the coarse mesh's shape with respect to
/// the unknowns. Errors of co-rotational beams decrease with the square of the element length. Richardson's extrapolation therefore multiplies A^+ d
/// by n^2 / (n^2 - 1), for n elements of the finer mesh per element of the coarse mesh.
#[derive(Debug, Clone)]
pub struct Discretisation<'m> {
    finer: &'m Mesh,
    /// Ratio of the error of the mesh to the difference between the two meshes, dimensionless.
    extrapolated: f64,
    statics: Statics<Ladder<'m>>,
    /// Stored errors, N, with the forces and contacts to which they belong.
    known: Vec<Known>,
}

/// Error of each force due to a mesh, N, with the forces and contacts to which the error belongs.
#[derive(Debug, Clone)]
pub(super) struct Known {
    pub(super) forces_n: Vec<f64>,
    pub(super) contacts: Vec<Contact>,
    pub(super) error_n: Vec<f64>,
}

impl Known {
    /// Whether the error also holds for other forces, N, and contacts.
    pub(super) fn serves(&self, finger: &Finger, contacts: &[Contact], forces_n: &[f64]) -> bool {
        let largest_n = self.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let same_force = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_FORCE * largest_n;
        let length_mm = finger.plate_length_mm(Plate::Front);
        let same_contact = |(a, b): (&Contact, &Contact)| {
            let [a_mm, b_mm] = [a, b].map(|contact| contact.position_mm(finger).unwrap_or(f64::NAN));
            (a_mm - b_mm).abs() <= SAME_POSITION * length_mm && (a.angle_deg - b.angle_deg).abs() <= SAME_ANGLE_DEG
        };
        self.forces_n.iter().zip(forces_n).all(same_force) && self.contacts.iter().zip(contacts).all(same_contact)
    }
}

impl<'m> Discretisation<'m> {
    /// A refined mesh, fine enough to show the error of `mesh`.
    pub fn finer(mesh: &Mesh) -> Mesh {
        mesh.refined(if mesh.has_single_elements() { DIVISIONS_OF_SINGLE } else { DIVISIONS })
    }

    /// Prepares the comparison of a mesh with a [`finer`](Discretisation::finer) mesh.
    pub fn new(mesh: &Mesh, finer: &'m Mesh) -> Discretisation<'m> {
        let squared = (finer.element_count() as f64 / mesh.element_count() as f64).powi(2);
        let extrapolated = squared / (squared - 1.0);
        Discretisation {
            finer,
            extrapolated,
            statics: Statics::ladder(finer, Kinematics::Corotational),
            known: Vec::new(),
        }
    }

    /// Adds the error of the mesh to the standard deviations of the estimator's last estimate. Sets a warning if the error of the mesh exceeds the error due to
    /// noise.
    ///
    /// # Errors
    /// [`SensingError`] if the finer mesh has no equilibrium under the estimated forces, or no estimate has been made.
    pub fn widen(
        &mut self,
        estimator: &mut NonlinearEstimator,
        measurement: &Measurement,
        estimate: &mut NonlinearEstimate,
    ) -> Result<(), SensingError> {
        let finger = self.finer.finger();
        let state = estimator.last.as_mut().ok_or(SensingError::NoContact)?;
        let error_n = match self.known.iter().find(|known| known.serves(finger, &state.contacts, &state.forces_n)) {
            Some(known) => known.error_n.clone(),
            None => {
                let error_n = self.error(&estimator.problem.questions, state, measurement)?;
                if self.known.len() == MOST_KEPT {
                    self.known.clear();
                }
                let (forces_n, contacts) = (state.forces_n.clone(), state.contacts.clone());
                self.known.push(Known { forces_n, contacts, error_n: error_n.clone() });
                error_n
            }
        };
        estimate.forces.add_method_error(error_n, Warning::Discretisation);
        Ok(())
    }

    /// Error of each force due to the mesh, N.
    fn error(
        &mut self,
        questions: &[ContactQuestion],
        state: &mut State,
        measurement: &Measurement,
    ) -> Result<Vec<f64>, SensingError> {
        let loads = state.loads_under(self.finer, questions, &state.forces_n)?;
        let fine = self.statics.equilibrium(&loads)?.motion;
        let coarse = &state.motion.displacements;
        let further = |node: usize| fine.displacements[node] - coarse[node];
        let explained = state.linearised.explained(measurement, further)?;
        // Forces are the first unknowns.
        Ok(explained[..state.forces_n.len()].iter().map(|force| self.extrapolated * force).collect())
    }
}
