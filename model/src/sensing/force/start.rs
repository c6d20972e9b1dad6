//! Starting points of the search, from least squares on the linear finger.

use super::derivatives::differentiate;
use super::linearised::Seen;
use super::problem::{ForceProblem, State};
use super::states::state_of;
use super::values::Nuisances;
use crate::finger::{Finger, Plate};
use crate::measurement::Measurement;
use crate::rigid_fit::rigid_fit;
use crate::sensing::{
    Contact, ContactPosition, Direction, Estimate, ForcePrior, LinearEstimator, SensingError, halved_below,
};
use crate::statics::{Equilibrium, StaticsError};
use nalgebra::{Isometry2, Point2};
use std::borrow::Cow;

/// A starting point of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum StartingPoint {
    /// The forces that fit the linear finger to the measurement, times this factor.
    Times(f64),
    /// The forces that fit the linear finger to the measurement, with all unknown directions at this angle, degrees from the undeformed inward normal.
    Towards(f64),
    /// The forces that fit the linear finger after its base is moved by the rigid motion that best explains the measurement without any force.
    FromMovedBase,
    /// The minimum that results if directions do not follow the plate but keep their angle from the undeformed normal.
    Held,
}

const STARTS: [StartingPoint; 4] =
    [StartingPoint::Times(1.0), StartingPoint::Times(-1.0), StartingPoint::Times(0.3), StartingPoint::Times(-0.3)];
/// Further starting points, with unknown directions at these angles in degrees, used if no multiple of the linear finger's forces explains the
/// measurement. The starting points at these angles lead to forces that act nearly along a buckled plate.
const STARTS_BY_DIRECTION: [StartingPoint; 3] =
    [StartingPoint::Towards(0.0), StartingPoint::Towards(-60.0), StartingPoint::Towards(60.0)];

/// Starting points in the order in which the search uses them.
pub(super) fn starting_points(
    problem: &ForceProblem,
    is_base_sought: bool,
) -> impl Iterator<Item = StartingPoint> + use<> {
    let is_direction_sought = problem.questions.iter().any(|question| question.direction == Direction::Auto);
    let moved_base = is_base_sought.then_some(StartingPoint::FromMovedBase);
    let by_direction = STARTS_BY_DIRECTION.into_iter().filter(move |_| is_direction_sought);
    let held = problem.follows_plate().then_some(StartingPoint::Held);
    STARTS.into_iter().chain(moved_base).chain(by_direction).chain(held)
}

/// Starting point by least squares on the linear finger. An unknown position is the contact node that explains the measurement best.
pub(super) fn start_at(problem: &mut ForceProblem, seen: Seen, start: StartingPoint) -> Result<State, SensingError> {
    let mut nuisances = Nuisances::expected(problem.questions.len(), &problem.shared_errors);
    let (mut factor, mut towards_deg) = (1.0, None);
    match start {
        StartingPoint::Times(times) => factor = times,
        StartingPoint::Towards(angle_deg) => towards_deg = Some(angle_deg),
        StartingPoint::FromMovedBase => nuisances.base = rigid_motion(problem.finger(), seen.measurement),
        // The caller searches from a held direction.
        StartingPoint::Held => {}
    }
    let from_base = seen_from(problem.finger(), seen.measurement, &nuisances.base);
    let finger = problem.finger();
    // An unknown position is tried at every contact node. Several unknown positions are determined one after the other.
    let mut positions: Vec<Option<ContactPosition>> = problem.questions.iter().map(|q| q.position).collect();
    for i in 0..positions.len() {
        if positions[i].is_some() {
            continue;
        }
        let mut best = None;
        for node in finger.contact_nodes() {
            positions[i] = Some(ContactPosition::Node(node));
            let Ok((contacts, estimate)) = linear_start(problem, &positions, towards_deg, &from_base) else {
                continue;
            };
            let inward = contacts.iter().zip(&estimate.forces_n).all(|(_, f)| *f >= 0.0);
            let better = best.is_none_or(|(_, residual)| estimate.residual_rms_mm < residual);
            if inward && better {
                best = Some((node, estimate.residual_rms_mm));
            }
        }
        positions[i] = Some(ContactPosition::Node(best.map_or(finger.tip(), |(node, _)| node)));
    }
    let (contacts, estimate) = linear_start(problem, &positions, towards_deg, &from_base)?;
    // An unknown position varies continuously, so it is stored as a distance along the plate and not as a node.
    let contacts: Vec<Contact> = contacts
        .iter()
        .zip(&problem.questions)
        .map(|(contact, question)| match question.position {
            Some(_) => *contact,
            None => {
                let s_mm = contact.position_mm(finger).unwrap_or(0.5 * finger.plate_length_mm(Plate::Front));
                Contact { position: ContactPosition::at(s_mm), ..*contact }
            }
        })
        .collect();
    let mut forces_n: Vec<f64> = estimate.forces_n.iter().map(|f| f * factor).collect();
    // The co-rotational finger may have no equilibrium under the forces of the linear finger. The forces are halved until an equilibrium exists.
    for _ in 0..30 {
        let mut state = state_of(problem, contacts.clone(), forces_n.clone(), nuisances.clone())?;
        match problem.statics.tried(&state.motion, [&[], &state.loads], usize::MAX, |_, _| true) {
            Ok(Equilibrium { motion, .. }) => {
                state.motion = motion;
                differentiate(problem, &mut state)?;
                state.weigh(seen);
                return Ok(state);
            }
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                let carried = halved_below(converged_fraction);
                forces_n.iter_mut().for_each(|f| *f *= carried);
            }
            Err(other) => return Err(other.into()),
        }
    }
    Err(SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 0.0 }))
}

