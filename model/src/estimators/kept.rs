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
    pub linear: ForMarkers<LinearSolution>,
    pub network: ForMarkers<NetworkEstimator>,
    /// The last estimate, and the estimate from whose shapes its search started.
    refined: [Option<Refinement>; 2],
}

/// A result for the nodes and weights of markers.
#[derive(Debug)]
pub(crate) struct ForMarkers<T>(Option<(Vec<(NodeId, f64)>, T)>);

/// Linear least squares for contacts and markers, with the errors of linearisation computed so far.
#[derive(Debug)]
pub(crate) struct LinearSolution {
    pub contacts: Vec<Contact>,
    pub estimator: LinearEstimator,
    pub linearisation: Linearisation,
}

impl<T> Default for ForMarkers<T> {
    fn default() -> ForMarkers<T> {
        ForMarkers(None)
    }
}

impl<T> ForMarkers<T> {
    /// The result for the markers of a measurement. It is computed if the kept result is for other markers.
    pub fn get_or_compute<E>(
        &mut self,
        measurement: &Measurement,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<&mut T, E> {
        let markers = || measurement.markers().iter().map(|marker| (marker.node, marker.weight));
        self.0.take_if(|(of, _)| !markers().eq(of.iter().copied()));
        let (_, result) = match &mut self.0 {
            Some(kept) => kept,
            none => none.insert((markers().collect(), compute()?)),
        };
        Ok(result)
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
        let &Question { object, measurement, marker_noise_mm, near, .. } = question;
        let is_near = |of: &Option<Refinement>| of.as_ref().zip(near).is_some_and(|(of, near)| of.keeps(near));
        let index = self.refined.iter().position(is_near);
        if let (Some(near), Some(1)) = (near, index)
            && let Some(start) = &mut self.refined[1]
            && let Some(sample) = start.sense_sample(object, measurement, marker_noise_mm, near)
        {
            return Ok(sample);
        }
        let start = index.and_then(|index| self.refined[index].take());
        let mut refinement =
            start.clone().unwrap_or_else(|| Refinement::new(question.prepared.meshes.clone(), question.contacts));
        let found = refinement.sense(object, measurement, marker_noise_mm, near);
        self.refined = [Some(refinement), start];
        found
    }
}
