//! Limits that the paper states (sec. IV-A, V-C, V-D and VI).

use super::criteria::{
    DIRECTION_SHARE, MUCH_SHARE, NEGLIGIBLE_FORCE_SHARE, WELL_N, at_most_nodes, over_assumptions, statement,
};
use super::experiments::{self, Exchanged, largest, range_of};
use super::{Claim, ClaimVerdict, between, claim, newtons, percent};
use crate::estimators::EstimatorId;
use crate::experiments::speed_error::{Task, TimedBy};
use crate::settings::CAMERA_NOISE_MM;
use crate::study::Study;
use finray_model::sensing::SensingError;
use finray_model::{Finger, NodeId};

/// Friction between which neglected torques are judged: plastic on steel to rubber on most things.
const FRICTIONS: [f64; 2] = [0.2, 0.5];
/// Noise of a displacement over that of a camera's coordinate: where undeformed positions are exact, and where they are measured in an
/// image too, as sec. V-B describes.
const NOISE_OF_IMAGES: [f64; 2] = [1.0, std::f64::consts::SQRT_2];
/// Pairs of nodes of the paper's Fig. 12, from near to far.
const EXCHANGED: [[usize; 2]; 4] = [[18, 19], [18, 20], [17, 20], [17, 21]];
/// Force on each of four nodes beside one that nothing touches, N.
const BESIDE_N: f64 = 0.5;

pub(super) fn claims(study: &Study) -> Result<Vec<Claim>, SensingError> {
    let finger = &study.finger;
    let mut claims = vec![all_at_once(finger)?];
    claims.extend(exchanged(finger)?);
    claims.extend([unknown_direction(finger)?, wrong_direction(finger)?, torque(finger)?, zero_force(finger)?]);
    claims.extend(network_time(study));
    Ok(claims)
}

/// Whether forces of all nodes at once can be told apart.
pub fn all_at_once(finger: &Finger) -> Result<Claim, SensingError> {
    let all = experiments::all_forces(finger, CAMERA_NOISE_MM)?;
    let poor = NOISE_OF_IMAGES.map(|images| at_most_nodes(&all.sigmas_n, |sigma_n| images * sigma_n > WELL_N));
    let [(count, _), (count_of_two, _)] = poor;
    Ok(claim(
        "\"to regard both node rotations and external forces as unknowns and use least-square optimization ... the force sensing accuracy is poor\", \
         \"highly sensitive to the node displacement errors\" (sec. IV-A)",
        "no figure",
        format!(
            "standard deviation {}; above {} at {count} of {} nodes (at {count_of_two} if undeformed positions are measured too)",
            between(range_of(&all.sigmas_n), newtons),
            newtons(WELL_N),
            all.sigmas_n.len()
        ),
        format!(
            "linear least squares for a normal force at every contact node at once, rotations free, {CAMERA_NOISE_MM} mm noise; singular values \
             span {:.0}. Which forces the paper sought is not said",
            all.span
        ),
        format!(
            "poor: above {} (a tenth of 3 N) at more than half of the nodes, with one noisy image and with two",
            newtons(WELL_N)
        ),
        over_assumptions(&poor.map(|(_, most)| statement(most))),
    ))
}

/// Whether shapes differ the more, the farther two nodes are apart.
pub fn grows(all: &[Exchanged]) -> bool {
    all.windows(2).all(|pair| pair[0].share < pair[1].share)
}

fn exchanged(finger: &Finger) -> Result<[Claim; 2], SensingError> {
    let of = |nodes: [usize; 2]| experiments::redistributed(finger, nodes.map(NodeId), CAMERA_NOISE_MM);
    let all: Vec<Exchanged> = EXCHANGED.into_iter().map(of).collect::<Result<_, _>>()?;
    let listed: Vec<String> =
        EXCHANGED.iter().zip(&all).map(|([a, b], of)| format!("{} at {a} and {b}", percent(of.share))).collect();
    let distance = all.first().map_or(f64::NAN, |near| near.distance);
    Ok([
        claim(
            "\"the farther the distance is, the larger the differences become, as shown in Fig. 12(b)-(d)\" (sec. V-C)",
            "no figure",
            listed.join(", "),
            "co-rotational finger, (1, 4) N against (4, 1) N; largest difference over the largest displacement",
            "growing from pair to pair",
            statement(grows(&all)),
        ),
        claim(
            "\"when the two contacting nodes are close to each other ... the overall deformation of the finger remains nearly unchanged\" from (1, 4) N \
             to (4, 1) N, nodes 18 and 19 (sec. V-C, Fig. 12(a))",
            "no figure",
            format!("{} of the largest displacement", listed.first().map_or("-", String::as_str)),
            format!(
                "the same. It is {distance:.0} times the noise (Mahalanobis distance of the 23 free nodes' displacements, {CAMERA_NOISE_MM} mm a \
                 coordinate), so an estimator with the right model can separate the two; how well stands with Table II"
            ),
            format!("no more than {}, as above for \"without losing much accuracy\"", percent(MUCH_SHARE)),
            statement(all.first().is_some_and(|near| near.share <= MUCH_SHARE)),
        ),
    ])
}

