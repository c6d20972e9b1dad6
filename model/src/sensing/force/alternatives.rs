//! Other forces that explain a measurement as well as an estimate does: they refuse the estimate or widen its standard deviations.

use super::estimate::{Alternatives, NonlinearEstimate};
use super::position_profile::{PositionProfile, at, interval, spread, tail_sd};
use super::{AS_GOOD, CURVED};
use crate::finger::Finger;
use crate::frame::FrameMotion;
use crate::sensing::{Estimate, SensingError};
use nalgebra::DVector;

/// The forces of two minima count as different if one force differs by more than this number of standard deviations.
const ANOTHER_ANSWER_SIGMAS: f64 = 5.0;
/// Without noise, forces count as equal up to a difference of this share of the largest force.
const SAME_ANSWER: f64 = 1e-3;
/// An estimate is confirmed if it fits at least this number of measured coordinates per force.
const CONFIRMING_COORDINATES: usize = 4;

/// Widens an estimate by other forces and positions that explain its measurement. They may be those of a coarser mesh.
pub(super) fn widen_by(alternatives: &Alternatives, estimate: &mut NonlinearEstimate, finger: &Finger) {
    match &alternatives.profile {
        Some(profile) => widen_by_profile(profile, estimate, finger),
        None => {
            widen_by_rivals(estimate, &alternatives.minima);
            widen_by_positions(estimate, &alternatives.others);
        }
    }
}

/// Widens the standard deviations of forces, position and direction, and sets their intervals. The profile may be that of a coarser mesh.
fn widen_by_profile(profile: &PositionProfile, estimate: &mut NonlinearEstimate, finger: &Finger) {
    let found_mm = estimate.contacts[profile.contact].position_mm(finger).unwrap_or(f64::NAN);
    let at_found = profile.ranges.iter().find_map(|range| at(range, found_mm));
    for j in 0..estimate.forces.forces_n.len() {
        let force_n = estimate.forces.forces_n[j];
        // Error of the mesh of the profile.
        let shift_n = at_found.as_ref().map_or(0.0, |at_found| force_n - at_found.forces_n[j]);
        let mut mixture = PositionProfile::force(&profile.ranges, j);
        mixture.iter_mut().for_each(|(_, mean_n, _)| *mean_n += shift_n);
        let limits_n = interval(&mixture, 0.95);
        let tail_n = if profile.is_weak { tail_sd(&mixture, force_n) } else { 0.0 };
        estimate.forces.widen_to(j, spread(&mixture, force_n).max(tail_n), limits_n);
    }
    if profile.ranges.len() > 1 {
        estimate.forces.alternatives = profile.alternatives();
    }
    let i = profile.contact;
    let position = PositionProfile::position(&profile.ranges);
    let [from_mm, to_mm] = interval(&position, 0.95);
    let uncertainty = &mut estimate.uncertainties[i];
    uncertainty.position_sd_mm = Some(spread(&position, found_mm));
    uncertainty.position_interval_mm = Some([from_mm.min(found_mm), to_mm.max(found_mm)]);
    if let Some(sd_deg) = &mut uncertainty.direction_sd_deg {
        let angle = PositionProfile::mixture(&profile.ranges, |point, _| (point.angle_deg, point.angle_sd_deg));
        *sd_deg = spread(&angle, estimate.contacts[i].angle_deg);
    }
}

/// Refuses an estimate with a significant force if zero forces explain the data equally well. Near buckling, a small force causes large
/// displacements, so noise may be mistaken for a force. Both misfits are in mm^2.
///
/// # Errors
/// [`SensingError::Ambiguous`] for the first force that differs significantly from zero.
pub(super) fn check_against_nothing(
    estimate: &NonlinearEstimate,
    misfit: f64,
    misfit_at_rest: f64,
) -> Result<(), SensingError> {
    let Estimate { forces_n, sigmas_n, trusted_noise_mm, .. } = &estimate.forces;
    if misfit_at_rest - misfit > AS_GOOD * trusted_noise_mm * trusted_noise_mm {
        return Ok(());
    }
    let claimed = (0..forces_n.len()).find(|&i| forces_n[i].abs() > ANOTHER_ANSWER_SIGMAS * sigmas_n[i]);
    claimed.map_or(Ok(()), |i| Err(SensingError::Ambiguous { contact: i + 1, force_n: forces_n[i], other_n: 0.0 }))
}

/// Refuses an estimate if other forces explain the data equally well, even if the misfit of the other forces is no minimum. For a linear finger,
/// forces whose misfit exceeds the smallest misfit by at most [`AS_GOOD`] noise variances lie within three standard deviations of the estimate.
/// `others` lists misfits, mm^2, and forces, N.
///
/// # Errors
/// [`SensingError::Ambiguous`] for the first force that differs.
pub(super) fn check_other_forces<'s>(
    estimate: &NonlinearEstimate,
    misfit: f64,
    others: impl Iterator<Item = (f64, &'s Vec<f64>)>,
) -> Result<(), SensingError> {
    for (other_misfit, other_n) in others {
        is_confirmed_by(estimate, other_n, other_misfit - misfit)?;
    }
    Ok(())
}

