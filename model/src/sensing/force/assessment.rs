//! Covariance and identifiability tests of an estimate.

use super::components::resolve;
use super::estimate::{Alternatives, FoundLean, NonlinearEstimate};
use super::largest_explained_rms_mm;
use super::linearised::Seen;
use super::problem::{ForceProblem, State};
use super::unknowns::{IdentifiableLimit, Unknown};
use crate::finger::Plate;
use crate::sensing::residual_test::noise_of;
use crate::sensing::{
    Contact, ContactQuestion, ContactUncertainty, Direction, Estimate, LARGEST_SPAN, ResidualTest, SensingError,
    TWO_SIDED_95, Warning,
};
use nalgebra::DMatrix;

/// The estimated contact. Known or measured positions and directions replace the estimated ones. The angle is reduced to the range from -180 to 180
/// degrees.
fn answered(contact: &Contact, question: &ContactQuestion) -> Contact {
    let angle_deg = question.direction.stated_deg().unwrap_or(contact.angle_deg);
    Contact {
        position: question.position.unwrap_or(contact.position),
        angle_deg: angle_deg - 360.0 * ((angle_deg + 180.0) / 360.0).floor(),
    }
}

/// Estimated lean (angle between force and normal) of a contact. `None` unless the direction is [`Direction::Leaning`]. `covariance_n2` returns the
/// covariance of each force with the force across the contact's direction, N^2. `variance_n2` is the variance of the force across the direction.
fn found_lean(
    problem: &ForceProblem,
    state: &State,
    contact: usize,
    covariance_n2: impl Fn(usize) -> f64,
    variance_n2: f64,
    second_order_n2: f64,
) -> Option<FoundLean> {
    let Direction::Leaning(lean) = problem.questions[contact].direction else { return None };
    let force_n = state.forces_n[contact];
    let deg_per_n = (1.0 / force_n).to_degrees();
    Some(FoundLean {
        contact,
        lean_deg: lean.mean_deg(force_n) + state.nuisances.further_leans_deg[contact],
        sd_deg: variance_n2.sqrt() * deg_per_n.abs(),
        second_order_n2,
        by_lean_n: (0..problem.questions.len()).map(|j| covariance_n2(j) / (variance_n2 * deg_per_n)).collect(),
    })
}

/// Refuses unknown positions and directions whose standard deviation is too large. Those of a measured contact are at least as certain as measured. With
/// `profiled`, a profile has decided on the position.
///
/// # Errors
/// [`SensingError::Undetermined`] for the first position or direction.
pub(super) fn require_determined(
    problem: &ForceProblem,
    estimate: &NonlinearEstimate,
    profiled: bool,
) -> Result<(), SensingError> {
    for unknown in problem.unknowns.iter() {
        let Some(limit) = unknown.limit(&problem.questions, problem.finger()) else { continue };
        let IdentifiableLimit { what, contact, sigma: largest, unit } = limit;
        let ContactUncertainty { position_sd_mm, direction_sd_deg, .. } = estimate.uncertainties[contact];
        let sigma = match unknown {
            Unknown::Across(_) => direction_sd_deg,
            _ => position_sd_mm.filter(|_| !profiled),
        };
        if let Some(sigma) = sigma.filter(|sigma| *sigma > largest) {
            return Err(SensingError::Undetermined { what, contact: contact + 1, sigma, unit });
        }
    }
    Ok(())
}

