//! Estimates on successively finer meshes.

use super::alternatives::widen_by;
use super::discretisation::Known;
use super::estimate::NonlinearEstimate;
use super::estimator::{NearForces, NonlinearEstimator};
use super::linearised::Seen;
use super::problem::State;
use super::states::unit_motions;
use crate::Finger;
use crate::measurement::Measurement;
use crate::mesh::MeshLevels;
use crate::sensing::{Contact, ContactQuestion, Estimate, SensingError, TouchedObject, Warning};

/// Refinement ends when doubling the mesh changes each force by no more than either of two limits: this share of the largest force, and
/// `REFINEMENT_SIGMAS` standard deviations of the force. A change by at most the share `NEGLIGIBLE` of the largest force is always small enough.
const REFINEMENT_TOLERANCE: f64 = 2e-3;
const REFINEMENT_SIGMAS: f64 = 0.5;
const NEGLIGIBLE: f64 = 1e-4;
/// If refinement has converged, the error of the last mesh is this share of the last change, because errors decrease with the square of the element
/// length (Richardson).
const REMAINS: f64 = 1.0 / 3.0;
/// Beam elements per member: lower limit for the first mesh, and upper limit for the finest mesh.
const ELEMENTS: std::ops::RangeInclusive<usize> = 4..=64;
/// Forces that differ by at most this number of standard deviations differ by noise alone, so the error of the mesh is the same.
const NOISE_SIGMAS: f64 = 6.0;
/// The first mesh has at least this number of elements. With this number of elements, the first mesh separates minima as well as a fine mesh does,
/// even for a finger with few ribs.
const LEAST_ELEMENTS: usize = 40;

/// Refines the mesh until doubling the mesh changes every force by at most half of the force's standard deviation and at most 0.2 % of the largest
/// force. A change of at most 0.01 % of the largest force is always small enough. The standard deviations include the remaining error of the last
/// mesh. Refinement also ends at 64 elements per member; the whole change by the last doubling then counts as the error of the mesh. `object` is
/// `None` if the shape of the object is unknown. On the first mesh, the search starts from `near` unless `near` is `None`.
///
/// Small changes alone do not prove convergence. Near a limit load, and for loads between nodes, the change by one doubling of the mesh may be small
/// by chance, and the next change may be larger again.
///
/// # Errors
/// [`SensingError`] from the estimate on any of the meshes.
pub fn sense_refining(
    finger: &Finger,
    questions: &[ContactQuestion],
    object: Option<&TouchedObject>,
    measurement: &Measurement,
    marker_noise_mm: Option<f64>,
    near: Option<NearForces>,
) -> Result<NonlinearEstimate, SensingError> {
    Refinement::new(MeshLevels::new(finger), questions).sense(object, measurement, marker_noise_mm, near)
}

/// Estimates forces like [`sense_refining`], and keeps the shapes of the last estimate for the next measurement of a stream.
#[derive(Debug, Clone)]
pub struct Refinement {
    meshes: MeshLevels,
    questions: Vec<ContactQuestion>,
    /// States of the last estimate on the meshes that it needed, from coarse to fine.
    states: Vec<Option<State>>,
    /// The last estimate; `None` if it failed.
    found: Option<Refined>,
}

/// Contacts and forces of an estimate, N, under which the kept shapes are in equilibrium.
#[derive(Debug, Clone)]
struct Refined {
    contacts: Vec<Contact>,
    forces_n: Vec<f64>,
    /// Error of the finest mesh.
    mesh_error: Known,
    /// Whether the finger explains the measurement.
    is_explained: bool,
}

impl Refinement {
    /// Prepares estimates for a finger's meshes and contacts.
    pub fn new(meshes: MeshLevels, questions: &[ContactQuestion]) -> Refinement {
        Refinement { meshes, questions: questions.to_vec(), states: Vec::new(), found: None }
    }

    /// Whether `near` is the last estimate, so that its shapes are kept.
    pub fn keeps(&self, near: NearForces) -> bool {
        self.found.as_ref().is_some_and(|found| near.contacts == found.contacts && near.forces_n == found.forces_n)
    }

