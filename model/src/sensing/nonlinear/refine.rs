//! Sensing on ever finer meshes.

use super::{NonlinearEstimate, NonlinearEstimator};
use crate::Finger;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::{ContactQuestion, SensingError};

/// Change of a force between a mesh and one twice as fine at which refinement ends, as a share of the largest force.
const REFINEMENT_TOLERANCE: f64 = 2e-3;
/// Elements a member at which refinement begins and ends.
const ELEMENTS: std::ops::RangeInclusive<usize> = 4..=64;

/// Senses on ever finer meshes until doubling the mesh changes no force by more than 0.2 % of the largest.
///
/// # Errors
/// [`SensingError`] from the estimate on any of the meshes.
pub fn sense_refining(
    finger: &Finger,
    questions: &[ContactQuestion],
    measurement: &Measurement,
    noise_mm: Option<f64>,
) -> Result<NonlinearEstimate, SensingError> {
    let on = |elements| {
        let mesh = Mesh::with_elements_per_member(finger, elements);
        NonlinearEstimator::new(&mesh, questions)?.estimate(measurement, noise_mm)
    };
    let mut elements = *ELEMENTS.start();
    let mut coarse = on(elements)?;
    while elements < *ELEMENTS.end() {
        elements *= 2;
        let fine = on(elements)?;
        let largest = fine.forces.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let pairs = coarse.forces.forces_n.iter().zip(&fine.forces.forces_n);
        let change = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        coarse = fine;
        if change <= REFINEMENT_TOLERANCE * largest {
            break;
        }
    }
    Ok(coarse)
}
