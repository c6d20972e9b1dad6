//! What estimators compute once and use again.

use super::{ELEMENTS, Question};
use crate::Finger;
use crate::compliance::NodalCompliance;
use crate::finger::NodeId;
use crate::measurement::Measurement;
use crate::mesh::MeshLevels;
use crate::sensing::network::NetworkEstimator;
use crate::sensing::{
    Contact, LinearEstimator, Linearisation, NonlinearEstimate, Refinement, SensingError, check_contacts,
};
use std::sync::OnceLock;

/// A finger with its meshes and its compliance, each computed when it is first needed, for any contacts.
#[derive(Debug)]
pub(crate) struct PreparedFinger {
    /// The finger's meshes.
    pub meshes: MeshLevels,
    compliance: OnceLock<NodalCompliance>,
}

impl PreparedFinger {
    pub fn new(finger: &Finger) -> PreparedFinger {
        PreparedFinger { meshes: MeshLevels::new(finger), compliance: OnceLock::new() }
    }

    pub fn finger(&self) -> &Finger {
        self.meshes.finger()
    }

    /// Compliance of the linear finger.
    pub fn compliance(&self) -> &NodalCompliance {
        self.compliance.get_or_init(|| NodalCompliance::new(self.finger()))
    }
}

/// Results for given contacts that later measurements use again. They change no estimate beyond the tolerance of a search.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    pub linear: Option<(MarkerSet, LinearSolution)>,
    pub network: Option<(MarkerSet, NetworkEstimator)>,
    /// The last estimate, and the estimate from whose shapes its search started.
    refined: [Option<Refinement>; 2],
}

/// Nodes and weights of the markers of a measurement.
#[derive(Debug, PartialEq)]
pub(crate) struct MarkerSet(Vec<(NodeId, f64)>);

/// Linear least squares for contacts and markers, with the errors of linearisation computed so far.
#[derive(Debug)]
pub(crate) struct LinearSolution {
    pub contacts: Vec<Contact>,
    pub estimator: LinearEstimator,
    pub linearisation: Linearisation,
}

impl MarkerSet {
    pub fn of(measurement: &Measurement) -> MarkerSet {
        MarkerSet(measurement.markers().iter().map(|marker| (marker.node, marker.weight)).collect())
    }
}

impl LinearSolution {
    /// Solves the linear finger for known contacts and the markers of a measurement.
    pub fn new(
        prepared: &PreparedFinger,
        contacts: Vec<Contact>,
        markers: &Measurement,
    ) -> Result<LinearSolution, SensingError> {
        check_contacts(prepared.finger(), &contacts)?;
        // Because of rounding, the solution for a unit moment may fail even if the solution for the force succeeds.
        let estimator = match LinearEstimator::on(prepared.compliance(), &contacts, markers) {
            Err(SensingError::Statics(_)) => LinearEstimator::new(prepared.finger(), &contacts, markers),
            found => found,
        }?;
        let linearisation = Linearisation::new(prepared.meshes.with_elements(ELEMENTS).clone(), &contacts);
        Ok(LinearSolution { contacts, estimator, linearisation })
    }
}

impl Kept {
    /// Estimates forces on successively finer meshes. If `question.near` is a kept estimate, the search starts from its shapes. An estimate that
    /// serves as start a second time is expected to differ by noise alone.
    pub fn refine(&mut self, question: &Question) -> Result<NonlinearEstimate, SensingError> {
        let &Question { object, measurement, noise_mm, near, .. } = question;
        let is_near = |of: &Option<Refinement>| of.as_ref().zip(near).is_some_and(|(of, near)| of.keeps(near));
        let index = self.refined.iter().position(is_near);
        let start = index.and_then(|index| self.refined[index].take());
        let mut refinement =
            start.clone().unwrap_or_else(|| Refinement::new(question.prepared.meshes.clone(), question.contacts));
        let found = match near.filter(|_| index == Some(1)) {
            Some(near) => refinement.sense_sample(object, measurement, noise_mm, near),
            None => refinement.sense(object, measurement, noise_mm, near),
        };
        self.refined = [Some(refinement), start];
        found
    }
}
