//! Linear least squares, without a prior and with the paper's range of forces as a prior.

use super::kept::LinearSolution;
use super::{Answer, EstimatorError, EstimatorRow, Question, known_contacts};
use crate::Finger;
use crate::sensing::ForcePrior;

pub(super) const LEAST_SQUARES: EstimatorRow = EstimatorRow {
    name: "least-squares",
    label: "least squares",
    help: "Linear least squares",
    is_linear: true,
    searches: false,
    at_nodes: false,
    needs: "position and direction of the contact",
    refuses: "contacts that are not identifiable",
    unseen_contacts: "any",
    admits: |finger, contacts, _| known_contacts(finger, contacts).map(drop),
    answer: |finger, question| answer(finger, question, ForcePrior::None),
};

pub(super) const RIDGE: EstimatorRow = EstimatorRow {
    name: "ridge",
    label: "ridge",
    help: "Least squares with the paper's range of forces as a prior",
    answer: |finger, question| answer(finger, question, ForcePrior::PAPER),
    ..LEAST_SQUARES
};

fn answer(finger: &Finger, question: &Question, prior: ForcePrior) -> Result<Answer, EstimatorError> {
    let mut kept = question.kept.borrow_mut();
    let LinearSolution { contacts, estimator, linearisation } =
        kept.linear.get_or_compute(question.measurement, || {
            let contacts = known_contacts(finger, question.contacts)?;
            LinearSolution::new(question.prepared, contacts, question.measurement).map_err(EstimatorError::from)
        })?;
    let estimate = estimator.estimate_on(linearisation, question.measurement, question.marker_noise_mm, prior)?;
    Ok((contacts.clone(), estimate))
}
