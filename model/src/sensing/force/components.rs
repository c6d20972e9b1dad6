//! Forces along and across measured normals, with their covariance.

use super::estimate::NonlinearEstimate;
use super::problem::{ForceProblem, State};
use super::unknowns::Unknown;
use crate::measurement::Measurement;
use crate::sensing::{Direction, MeasuredForces, SensingError};
use nalgebra::DMatrix;

/// Resolves the forces of an estimate along and across the measured normals, and replaces the covariance of its forces. The covariance includes what
/// remains uncertain of positions, directions and friction.
///
/// The effect of a lean on the markers is proportional to the force. In the covariance, the root mean square of the force replaces the estimated force;
/// the difference matters for small forces. The root mean square is the square root of the sum of the squared estimate and the variance.
///
/// # Errors
/// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
pub(super) fn resolve(
    problem: &ForceProblem,
    state: &mut State,
    measurement: &Measurement,
    estimate: &mut NonlinearEstimate,
) -> Result<(), SensingError> {
    let count = problem.questions.len();
    let rms_n = |i: usize| state.forces_n[i].hypot(estimate.forces.sigmas_n[i]);
    let rms_n: Vec<f64> = (0..count).map(rms_n).collect();
    let rows = state.linearised.prior_rows.clone();
    for row in &mut state.linearised.prior_rows {
        if let Unknown::Across(i) = problem.unknowns[row.index]
            && problem.is_normal_measured(i)
        {
            row.by_unknown *= (state.forces_n[i] / rms_n[i]).abs();
        }
    }
    let parts = state.linearised.singular_parts(measurement);
    state.linearised.prior_rows = rows;
    let (parts, scales) = (parts?, &state.linearised.scales);
    let trusted_noise_mm = estimate.forces.trusted_noise_mm;
    let unknowns = problem.unknowns.len();
    let covariance = DMatrix::from_fn(unknowns, unknowns, |i, j| {
        scales[i] * scales[j] * parts.covariance(i, j) * trusted_noise_mm * trusted_noise_mm
    });
    // The force across is the product of the force along and of the tangent of the lean.
    let tangent = |i: usize| if problem.is_normal_measured(i) { state.nuisances.tangent(i) } else { 0.0 };
    let mut components = DMatrix::zeros(2 * count, unknowns);
    for (j, unknown) in problem.unknowns.iter().enumerate() {
        match *unknown {
            Unknown::Force(i) => (components[(i, j)], components[(count + i, j)]) = (1.0, tangent(i)),
            Unknown::Across(i) if problem.is_normal_measured(i) => components[(count + i, j)] = 1.0,
            _ => {}
        }
    }
    let covariance_n2 = &components * covariance * components.transpose();
    estimate.forces.covariance_n2 = covariance_n2.view((0, 0), (count, count)).into_owned();
    let across_n: Vec<f64> = (0..count).map(|i| state.forces_n[i] * tangent(i)).collect();
    for (i, question) in problem.questions.iter().enumerate() {
        let Direction::Measured(normal) = question.direction else { continue };
        // If the measured normal is wrong, a share of the friction force counts as force along the normal. The share is computed from at least the
        // upper bound of the friction force. Noise could make the estimated friction force too small, and a standard deviation computed from this
        // estimate would then be too small.
        let across_n2 = across_n[i].powi(2) + covariance_n2[(count + i, count + i)];
        let share_n = normal.sd_rad * across_n2.sqrt().max(normal.friction * state.forces_n[i].abs());
        estimate.forces.sigmas_n[i] = covariance_n2[(i, i)].sqrt().hypot(share_n);
        estimate.forces.covariance_n2[(i, i)] += share_n * share_n;
    }
    estimate.forces.measured = Some(MeasuredForces { across_n, covariance_n2 });
    Ok(())
}
