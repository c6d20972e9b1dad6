//! Gauss-Newton on the co-rotational finger.

use super::{Answer, BeamEstimator, ELEMENTS, EstimatorError, EstimatorRow, Question};
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
