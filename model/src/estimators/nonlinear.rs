//! Gauss-Newton on the co-rotational finger.

use super::{Answer, BeamEstimator, ELEMENTS, EstimatorError, EstimatorRow, PreparedEstimator, Question, Sensed};
use crate::measurement::Measurement;
use crate::sensing::{Discretisation, Meeting, NonlinearEstimator, sense_refining};
use crate::{Finger, Mesh};

pub(super) const ROW: EstimatorRow = EstimatorRow {
    name: "nonlinear",
    label: "nonlinear",
    help: "Gauss-Newton on the co-rotational finger",
    is_linear: false,
    searches: true,
    at_nodes: false,
    needs: "position of the contact; direction or position may be sought",
    refuses: "measurements that no shape of the finger explains, directions and positions that are not identifiable",
    unseen_contacts: "any",
    mesh: |finger| Mesh::with_elements_per_member(finger, ELEMENTS),
    on: |mesh, _| Box::new(BeamEstimator::nonlinear(mesh)),
    // A search for positions and directions checks them by what is measured.
    admits: |_, _, _| Ok(()),
    answer,
};

/// On a mesh of this many nodes, or refining until doubling the mesh changes little.
fn answer(finger: &Finger, question: &Question) -> Result<Answer, EstimatorError> {
    let &Question { contacts, pad, object, measurement, noise_mm, .. } = question;
    let sensed = match question.mesh_nodes {
        None => sense_refining(finger, contacts, Meeting { pad, object }, measurement, noise_mm)?,
        Some(nodes) => {
            let mesh = Mesh::with_nodes(finger, nodes)?;
            let finer = Discretisation::finer(&mesh);
            let mut estimator = NonlinearEstimator::new(&mesh, contacts)?.with_pad(pad).with_object(object);
            let mut estimate = estimator.estimate(measurement, noise_mm)?;
            Discretisation::new(&mesh, &finer).widen(&mut estimator, measurement, &mut estimate)?;
            estimate
        }
    };
    Ok((sensed.contacts, sensed.forces))
}

/// A nonlinear estimator that is ready to sense.
pub(super) struct Nonlinear<'m> {
    pub(super) estimator: NonlinearEstimator<'m>,
    pub(super) discretisation: Option<Discretisation<'m>>,
}

impl PreparedEstimator for Nonlinear<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        // A stream's start from the last frame would be too easy: answers must not depend on the order of measurements.
        self.estimator.reset();
        let mut estimate = self.estimator.estimate(measurement, noise_mm)?;
        if let Some(discretisation) = &mut self.discretisation {
            discretisation.widen(&mut self.estimator, measurement, &mut estimate)?;
        }
        Ok(Sensed {
            sum_sigma_n: Some(estimate.covariance_n2.sum().sqrt()),
            warned: estimate.forces.warning.is_some(),
            forces_n: estimate.forces.forces_n,
            sigmas_n: Some(estimate.forces.sigmas_n),
        })
    }

    fn expect_samples_of(&mut self, noise_free: &Measurement, noise_mm: f64, samples: usize) {
        self.estimator.forget();
        // One sample alone has nothing to share.
        if samples < 2 {
            return;
        }
        // Where the model contradicts the measurement there may be several minima, and a start decides between them.
        if self.estimator.estimate(noise_free, Some(noise_mm)).is_ok_and(|found| found.forces.warning.is_none()) {
            self.estimator.hold();
        }
    }
    fn expect_forces(&mut self, forces_n: &[f64]) {
        self.estimator.hold_at(forces_n);
    }
}
