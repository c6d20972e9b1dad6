//! Gauss-Newton on the co-rotational finger.

use super::{Answer, EstimatorError, EstimatorRow, Question};
use crate::sensing::{
    Discretisation, LinearisedAssembly, NearForces, NonlinearEstimate, NonlinearEstimator, check_questions,
    linearise_assembly,
};
use crate::{Finger, Mesh};

pub(super) const ROW: EstimatorRow = EstimatorRow {
    name: "nonlinear",
    label: "nonlinear",
    help: "Gauss-Newton on the co-rotational finger",
    is_linear: false,
    searches: true,
    at_nodes: false,
    needs: "contacts; their positions and directions may be unknown",
    refuses: "measurements that no shape of the finger explains; directions and positions that are not identifiable",
    unseen_contacts: "any",
    admits: |finger, contacts, _| Ok(check_questions(finger, contacts)?),
    answer,
};

/// Answers a question. If the unloaded finger may differ from the scene's finger, its errors are first linearised at the best forces.
fn answer(finger: &Finger, question: &Question) -> Result<Answer, EstimatorError> {
    let &Question { contacts, object, measurement, near, .. } = question;
    let Some(unloaded) = question.unloaded else {
        let sensed = sense(finger, question)?;
        return Ok((sensed.contacts, sensed.forces));
    };
    // Without a stated noise, the noise is the residual of the scene's finger.
    let marker_noise_mm = match question.marker_noise_mm {
        Some(marker_noise_mm) => marker_noise_mm,
        None => sense(finger, question)?.forces.trusted_noise_mm,
    };
    let linearised = linearise_assembly(finger, contacts, object, unloaded, measurement, marker_noise_mm, near)?;
    let LinearisedAssembly { measurement, contacts, forces_n } = &linearised;
    let near = Some(NearForces { contacts, forces_n, shape: None });
    let sensed = sense(finger, &Question { measurement, marker_noise_mm: Some(marker_noise_mm), near, ..*question })?;
    Ok((sensed.contacts, sensed.forces))
}

/// Estimates the forces on a mesh of `mesh_nodes` nodes. Without `mesh_nodes`, refines the mesh until doubling the mesh hardly changes the forces.
fn sense(finger: &Finger, question: &Question) -> Result<NonlinearEstimate, EstimatorError> {
    let &Question { contacts, object, measurement, marker_noise_mm, .. } = question;
    match question.mesh_nodes {
        None => Ok(question.kept.borrow_mut().refine(question)?),
        Some(nodes) => {
            let mesh = Mesh::with_nodes(finger, nodes)?;
            let finer = Discretisation::finer(&mesh);
            let mut estimator = NonlinearEstimator::new(&mesh, contacts)?.with_object(object);
            let mut estimate = match question.near {
                None => estimator.estimate(measurement, marker_noise_mm),
                Some(near) => estimator.estimate_near(near, false, measurement, marker_noise_mm),
            }?;
            Discretisation::new(&mesh, &finer).widen(&mut estimator, measurement, &mut estimate)?;
            Ok(estimate)
        }
    }
}
