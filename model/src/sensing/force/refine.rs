//! Estimates on successively finer meshes.

use super::estimate::NonlinearEstimate;
use super::estimator::{NearForces, NonlinearEstimator};
use super::linearised::Seen;
use super::problem::State;
use crate::Finger;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::{Contact, ContactQuestion, Pad, SensingError, TouchedObject, Warning};

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
/// The first mesh has at least this number of elements. With this number of elements, the first mesh separates minima as well as a fine mesh does,
/// even for a finger with few ribs.
const LEAST_ELEMENTS: usize = 40;

/// Refines the mesh until doubling the mesh changes every force by at most half of the force's standard deviation and at most 0.2 % of the largest
/// force. A change of at most 0.01 % of the largest force is always small enough. The standard deviations include the remaining error of the last
/// mesh. Refinement also ends at 64 elements per member; the whole change by the last doubling then counts as the error of the mesh. `object` touches
/// the `pad` on the front plate; `object` is `None` if the shape of the object is unknown. On the first mesh, the search starts from `near` unless
/// `near` is `None`.
///
/// Small changes alone do not prove convergence. Near a limit load, and for loads between nodes, the change by one doubling of the mesh may be small
/// by chance, and the next change may be larger again.
///
/// # Errors
/// [`SensingError`] from the estimate on any of the meshes.
pub fn sense_refining(
    finger: &Finger,
    questions: &[ContactQuestion],
    pad: Pad,
    object: Option<&TouchedObject>,
    measurement: &Measurement,
    noise_mm: Option<f64>,
    near: Option<NearForces>,
) -> Result<NonlinearEstimate, SensingError> {
    Refinement::new(finger, questions, pad).sense(object, measurement, noise_mm, near)
}

/// Estimates forces like [`sense_refining`], and keeps the meshes and the shapes of the last estimate for the next measurement of a stream.
#[derive(Debug, Clone)]
pub struct Refinement<'f> {
    finger: &'f Finger,
    questions: Vec<ContactQuestion>,
    pad: Pad,
    /// The meshes that were needed so far, from coarse to fine.
    levels: Vec<Level>,
    /// Contacts and forces of the last estimate, N, under which the kept shapes are in equilibrium. `None` if the last estimate failed.
    found: Option<(Vec<Contact>, Vec<f64>)>,
}

/// A mesh, and the state of the last estimate on this mesh.
#[derive(Debug, Clone)]
struct Level {
    mesh: Mesh,
    last: Option<State>,
}

impl<'f> Refinement<'f> {
    /// Prepares estimates for a finger, contacts and a pad.
    pub fn new(finger: &'f Finger, questions: &[ContactQuestion], pad: Pad) -> Refinement<'f> {
        Refinement { finger, questions: questions.to_vec(), pad, levels: Vec::new(), found: None }
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
        noise_mm: Option<f64>,
        near: Option<NearForces>,
    ) -> Result<NonlinearEstimate, SensingError> {
        let found = self.found.take();
        let is_last = |near: NearForces| {
            found.as_ref().is_some_and(|(contacts, forces_n)| near.contacts == contacts && near.forces_n == forces_n)
        };
        if !near.is_some_and(is_last) {
            self.levels.iter_mut().for_each(|level| level.last = None);
        }
        let members = 3 * self.finger.rib_count() + 2;
        let mut elements = LEAST_ELEMENTS.div_ceil(members).next_power_of_two().max(*ELEMENTS.start());
        let mut on = |level: usize, elements: usize, near: Option<NearForces>| {
            if level == self.levels.len() {
                self.levels.push(Level { mesh: Mesh::with_elements_per_member(self.finger, elements), last: None });
            }
            let Level { mesh, last } = &mut self.levels[level];
            let mut estimator = NonlinearEstimator::new(mesh, &self.questions)?.with_pad(self.pad).with_object(object);
            let estimate = match near {
                None => estimator.estimate(measurement, noise_mm),
                // A finer mesh starts from the forces that were chosen among all minima on the coarser mesh.
                Some(near) => {
                    let seen = Seen { measurement, noise_mm };
                    estimator.estimate_resuming(last.take(), near, level > 0, seen)
                }
            };
            *last = estimator.last.take();
            estimate
        };
        let mut coarse = on(0, elements, near)?;
        for level in 1.. {
            elements *= 2;
            let near = NearForces { contacts: &coarse.contacts, forces_n: &coarse.forces.forces_n };
            let fine = on(level, elements, Some(near))?;
            let largest_n = fine.forces.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            let pairs = fine.forces.forces_n.iter().zip(&coarse.forces.forces_n);
            let change_n: Vec<f64> = pairs.map(|(fine, coarse)| fine - coarse).collect();
            let is_small = |(change, sigma_n): (&f64, &f64)| {
                change.abs()
                    <= (REFINEMENT_SIGMAS * sigma_n).clamp(NEGLIGIBLE * largest_n, REFINEMENT_TOLERANCE * largest_n)
            };
            let is_settled = change_n.iter().zip(&fine.forces.sigmas_n).all(is_small);
            coarse = fine;
            if is_settled || 2 * elements > *ELEMENTS.end() {
                let remains = if is_settled { REMAINS } else { 1.0 };
                coarse
                    .add_model_error(change_n.iter().map(|change| remains * change).collect(), Warning::Discretisation);
                break;
            }
        }
        self.found = Some((coarse.contacts.clone(), coarse.forces.forces_n.clone()));
        Ok(coarse)
    }
}