/// Computes the standard deviations of an estimate, and refuses estimates whose unknowns are not identifiable.
///
/// # Errors
/// [`SensingError`] if an unknown is not identifiable, or the shape does not explain the measurement.
pub(super) fn assess(
    problem: &ForceProblem,
    state: &mut State,
    Seen { measurement, marker_noise_mm }: Seen,
    steps: usize,
) -> Result<NonlinearEstimate, SensingError> {
    let (coordinates, count) = (measurement.coordinate_count(), problem.unknowns.len());
    let misfit = problem.misfit(state, measurement);
    let residual_rms_mm = (misfit / coordinates as f64).sqrt();
    let moved: f64 = measurement.markers().iter().map(|marker| marker.displacement.norm_squared()).sum();
    let moved_rms_mm = (moved / coordinates as f64).sqrt();
    if marker_noise_mm
        .is_some_and(|marker_noise_mm| residual_rms_mm > largest_explained_rms_mm(marker_noise_mm, moved_rms_mm))
    {
        return Err(SensingError::Unexplained { residual_rms_mm, moved_rms_mm });
    }
    let degrees_of_freedom = coordinates + problem.known_count() - count;
    let test = ResidualTest::of_measurement(measurement, marker_noise_mm, misfit, degrees_of_freedom);
    // A residual that the stated noise does not explain adds to the uncertainty.
    let trusted_noise_mm = noise_of(test, marker_noise_mm, misfit, degrees_of_freedom);
    problem.rescale(state);
    let parts = state.linearised.singular_parts(measurement)?;
    let span = parts.span();
    if span.is_nan() || span > LARGEST_SPAN {
        let weakest = problem.unknowns[parts.weakest().iamax()].contact().unwrap_or_default() + 1;
        return Err(SensingError::IllConditioned { span, limit: LARGEST_SPAN, weakest });
    }
    let scales = &state.linearised.scales;
    let linear =
        |i: usize, j: usize| scales[i] * scales[j] * parts.covariance(i, j) * trusted_noise_mm * trusted_noise_mm;
    // A force b across the direction adds b^2 / (2 f) to the force f, to second order. If the force b has the standard deviation s, the mean
    // square of b^2 / (2 f) is 3 s^4 / (4 f^2). Terms of higher order are negligible if the direction is known to within some degrees.
    let by_direction = |i: usize| {
        let across = problem.unknowns.iter().position(|unknown| *unknown == Unknown::Across(i));
        across
            .filter(|_| !problem.is_normal_measured(i))
            .map_or(0.0, |j| 0.75 * (linear(j, j) / state.forces_n[i]).powi(2))
    };
    let covariance = |i: usize, j: usize| linear(i, j) + if i == j { by_direction(i) } else { 0.0 };
    let mut uncertainties = vec![ContactUncertainty::default(); problem.questions.len()];
    for (j, unknown) in problem.unknowns.iter().enumerate() {
        match *unknown {
            Unknown::Position(i) => {
                let (sd_mm, length_mm) = (linear(j, j).sqrt(), problem.finger().plate_length_mm(Plate::Front));
                let limits_mm = state.contacts[i]
                    .position_mm(problem.finger())
                    .map(|s_mm| [-1.0, 1.0].map(|sign| (s_mm + sign * TWO_SIDED_95 * sd_mm).clamp(0.0, length_mm)));
                (uncertainties[i].position_sd_mm, uncertainties[i].position_interval_mm) = (Some(sd_mm), limits_mm);
            }
            Unknown::Across(i) => {
                uncertainties[i].direction_sd_deg = Some((linear(j, j).sqrt() / state.forces_n[i].abs()).to_degrees());
            }
            _ => {}
        }
    }
    let leans = problem.unknowns.iter().enumerate().filter_map(|(k, unknown)| match *unknown {
        Unknown::Across(i) => found_lean(problem, state, i, |j| linear(j, k), linear(k, k), by_direction(i)),
        _ => None,
    });
    let mut estimate = NonlinearEstimate {
        leans: leans.collect(),
        forces: Estimate {
            forces_n: state.forces_n.clone(),
            sigmas_n: (0..problem.questions.len()).map(|i| covariance(i, i).sqrt()).collect(),
            covariance_n2: DMatrix::from_fn(problem.questions.len(), problem.questions.len(), covariance),
            sides_n: None,
            method_error_n: vec![0.0; problem.questions.len()],
            measured: None,
            alternatives: Vec::new(),
            trusted_noise_mm,
            warning: test.filter(ResidualTest::contradicts).map(Warning::Residual),
            residual_rms_mm,
            singular_values: parts.descending(),
        },
        contacts: state
            .contacts
            .iter()
            .zip(&problem.questions)
            .map(|(contact, question)| answered(contact, question))
            .collect(),
        steps,
        uncertainties,
        alternatives: Alternatives::default(),
    };
    if (0..problem.questions.len()).any(|i| problem.is_normal_measured(i)) {
        resolve(problem, state, measurement, &mut estimate)?;
    }
    // A profile over the position decides on a weakly known position.
    if !problem.is_weak(measurement) {
        require_determined(problem, &estimate, false)?;
    }
    Ok(estimate)
}
