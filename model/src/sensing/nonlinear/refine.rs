//! Sensing on ever finer meshes.

use super::{NonlinearEstimate, NonlinearEstimator};
use crate::Finger;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::{ContactQuestion, Meeting, SensingError, Warning};

/// Change of a force between a mesh and one twice as fine at which refinement ends, as a share of the largest force.
const REFINEMENT_TOLERANCE: f64 = 2e-3;
/// Errors fall with the square of the element length: of the last change, a third is still to come (Richardson).
const REMAINS: f64 = 1.0 / 3.0;
/// Elements a member at which refinement begins and ends.
const ELEMENTS: std::ops::RangeInclusive<usize> = 4..=64;
/// Refinement begins with this number of elements at least, so that the mesh of a finger of few ribs distinguishes minima as a fine one does.
const LEAST_ELEMENTS: usize = 40;

/// Senses on ever finer meshes until doubling the mesh changes no force by more than 0.2 % of the largest; what the last
/// mesh still gets wrong is part of the standard deviations.
///
/// # Errors
/// [`SensingError`] from the estimate on any of the meshes.
pub fn sense_refining<'o>(
    finger: &Finger,
    questions: &[ContactQuestion],
    meeting: impl Into<Meeting<'o>>,
    measurement: &Measurement,
    noise_mm: Option<f64>,
) -> Result<NonlinearEstimate, SensingError> {
    let Meeting { pad, object } = meeting.into();
    // A finer mesh begins at the forces of the coarser one.
    let on = |elements, near: Option<&NonlinearEstimate>| {
        let mesh = Mesh::with_elements_per_member(finger, elements);
        let mut estimator = NonlinearEstimator::new(&mesh, questions)?.with_pad(pad).with_object(object);
        if let Some(near) = near {
            estimator.hold_at(&near.forces.forces_n);
            estimator.reset();
        }
        estimator.estimate(measurement, noise_mm)
    };
    let members = 3 * finger.rib_count() + 2;
    let mut elements = LEAST_ELEMENTS.div_ceil(members).next_power_of_two().max(*ELEMENTS.start());
    let mut coarse = on(elements, None)?;
    loop {
        elements *= 2;
        let mut fine = on(elements, Some(&coarse))?;
        let largest_n = fine.forces.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let pairs = fine.forces.forces_n.iter().zip(&coarse.forces.forces_n);
        let change_n: Vec<f64> = pairs.map(|(fine, coarse)| fine - coarse).collect();
        let settled = change_n.iter().all(|change| change.abs() <= REFINEMENT_TOLERANCE * largest_n);
        if settled || 2 * elements > *ELEMENTS.end() {
            fine.add_model_error(change_n.iter().map(|change| REMAINS * change).collect(), Warning::Discretisation);
            return Ok(fine);
        }
        coarse = fine;
    }
}