/// Refuses an estimate of several forces if there are no redundant coordinates and the estimate differs from the forces that fit the linear
/// finger. Without redundant coordinates, many equilibria may explain the measurement exactly. If the search started from the forces that fit the
/// linear finger, these forces are the first entry of `starts`.
///
/// # Errors
/// [`SensingError::Unconfirmed`] if the estimate is refused.
pub(super) fn check_unconfirmed(
    estimate: &NonlinearEstimate,
    coordinates: usize,
    starts: &[(Vec<f64>, FrameMotion)],
) -> Result<(), SensingError> {
    let count = estimate.forces.forces_n.len();
    let is_far = starts.first().is_some_and(|(linear_n, _)| other_answer(estimate, linear_n).is_some());
    if count > 1 && coordinates <= count && is_far { Err(SensingError::Unconfirmed) } else { Ok(()) }
}

/// Whether the forces `other_n`, N, equal the forces of this estimate within its standard deviations. The misfit of `other_n` exceeds the misfit
/// of this estimate by `excess`, mm^2.
///
/// # Errors
/// [`SensingError::Ambiguous`] if the other forces differ and explain the data equally well.
fn is_confirmed_by(estimate: &NonlinearEstimate, other_n: &[f64], excess: f64) -> Result<bool, SensingError> {
    match other_answer(estimate, other_n) {
        Some(i) if excess <= AS_GOOD * estimate.forces.trusted_noise_mm.powi(2) => {
            let (force_n, other_n) = (estimate.forces.forces_n[i], other_n[i]);
            Err(SensingError::Ambiguous { contact: i + 1, force_n, other_n })
        }
        other => Ok(other.is_none()),
    }
}

/// Index of the first force in `other_n`, N, that differs from this estimate's force by more than its standard deviation allows.
fn other_answer(estimate: &NonlinearEstimate, other_n: &[f64]) -> Option<usize> {
    let Estimate { forces_n, sigmas_n, .. } = &estimate.forces;
    let largest = forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let same = |i: usize| f64::max(ANOTHER_ANSWER_SIGMAS * sigmas_n[i], SAME_ANSWER * largest);
    (0..forces_n.len()).find(|&i| (forces_n[i] - other_n[i]).abs() > same(i))
}

/// Refuses an estimate if another minimum explains the data equally well. Also refuses an estimate from few coordinates if `near` is `false` and
/// no second minimum confirms the estimate. `near` is `true` if the minimum is locally unique or the equilibria were scanned. `minima` lists
/// misfit, mm^2, and forces, N, of each minimum.
///
/// # Errors
/// [`SensingError::Ambiguous`] for another minimum, [`SensingError::Unconfirmed`] for an estimate that nothing confirms.
pub(super) fn check_rivals(
    estimate: &NonlinearEstimate,
    misfit: f64,
    minima: &[(f64, Vec<f64>)],
    near: bool,
    coordinates: usize,
) -> Result<(), SensingError> {
    let mut confirmations = 0;
    for (other_misfit, other_n) in minima {
        confirmations += usize::from(is_confirmed_by(estimate, other_n, other_misfit - misfit)?);
    }
    // One of the minima is the estimate, so a confirmation needs a second minimum. A fit of many coordinates also confirms the estimate.
    let confirmed =
        near || confirmations >= 2 || coordinates >= CONFIRMING_COORDINATES * estimate.forces.forces_n.len();
    if confirmed { Ok(()) } else { Err(SensingError::Unconfirmed) }
}

/// Widens the covariance by another minimum with forces that count as equal, if the minimum explains the data equally well and is separate. The forces
/// of the other minimum are as likely as the ratio of the likelihoods states. The minimum that widens most counts. `minima` lists the growth of the
/// misfit, mm^2, and the forces, N, of each minimum.
fn widen_by_rivals(estimate: &mut NonlinearEstimate, minima: &[(f64, Vec<f64>)]) {
    let variance_mm2 = estimate.forces.trusted_noise_mm.powi(2);
    let Estimate { forces_n, sigmas_n, .. } = &estimate.forces;
    let off = |(growth_mm2, other_n): &(f64, Vec<f64>)| {
        let likelihood = (-0.5 * growth_mm2 / variance_mm2).exp().min(1.0);
        DVector::from_iterator(
            forces_n.len(),
            forces_n.iter().zip(other_n).map(|(force_n, other_n)| likelihood.sqrt() * (other_n - force_n)),
        )
    };
    let size =
        |off: &DVector<f64>| off.iter().zip(sigmas_n).map(|(off_n, sigma_n)| (off_n / sigma_n).powi(2)).sum::<f64>();
    let largest = minima.iter().map(off).filter(|off| size(off).is_finite()).max_by(|a, b| size(a).total_cmp(&size(b)));
    let Some(off) = largest else { return };
    estimate.forces.add_common_error(off.as_slice());
}

/// Widens standard deviations if the misfit grows less towards other forces than it does for a linear finger, for which it grows by the squared number of
/// standard deviations. A position may then change far, and the forces with it. `others` lists the growth of the misfit, mm^2, and the forces, N, for
/// other positions.
fn widen_by_positions(estimate: &mut NonlinearEstimate, others: &[(f64, Vec<f64>)]) {
    let variance_mm2 = estimate.forces.trusted_noise_mm.powi(2);
    for (growth_mm2, other_n) in others {
        let growth = growth_mm2 / variance_mm2;
        if growth > AS_GOOD || growth.is_nan() {
            continue;
        }
        let growth = growth.max(1.0);
        for (i, other_n) in other_n.iter().enumerate() {
            let needed_n2 = (other_n - estimate.forces.forces_n[i]).powi(2) / growth;
            let stated_n2 = estimate.forces.sigmas_n[i].powi(2);
            if needed_n2 <= stated_n2 * CURVED * CURVED {
                continue;
            }
            let further_n2 = needed_n2 - stated_n2;
            estimate.forces.add_variance(i, further_n2);
        }
    }
}
