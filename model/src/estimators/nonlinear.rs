//! Gauss-Newton on the co-rotational finger.

use super::{Answer, EstimatorError, EstimatorRow, Question};
use crate::sensing::{Discretisation, NonlinearEstimate, NonlinearEstimator, Pushed, SensingError, check_questions};
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

/// Estimates are repeated until a round changes every force by at most this share of its standard deviation. Repetition is needed because the effect of
/// assembly errors on the markers depends on the forces. The estimate fails after `ROUNDS` rounds.
const SETTLED_SIGMAS: f64 = 0.05;
const ROUNDS: usize = 8;

/// Answers a question. Repeats the estimate if the unloaded finger may differ from the scene's finger. Each round linearises the assembly errors at
/// the forces and errors of the previous round.
fn answer(finger: &Finger, question: &Question) -> Result<Answer, EstimatorError> {
    let Some(unloaded) = question.unloaded else {
        let sensed = sensed(finger, question)?;
        return Ok((sensed.contacts, sensed.forces));
    };
    let mut found: Option<NonlinearEstimate> = None;
    let mut change_n = f64::INFINITY;
    for _ in 0..ROUNDS {
        let (contacts, forces_n, errors) = found.as_ref().map_or((&[][..], &[][..], &[][..]), |found| {
            (&found.contacts, &found.forces.forces_n, &found.shared_errors)
        });
        let pushed = Pushed { questions: question.contacts, contacts, forces_n, pad: question.pad };
        let measurement = unloaded.allowed_for(finger, question.measurement, pushed, errors)?;
        let noise_mm = question.noise_mm.map(|noise_mm| match found {
            Some(_) => noise_mm,
            None => noise_mm.hypot(unloaded.unknown_without_forces_mm()),
        });
        let next = sensed(finger, &Question { measurement: &measurement, noise_mm, ..*question })?;
        let pairs = next.forces.forces_n.iter().zip(forces_n).zip(&next.forces.sigmas_n);
        let changes = pairs.map(|((next_n, force_n), sigma_n)| [(next_n - force_n).abs(), *sigma_n]);
        let (largest_n, is_settled) = changes
            .fold((0.0_f64, !forces_n.is_empty()), |(largest_n, settled), [by_n, sd]| {
                (largest_n.max(by_n), settled && by_n <= SETTLED_SIGMAS * sd)
            });
        if is_settled {
            return Ok((next.contacts, next.forces));
        }
        (change_n, found) = (largest_n, Some(next));
    }
    Err(SensingError::NotConverged { iterations: ROUNDS, change_n }.into())
}

/// Estimates the forces on a mesh of `mesh_nodes` nodes. Without `mesh_nodes`, refines the mesh until doubling the mesh hardly changes the forces.
fn sensed(finger: &Finger, question: &Question) -> Result<NonlinearEstimate, EstimatorError> {
    let &Question { contacts, pad, object, measurement, noise_mm, .. } = question;
    match question.mesh_nodes {
        None => Ok(question.kept.borrow_mut().refine(question)?),
        Some(nodes) => {
            let mesh = Mesh::with_nodes(finger, nodes)?;
            let finer = Discretisation::finer(&mesh);
            let mut estimator = NonlinearEstimator::new(&mesh, contacts)?.with_pad(pad).with_object(object);
            let mut estimate = estimator.estimate(measurement, noise_mm)?;
            Discretisation::new(&mesh, &finer).widen(&mut estimator, measurement, &mut estimate)?;
            Ok(estimate)
        }
    }
}
