//! Checks whether standard deviations that follow from linearisation of the finger at the estimate are valid.

use super::estimate::NonlinearEstimate;
use super::marker_motion::Posed;
use super::minima::MANY_COORDINATES;
use super::problem::{ForceProblem, State};
use super::states::state_under;
use crate::Vector;
use crate::measurement::Measurement;
use crate::sensing::SensingError;
use crate::statics::StaticsError;
use nalgebra::DVectorView;

/// A force with at most this relative standard deviation needs no check.
const WELL_KNOWN: f64 = 0.3;
/// A change of a force by one standard deviation moves the markers. The force is refused if the motion of the markers differs from the linearised
/// motion by more than this share. See Bates and Watts, Nonlinear Regression Analysis and Its Applications, ch. 7, on the intrinsic curvature.
const LARGEST_DEPARTURE: f64 = 0.5;

/// An axis of the confidence region needs no check if the standard deviation along the axis is at most this share of the largest force. Without
/// noise, the ends of such an axis differ only by rounding.
const STRAIGHT: f64 = 1e-6;
/// The ends of the confidence region are checked at this distance from the estimate, in standard deviations.
const REACH: f64 = 3.0;
/// A force is not identifiable if the misfit (sum of squared residuals) grows by less than this number of noise variances towards an end of the
/// confidence region. For a linear finger, the misfit grows by 9 noise variances towards each end.
const LEAST_GROWTH: f64 = 1.0;

/// Widens standard deviations if the misfit (sum of squared residuals) grows less towards the ends of the confidence region than it does for a
/// linear finger. The function applies only if few coordinates are measured and all unknowns are forces at known contacts.
///
/// # Errors
/// [`SensingError::Undetermined`] if the misfit hardly grows.
pub(super) fn widen_by_curvature(
    problem: &mut ForceProblem,
    state: &State,
    measurement: &Measurement,
    estimate: &mut NonlinearEstimate,
) -> Result<(), SensingError> {
    let trusted_noise_mm = estimate.forces.trusted_noise_mm;
    let is_of_forces =
        problem.unknowns.len() == problem.questions.len() && problem.object.is_none() && !problem.follows_plate();
    if !is_of_forces
        || measurement.coordinate_count() >= MANY_COORDINATES[0]
        || !(trusted_noise_mm > 0.0 && trusted_noise_mm.is_finite())
    {
        return Ok(());
    }
    let least_mm2 = problem.misfit(state, measurement);
    let axes = estimate.forces.covariance_n2.clone().symmetric_eigen();
    for (i, (variance_n2, axis)) in axes.eigenvalues.iter().zip(axes.eigenvectors.column_iter()).enumerate() {
        let sd_n = variance_n2.max(0.0).sqrt();
        if sd_n <= STRAIGHT * state.forces_n.iter().fold(0.0, |largest: f64, force_n| largest.max(force_n.abs())) {
            continue;
        }
        // The end with the smaller growth of the misfit counts, because the true force may be near this end.
        let mut widened = 0.0_f64;
        for reach in [-REACH, REACH] {
            let forces_n: Vec<f64> = state.forces_n.iter().zip(&axis).map(|(f, a)| f + reach * sd_n * a).collect();
            // Forces without an equilibrium are impossible.
            let Some(end) = state_under(problem, &state.contacts, &forces_n, Some(state)) else { continue };
            let shape = Posed { nuisances: &state.nuisances, ..end.posed() };
            // The confidence region may be curved, with a smaller misfit beside the axis.
            let beside = axes.eigenvectors.column_iter().enumerate().filter(|(j, _)| *j != i);
            let explained = |(_, other): (usize, DVectorView<f64>)| {
                end.linearised.explained_along(other.iter().copied(), shape, measurement)
            };
            let misfit_mm2 =
                problem.misfit_of(shape, &state.linearised, measurement) - beside.map(explained).sum::<f64>();
            let growth = (misfit_mm2 - least_mm2) / (trusted_noise_mm * trusted_noise_mm);
            if growth < LEAST_GROWTH {
                let contact = axis.iamax();
                let sigma = estimate.forces.sigmas_n[contact];
                return Err(SensingError::Undetermined { what: "the force", contact: contact + 1, sigma, unit: "N" });
            }
            widened = widened.max(REACH * REACH / growth - 1.0);
        }
        let more = widened * variance_n2;
        for (sigma_n, share) in estimate.forces.sigmas_n.iter_mut().zip(&axis) {
            *sigma_n = sigma_n.hypot(more.sqrt() * share);
        }
        estimate.forces.add_covariance(&(axis * axis.transpose() * more));
    }
    Ok(())
}

/// Refuses a force if changing the force by one standard deviation does not move the markers linearly, or leads to forces without equilibrium.
/// For example, a force along a plate hardly moves any marker until the plate buckles.
///
/// # Errors
/// [`SensingError::Undetermined`] for the first force that is refused.
pub(super) fn require_linear_range(
    problem: &mut ForceProblem,
    state: &State,
    measurement: &Measurement,
    sigmas_n: &[f64],
) -> Result<(), SensingError> {
    for (i, &sigma) in sigmas_n.iter().enumerate() {
        if !sigma.is_finite() || sigma <= WELL_KNOWN * state.forces_n[i].abs() {
            continue;
        }
        for change_n in [-sigma, sigma] {
            if !answers_linearly(problem, state, measurement, i, change_n)? {
                return Err(SensingError::Undetermined { what: "the force", contact: i + 1, sigma, unit: "N" });
            }
        }
    }
    Ok(())
}

/// Whether the markers follow a change `change_n` of the force at `contact`, N, as the linearised finger predicts.
fn answers_linearly(
    problem: &mut ForceProblem,
    state: &State,
    measurement: &Measurement,
    contact: usize,
    change_n: f64,
) -> Result<bool, SensingError> {
    let mut changed = state.forces_n.clone();
    changed[contact] += change_n;
    let loads = state.loads_under(problem.mesh, &problem.questions, &changed)?;
    let motion = match problem.statics.shifted(&state.motion, &state.loads, &loads) {
        Ok(equilibrium) => equilibrium.motion,
        Err(StaticsError::NoEquilibrium { .. }) => return Ok(false),
        Err(other) => return Err(other.into()),
    };
    let (mut departure, mut linear) = (0.0, 0.0);
    for marker in measurement.markers() {
        // Key nodes are the first nodes of a frame.
        let node = marker.node.0 - 1;
        let moved: Vector = motion.displacements[node] - state.motion.displacements[node];
        let expected = state.linearised.rate(contact, node) * change_n;
        departure += (moved - expected).norm_squared();
        linear += expected.norm_squared();
    }
    Ok(departure <= LARGEST_DEPARTURE * LARGEST_DEPARTURE * linear)
}
