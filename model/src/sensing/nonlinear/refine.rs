//! Estimates on successively finer meshes.

use super::{NearForces, NonlinearEstimate, NonlinearEstimator};
use crate::Finger;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::{ContactQuestion, Pad, SensingError, TouchedObject, Warning};

/// Refinement ends when doubling the mesh changes no force by more than either of two limits: this share of the largest force, and `REFINEMENT_SIGMAS` standard
/// deviations of the force. A change by at most the share `NEGLIGIBLE` is always small enough.
const REFINEMENT_TOLERANCE: f64 = 2e-3;
const REFINEMENT_SIGMAS: f64 = 0.5;
const NEGLIGIBLE: f64 = 1e-4;
/// If refinement has settled, this share of the last change remains as an error of the last mesh, because errors decrease with the square of the
/// element length (Richardson).
const REMAINS: f64 = 1.0 / 3.0;
/// Beam elements per member: lower limit for the first mesh, and upper limit for the finest mesh.
const ELEMENTS: std::ops::RangeInclusive<usize> = 4..=64;
/// The first mesh has at least this number of elements. Even for a finger with few ribs, the first mesh then separates minima as well as a fine mesh
/// does.
const LEAST_ELEMENTS: usize = 40;

/// Refines the mesh until doubling the mesh changes every force by at most half of the force's standard deviation and at most 0.2 % of the largest
/// force. A change of at most 0.01 % of the largest force is always small enough. The standard deviations include the remaining error of the last
/// mesh. Refinement also ends at 64 elements per member; the whole last change then counts as error. `object` touches the `pad` on the front plate;
/// `object` is `None` if the shape of the object is unknown. On the first mesh, the search starts from `near` unless `near` is `None`.
///
/// Small changes alone do not prove convergence. Near a limit load, and for loads between nodes, changes may be small by chance and grow again.
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
    let on = |elements, near: Option<NearForces>, is_chosen: bool| {
        let mesh = Mesh::with_elements_per_member(finger, elements);
        let mut estimator = NonlinearEstimator::new(&mesh, questions)?.with_pad(pad).with_object(object);
        match near {
            None => estimator.estimate(measurement, noise_mm),
            Some(near) => estimator.estimate_near(near, is_chosen, measurement, noise_mm),
        }
    };
    let members = 3 * finger.rib_count() + 2;
    let mut elements = LEAST_ELEMENTS.div_ceil(members).next_power_of_two().max(*ELEMENTS.start());
    let mut coarse = on(elements, near, false)?;
    loop {
        elements *= 2;
        let near = NearForces { contacts: &coarse.contacts, forces_n: &coarse.forces.forces_n };
        let mut fine = on(elements, Some(near), true)?;
        let largest_n = fine.forces.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let pairs = fine.forces.forces_n.iter().zip(&coarse.forces.forces_n);
        let change_n: Vec<f64> = pairs.map(|(fine, coarse)| fine - coarse).collect();
        let is_small = |(change, sigma_n): (&f64, &f64)| {
            change.abs()
                <= (REFINEMENT_SIGMAS * sigma_n).clamp(NEGLIGIBLE * largest_n, REFINEMENT_TOLERANCE * largest_n)
        };
        let is_settled = change_n.iter().zip(&fine.forces.sigmas_n).all(is_small);
        if is_settled || 2 * elements > *ELEMENTS.end() {
            let remains = if is_settled { REMAINS } else { 1.0 };
            fine.add_model_error(change_n.iter().map(|change| remains * change).collect(), Warning::Discretisation);
            return Ok(fine);
        }
        coarse = fine;
    }
}