/// Contacts and forces by linear least squares. A force of unknown direction is estimated as two components, from which one force and its angle
/// follow. If `towards_deg` is given, unknown directions have this angle instead.
fn linear_start(
    problem: &ForceProblem,
    positions: &[Option<ContactPosition>],
    towards_deg: Option<f64>,
    measurement: &Measurement,
) -> Result<(Vec<Contact>, Estimate), SensingError> {
    let finger = problem.finger();
    let mut components = Vec::new();
    for (question, position) in problem.questions.iter().zip(positions) {
        let position = position.or(question.position).unwrap_or(ContactPosition::Node(finger.tip()));
        match (question.direction, towards_deg) {
            (Direction::Angle(angle_deg), _) | (Direction::Auto, Some(angle_deg)) => {
                components.push(Contact { position, angle_deg });
            }
            (Direction::Measured(normal), _) => components.push(Contact { position, angle_deg: normal.angle_deg }),
            (Direction::Leaning(lean), _) => components.push(Contact { position, angle_deg: lean.angle_deg }),
            (Direction::Auto, None) => {
                components.extend([0.0, 90.0].map(|angle_deg| Contact { position, angle_deg }));
            }
        }
    }
    let estimator = LinearEstimator::new(finger, &components, measurement)?;
    // If few markers barely separate forces, least squares may return large forces that cancel. Large forces that cancel are a bad starting
    // point. A prior prevents such forces. The standard deviation of the prior for each force is about the size of a single force that would move
    // the markers as far as measured. The prior has little effect on forces that the markers separate well.
    let moved: f64 = measurement.markers().iter().map(|m| (m.displacement * m.weight).norm_squared()).sum();
    let prior = ForcePrior::Gaussian { force_n: moved.sqrt() / estimator.singular_values()[0] };
    let mut estimate = estimator.estimate(measurement, None, prior);
    let mut parts = components.iter().zip(estimate.forces_n.clone());
    let (mut contacts, mut forces_n) = (Vec::new(), Vec::new());
    for question in &problem.questions {
        let Some((contact, force)) = parts.next() else { break };
        match (question.direction, towards_deg, parts.len()) {
            (Direction::Auto, None, 1..) => {
                let across = parts.next().map_or(0.0, |(_, f)| f);
                contacts.push(Contact { angle_deg: across.atan2(force).to_degrees(), ..*contact });
                forces_n.push(force.hypot(across));
            }
            _ => {
                contacts.push(*contact);
                forces_n.push(force);
            }
        }
    }
    estimate.forces_n = forces_n;
    Ok((contacts, estimate))
}

/// Pose of the base, mm and rad, under the assumption that nothing bends the finger. The pose is the rigid motion that best fits the finger's markers
/// to their measured positions.
fn rigid_motion(finger: &Finger, measurement: &Measurement) -> Isometry2<f64> {
    rigid_fit(measurement.markers().iter().map(|marker| {
        let rest = finger.marker_position(marker.node);
        (rest, rest + marker.displacement, marker.weight)
    }))
}

/// The measurement with its displacements, mm, expressed in the frame of a base with the pose `base`.
fn seen_from<'m>(finger: &Finger, measurement: &'m Measurement, base: &Isometry2<f64>) -> Cow<'m, Measurement> {
    if *base == Isometry2::identity() {
        return Cow::Borrowed(measurement);
    }
    Cow::Owned(measurement.clone().with_markers(|marker| {
        let rest = finger.marker_position(marker.node);
        marker.displacement = base.inverse_transform_point(&Point2::from(rest + marker.displacement)).coords - rest;
    }))
}
