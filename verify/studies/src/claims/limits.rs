//! Claims of the paper on limits of sensing (sec. IV-A, V-C, V-D and VI).

use super::criteria::{
    DIRECTION_SHARE, MUCH_SHARE, NEGLIGIBLE_FORCE_SHARE, WELL_N, at_most_nodes, over_assumptions, statement,
};
use super::experiments::{self, AllForces, Exchanged, largest, range_of};
use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::experiments::speed_error::{SpeedErrorPoint, Task, TimedBy};
use crate::prelude::*;
use crate::study::Study;
use minijinja::context;

/// Assumed lowest and highest friction coefficient for the claim on neglected torques: plastic on steel, and rubber on most materials.
const FRICTIONS: [f64; 2] = [0.2, 0.5];
/// Two assumed ratios of the noise of a displacement to the noise of a coordinate. The first ratio holds for exact undeformed positions, the second
/// ratio for undeformed positions that are measured in an image (sec. V-B).
const NOISE_OF_IMAGES: [f64; 2] = [1.0, std::f64::consts::SQRT_2];
/// Pairs of nodes of the paper's Fig. 12, by increasing distance.
const EXCHANGED: [[usize; 2]; 4] = [[18, 19], [18, 20], [17, 20], [17, 21]];
/// Force on each of four loaded nodes beside one unloaded node, N.
const BESIDE_N: f64 = 0.5;

pub(super) fn claims(study: &Study, words: &Words) -> Result<Vec<Claim>, ClaimError> {
    let finger = &study.finger;
    let mut claims = vec![all_at_once(finger, words)?];
    claims.extend(exchanged(finger, words)?);
    claims.extend([unknown_direction(finger, words)?, wrong_direction(finger, words)?, torque(finger, words)?]);
    // Each claim has only one row. The study of observed grasps tests the claim on unloaded nodes better, so the claim is added here only without
    // that study.
    if study.observations.is_none() {
        claims.push(zero_force(finger, words)?);
    }
    claims.extend(network_time(study, words)?);
    Ok(claims)
}

/// Claim that simultaneous forces at all nodes are not identifiable.
///
/// # Errors
/// [`ClaimError`] if forces on the finger cannot be sensed, or a placeholder in the claim's text has no value.
pub fn all_at_once(finger: &Finger, words: &Words) -> Result<Claim, ClaimError> {
    let AllForces { span, sigmas_n } = experiments::all_forces(finger, CAMERA_NOISE_MM)?;
    let poor = NOISE_OF_IMAGES.map(|images| at_most_nodes(&sigmas_n, |sigma_n| images * sigma_n > WELL_N));
    let verdict = over_assumptions(&poor.map(|(_, most)| statement(most)));
    let numbers = context! {
        sigmas => range_of(&sigmas_n), well_n => WELL_N, poor => poor.map(|(count, _)| count), nodes => sigmas_n.len(),
        noise_mm => CAMERA_NOISE_MM, span,
    };
    words.claim("all-at-once", verdict, numbers)
}

/// Whether the difference of the two shapes grows with the distance between the nodes whose forces are exchanged.
pub fn grows(all: &[Exchanged]) -> bool {
    all.windows(2).all(|pair| pair[0].share < pair[1].share)
}

fn exchanged(finger: &Finger, words: &Words) -> Result<[Claim; 2], ClaimError> {
    let of = |nodes: [usize; 2]| experiments::redistributed(finger, nodes.map(NodeId), CAMERA_NOISE_MM);
    let all: Vec<Exchanged> = EXCHANGED.into_iter().map(of).collect::<Result<_, _>>()?;
    let pairs = EXCHANGED.iter().zip(&all).map(|(nodes, of)| context! { nodes, share => of.share });
    let near = all[0];
    let numbers = context! {
        pairs => pairs.collect::<Vec<_>>(), distance => near.distance, noise_mm => CAMERA_NOISE_MM, much => MUCH_SHARE,
    };
    Ok([
        words.claim("farther", statement(grows(&all)), numbers.clone())?,
        words.claim("unchanged", statement(near.share <= MUCH_SHARE), numbers)?,
    ])
}