    /// Estimates the forces of a measurement, as [`sense_refining`] describes. If `near` is the last estimate, the search on each mesh starts from
    /// the shape that the mesh had in the last estimate, not from the equilibrium under the forces of `near`. If a kept shape and the equilibrium
    /// under the forces of `near` lead to the same minimum, the forces agree within the tolerance of the search, about 1e-8 of the largest force.
    ///
    /// # Errors
    /// [`SensingError`] from the estimate on any of the meshes.
    pub fn sense(
        &mut self,
        object: Option<&TouchedObject>,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
        near: Option<NearForces>,
    ) -> Result<NonlinearEstimate, SensingError> {
        let seen = Seen { measurement, marker_noise_mm };
        if !near.is_some_and(|near| self.keeps(near)) {
            self.states.clear();
        }
        self.found = None;
        let mut coarse = self.on(0, object, seen, near, false)?;
        for level in 1.. {
            let [of_coarse, of_fine] = [level - 1, level].map(|level| self.meshes.with_elements(self.elements(level)));
            let shape = self.states[level - 1].as_ref().map(|state| of_fine.interpolate(of_coarse, &state.motion));
            let (contacts, forces_n) = (&coarse.contacts[..], &coarse.forces.forces_n[..]);
            let near = NearForces { contacts, forces_n, shape: shape.as_ref() };
            let mut fine = self.on(level, object, seen, Some(near), true)?;
            let alternatives = std::mem::take(&mut coarse.alternatives);
            widen_by(&alternatives, &mut fine, self.meshes.finger());
            fine.alternatives = alternatives;
            let largest_n = fine.forces.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            let pairs = fine.forces.forces_n.iter().zip(&coarse.forces.forces_n);
            let change_n: Vec<f64> = pairs.map(|(fine, coarse)| fine - coarse).collect();
            let is_small = |(change, sigma_n): (&f64, &f64)| {
                change.abs()
                    <= (REFINEMENT_SIGMAS * sigma_n).clamp(NEGLIGIBLE * largest_n, REFINEMENT_TOLERANCE * largest_n)
            };
            let is_settled = change_n.iter().zip(&fine.forces.sigmas_n).all(is_small);
            coarse = fine;
            if is_settled || 2 * self.elements(level) > *ELEMENTS.end() {
                let remains = if is_settled { REMAINS } else { 1.0 };
                let error_n: Vec<f64> = change_n.iter().map(|change| remains * change).collect();
                let is_explained = coarse.forces.warning.is_none();
                coarse.forces.add_method_error(error_n.clone(), Warning::Discretisation);
                self.states.truncate(level + 1);
                let (contacts, forces_n) = (coarse.contacts.clone(), coarse.forces.forces_n.clone());
                let mesh_error = Known { contacts: contacts.clone(), forces_n: forces_n.clone(), error_n };
                self.found = Some(Refined { contacts, forces_n, mesh_error, is_explained });
                break;
            }
        }
        Ok(coarse)
    }

    /// Estimates the forces of a measurement that differs by noise alone from the measurement of the last estimate, `near`, whose shapes stay kept.
    /// One search on the finest mesh of that estimate then suffices, because the error of the mesh is the same. The result is that of
    /// [`sense`](Refinement::sense) within the tolerance of the search. `None` if the forces differ by more than noise, or the finger does not explain
    /// one of the measurements.
    pub fn sense_sample(
        &mut self,
        object: Option<&TouchedObject>,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
        near: NearForces,
    ) -> Option<NonlinearEstimate> {
        let found = self.found.as_ref().filter(|found| found.is_explained)?;
        let mesh = self.meshes.with_elements(self.elements(self.states.len().checked_sub(1)?));
        let kept = self.states.last_mut()?.as_mut()?;
        let mut estimator = NonlinearEstimator::new(mesh, &self.questions).ok()?.with_object(object);
        if kept.unit_motions.is_none() {
            kept.unit_motions = unit_motions(&mut estimator.problem, kept);
        }
        let seen = Seen { measurement, marker_noise_mm };
        let mut estimate = estimator.estimate_from_kept(Some(kept.clone()), near, false, seen).ok()?;
        let (contacts, Estimate { forces_n, sigmas_n, warning, .. }) = (&estimate.contacts, &estimate.forces);
        let differs = |((a, b), sigma_n): ((&f64, &f64), &f64)| (a - b).abs() > NOISE_SIGMAS * sigma_n;
        let differs = forces_n.iter().zip(near.forces_n).zip(sigmas_n).any(differs);
        let is_similar = !differs && found.mesh_error.serves(self.meshes.finger(), contacts, forces_n);
        (is_similar && warning.is_none()).then_some(())?;
        estimate.forces.add_method_error(found.mesh_error.error_n.clone(), Warning::Discretisation);
        Some(estimate)
    }

    /// Number of beam elements per member on a level.
    fn elements(&self, level: usize) -> usize {
        let members = 3 * self.meshes.finger().rib_count() + 2;
        LEAST_ELEMENTS.div_ceil(members).next_power_of_two().max(*ELEMENTS.start()) << level
    }

    /// Estimates the forces on the mesh of a level. `is_chosen` states whether `near` was chosen among all minima on a coarser mesh.
    fn on(
        &mut self,
        level: usize,
        object: Option<&TouchedObject>,
        seen: Seen,
        near: Option<NearForces>,
        is_chosen: bool,
    ) -> Result<NonlinearEstimate, SensingError> {
        let mesh = self.meshes.with_elements(self.elements(level)).clone();
        if self.states.len() <= level {
            self.states.resize_with(level + 1, || None);
        }
        let last = &mut self.states[level];
        let mut estimator = NonlinearEstimator::new(&mesh, &self.questions)?.with_object(object);
        let estimate = match near {
            None => estimator.estimate(seen.measurement, seen.marker_noise_mm),
            Some(near) => estimator.estimate_from_kept(last.take(), near, is_chosen, seen),
        };
        *last = estimator.last.take();
        estimate
    }
}