/// What a force of unknown direction costs.
pub fn unknown_direction(finger: &Finger) -> Result<Claim, SensingError> {
    let across = experiments::unknown_direction(finger, CAMERA_NOISE_MM)?;
    let fails = NOISE_OF_IMAGES.map(|images| at_most_nodes(&across, |sigma_n| images * sigma_n > WELL_N));
    let [works, works_of_two] = fails.map(|(count, _)| across.len() - count);
    Ok(claim(
        "\"the proposed deformation-based force sensing method will not work if both the force direction and amplitude are unknown\" (sec. V-C, \
         Fig. 13)",
        "no figure",
        format!(
            "standard deviation of the force across the normal {}; at most {} at {works} of {} nodes (at {works_of_two} if undeformed positions \
             are measured too)",
            between(range_of(&across), newtons),
            newtons(WELL_N),
            across.len()
        ),
        format!(
            "linear least squares for both components at one node, nodes 14 to 24, {CAMERA_NOISE_MM} mm noise, model known. By size of the force: \
             the section on unknown directions, where small forces are mostly refused"
        ),
        format!(
            "above {} (a tenth of 3 N) at more than half of the nodes, with one noisy image and with two",
            newtons(WELL_N)
        ),
        over_assumptions(&fails.map(|(_, most)| statement(most))),
    ))
}

/// What a direction costs that is assumed wrong, to either side.
pub fn wrong_direction(finger: &Finger) -> Result<Claim, SensingError> {
    let sides = [12.5, -12.5].map(|off_deg| experiments::wrong_direction(finger, off_deg));
    let [tip, base] = sides;
    let (tip, base) = (tip?, base?);
    let above = |errors: &[f64]| errors.iter().filter(|error| error.abs() > DIRECTION_SHARE).count();
    let sizes =
        |errors: &[f64]| between(range_of(&errors.iter().map(|error| error.abs()).collect::<Vec<_>>()), percent);
    Ok(claim(
        "\"the maximum error caused by assuming the grasping force direction to be coincident with the sensor-axis direction is only about \
         1-cos(12.5 deg)=2.4%, which is negligible\" (sec. V-C)",
        "2.4 %",
        format!(
            "towards the tip {} (above 2.4 % at {} of {} nodes), towards the base {} (at {} of {})",
            sizes(&tip),
            above(&tip),
            tip.len(),
            sizes(&base),
            above(&base),
            base.len()
        ),
        "linear finger and model, any force at one of nodes 14 to 24: the tangential part bends the finger too and is taken for normal force",
        "no more than 2.4 % (as rounded: 2.45 %) at every node, to both sides",
        statement(largest(&tip).max(largest(&base)) <= DIRECTION_SHARE),
    ))
}

/// What a torque costs that is neglected.
pub fn torque(finger: &Finger) -> Result<Claim, SensingError> {
    let torque = experiments::neglected_torque(finger, FRICTIONS[1])?;
    let count = torque.iter().filter(|error| **error <= NEGLIGIBLE_FORCE_SHARE).count();
    let negligible = |friction| -> Result<ClaimVerdict, SensingError> {
        let errors = experiments::neglected_torque(finger, friction)?;
        Ok(statement(largest(&errors) <= NEGLIGIBLE_FORCE_SHARE))
    };
    Ok(claim(
        "\"the moment arm is small and the resulting torque at each node is also negligible\" (sec. V-C)",
        "no figure",
        format!(
            "{} of the force; no more than {} at {count} of {} nodes",
            between(range_of(&torque), percent),
            percent(NEGLIGIBLE_FORCE_SHARE),
            torque.len()
        ),
        format!(
            "linear finger and model, nodes 14 to 24, friction of {} (assumed) on a rod of 1.5 mm radius: its moment alone",
            FRICTIONS[1]
        ),
        format!(
            "at each node no more than the 2.4 % that the paper calls negligible for the direction, with friction of {} and of {}",
            FRICTIONS[0], FRICTIONS[1]
        ),
        over_assumptions(&[negligible(FRICTIONS[0])?, negligible(FRICTIONS[1])?]),
    ))
}

fn zero_force(finger: &Finger) -> Result<Claim, SensingError> {
    let largest_n = experiments::zero_force(finger, BESIDE_N, CAMERA_NOISE_MM)?;
    Ok(claim(
        "\"Sometimes, the estimation of zero force may have small errors (less than 0.3 N)\" (sec. V-D, Fig. 14)",
        newtons(0.3),
        newtons(largest_n),
        format!(
            "simulated: linear least squares for nodes 16 to 20 at once, {BESIDE_N} N at four of them, the fifth untouched; co-rotational finger, \
             {CAMERA_NOISE_MM} mm noise, root mean square at the worst node. The paper's network for five contacts is not recorded, so its figure is not \
             tested"
        ),
        "",
        ClaimVerdict::NotTested,
    ))
}

/// The network that ships, as timed by this report.
fn network_time(study: &Study) -> Option<Claim> {
    let here = |timed_by: &TimedBy| !matches!(timed_by, TimedBy::OtherProgram { .. });
    let point = study.speed_error.iter().find(|point| {
        point.task == Task::SenseOne && point.estimator == Some(EstimatorId::Network) && here(&point.timed_by)
    })?;
    Some(claim(
        "\"the calculating time of the trained NNM-based sensing model is negligible\" (sec. VI)",
        "no figure",
        format!("{:.1} us a frame", 1e6 * point.seconds),
        "the network that ships, one contact, one core, timed by this report; it is smaller than the paper's, which is not timed",
        "",
        ClaimVerdict::NotTested,
    ))
}