/// Claim on the loss of accuracy if the direction of the force is unknown.
///
/// # Errors
/// [`ClaimError`] if forces on the finger cannot be sensed, or a placeholder in the claim's text has no value.
pub fn unknown_direction(finger: &Finger, words: &Words) -> Result<Claim, ClaimError> {
    let across = experiments::unknown_direction(finger, CAMERA_NOISE_MM)?;
    let fails = NOISE_OF_IMAGES.map(|images| at_most_nodes(&across, |sigma_n| images * sigma_n > WELL_N));
    let verdict = over_assumptions(&fails.map(|(_, most)| statement(most)));
    let numbers = context! {
        sigmas => range_of(&across), well_n => WELL_N, works => fails.map(|(count, _)| across.len() - count),
        nodes => across.len(), noise_mm => CAMERA_NOISE_MM,
    };
    words.claim("direction-unknown", verdict, numbers)
}

/// Claim on the loss of accuracy if the assumed direction is wrong by 12.5 degrees, to either side.
///
/// # Errors
/// [`ClaimError`] if forces on the finger cannot be sensed, or a placeholder in the claim's text has no value.
pub fn wrong_direction(finger: &Finger, words: &Words) -> Result<Claim, ClaimError> {
    let errors = |off_deg| -> Result<Vec<f64>, SensingError> {
        Ok(experiments::wrong_direction(finger, off_deg)?.into_iter().map(f64::abs).collect())
    };
    let (tip, base) = (errors(12.5)?, errors(-12.5)?);
    let of_side = |errors: &[f64]| {
        let above = errors.iter().filter(|error| **error > DIRECTION_SHARE).count();
        context! { sizes => range_of(errors), above, nodes => errors.len() }
    };
    let verdict = statement(largest(&tip).max(largest(&base)) <= DIRECTION_SHARE);
    words.claim("direction-wrong", verdict, context! { tip => of_side(&tip), base => of_side(&base) })
}

/// Claim on the loss of accuracy if the torque of friction on a rod is neglected.
///
/// # Errors
/// [`ClaimError`] if forces on the finger cannot be sensed, or a placeholder in the claim's text has no value.
pub fn torque(finger: &Finger, words: &Words) -> Result<Claim, ClaimError> {
    let [low, high] = FRICTIONS.map(|friction| experiments::neglected_torque(finger, friction));
    let (low, high) = (low?, high?);
    let count = high.iter().filter(|error| **error <= NEGLIGIBLE_FORCE_SHARE).count();
    let verdict = over_assumptions(&[low, high.clone()].map(|all| statement(largest(&all) <= NEGLIGIBLE_FORCE_SHARE)));
    let numbers = context! {
        errors => range_of(&high), negligible => NEGLIGIBLE_FORCE_SHARE, count, nodes => high.len(), friction => FRICTIONS,
    };
    words.claim("torque", verdict, numbers)
}

fn zero_force(finger: &Finger, words: &Words) -> Result<Claim, ClaimError> {
    let largest_n = experiments::zero_force(finger, BESIDE_N, CAMERA_NOISE_MM)?;
    let numbers = context! { largest_n, beside_n => BESIDE_N, noise_mm => CAMERA_NOISE_MM };
    words.claim("zero-force", ClaimVerdict::NotTested, numbers)
}

/// Claim on the computation time of the shipped network, measured while the report is computed or with the benchmark library `criterion`.
fn network_time(study: &Study, words: &Words) -> Result<Option<Claim>, ClaimError> {
    let here = |timed_by: &TimedBy| !matches!(timed_by, TimedBy::OtherProgram { .. });
    let point = study.speed_error.iter().find(|point| {
        point.task == Task::SenseOne && point.estimator == Some(EstimatorId::Network) && here(&point.timed_by)
    });
    let claim = |point: &SpeedErrorPoint| {
        let timed_by = match &point.timed_by {
            TimedBy::Report => "this report".to_owned(),
            other => other.to_string(),
        };
        words.claim("network-time", ClaimVerdict::NotTested, context! { us => 1e6 * point.seconds, timed_by })
    };
    point.map(claim).transpose()
}
