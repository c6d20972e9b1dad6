//! Linear least squares, without a prior and with the paper's range of forces as a prior.

use super::{Answer, BeamEstimator, ELEMENTS, EstimatorError, EstimatorRow, Question, known_contacts};
use crate::sensing::{LinearEstimator, Linearisation, Prior};
use crate::{Finger, Mesh};

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
    mesh: Mesh::key_nodes,
    on: |mesh, _| Box::new(BeamEstimator::least_squares(mesh)),
    admits: |finger, contacts, _| known_contacts(finger, contacts).map(drop),
    answer: |finger, question| answer(finger, question, Prior::None),
};

pub(super) const RIDGE: EstimatorRow = EstimatorRow {
    name: "ridge",
    label: "ridge",
    help: "Least squares with the paper's range of forces as a prior",
    on: |mesh, _| Box::new(BeamEstimator::ridge(mesh)),
    answer: |finger, question| answer(finger, question, Prior::PAPER),
    ..LEAST_SQUARES
};

fn answer(finger: &Finger, question: &Question, prior: Prior) -> Result<Answer, EstimatorError> {
    let contacts = known_contacts(finger, question.contacts)?;
    let estimator = LinearEstimator::new(finger, &contacts, question.measurement)?;
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let mut linearisation = Linearisation::new(&mesh, &contacts);
    let estimate = estimator.estimate_on(&mut linearisation, question.measurement, question.noise_mm, prior)?;
    Ok((contacts, estimate))
}
