//! Sensing of contacts without friction, which push along the deformed normal. The estimator may assume this direction.

use super::{Answers, DirectionRequest};
use crate::prelude::*;
use crate::sampling::scatter::sampled_nodes;
use crate::truths::Truth;

/// Push and normal count as aligned if they differ by at most this angle, degrees. A misalignment by this angle changes the force by 1e-6, relative.
const SETTLED_DEG: f64 = 1e-4;
/// Largest number of iterations to find the deformed normal.
const MOST_TURNS: usize = 30;

/// Assumption about the direction of a push.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Assumption {
    /// The push is along the undeformed normal.
    Undeformed,
    /// The push is along the deformed normal.
    Normal,
    /// The direction is unknown.
    Unknown,
}

impl Assumption {
    /// All assumptions.
    pub const ALL: [Assumption; 3] = [Assumption::Undeformed, Assumption::Normal, Assumption::Unknown];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Assumption::Undeformed => "undeformed",
            Assumption::Normal => "normal",
            Assumption::Unknown => "unknown",
        }
    }

    fn direction(self) -> Direction {
        match self {
            Assumption::Undeformed => Direction::Angle(0.0),
            Assumption::Normal => Direction::NORMAL,
            Assumption::Unknown => Direction::Auto,
        }
    }
}

/// A push along the deformed normal, sensed under one assumption about its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionlessPush {
    /// Node at which the force acts.
    pub node: usize,
    /// Position of the node on the front plate, mm from the base.
    pub s_mm: f64,
    /// True force, N.
    pub force_n: f64,
    /// Direction of the push, degrees from the undeformed normal; `None` if the finger has no equilibrium.
    pub angle_deg: Option<f64>,
    /// Assumption of the estimator.
    pub assumed: Assumption,
    /// Answers of the estimator.
    pub answers: Answers,
}

pub(super) fn nodes(finger: &Finger) -> Vec<NodeId> {
    sampled_nodes(finger)
}

/// One row for each node, force and assumption. `progress` is called after each node.
pub(super) fn rows(
    truth: &dyn Truth,
    request: &DirectionRequest,
    samples: &[Vec<f64>],
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<FrictionlessPush>, SensingError> {
    let finger = request.model.finger();
    let of_node = |node: &NodeId| -> Result<Vec<FrictionlessPush>, SensingError> {
        let position = ContactPosition::Node(*node);
        let mut rows = Vec::new();
        for force_n in request.forces_n {
            let push = pushed(truth, *node, force_n);
            for assumed in Assumption::ALL {
                let question = ContactQuestion::new(Some(position), assumed.direction());
                let mut estimator = NonlinearEstimator::new(request.model, &[question])?;
                let answers = push.as_ref().map_or_else(Answers::default, |(contact, shape)| {
                    let seen = Measurement::of_shape(finger, shape);
                    Answers::of(&mut estimator, &seen, samples, request.noise_mm, contact, force_n)
                });
                let s_mm = finger.front_position_mm(*node).unwrap_or(f64::NAN);
                let angle_deg = push.as_ref().map(|(contact, _)| contact.angle_deg);
                rows.push(FrictionlessPush { node: node.0, s_mm, force_n, angle_deg, assumed, answers });
            }
        }
        progress();
        Ok(rows)
    };
    let rows: Result<Vec<_>, SensingError> = nodes(finger).par_iter().map(of_node).collect();
    Ok(rows?.into_iter().flatten().collect())
}

/// Contact, and shape of the finger, for a push at a node along the deformed normal; `None` if the iteration does not converge.
fn pushed(truth: &dyn Truth, node: NodeId, force_n: f64) -> Option<(Contact, FingerShape)> {
    let mut contact = Contact::at_node(node);
    for _ in 0..MOST_TURNS {
        let shape = truth.shapes(&contact, &[force_n]).pop()?;
        // The normal rotates with the plate.
        let normal_deg = shape.motion(node).rotation.to_degrees();
        if (normal_deg - contact.angle_deg).abs() <= SETTLED_DEG {
            return Some((contact, shape));
        }
        contact.angle_deg = normal_deg;
    }
    None
}
