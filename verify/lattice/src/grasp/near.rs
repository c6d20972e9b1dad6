//! Pairs of parts of finger, object and support that are near each other, and their status in a Newton step: open, sticking or slipping.

use super::contact::{Pair, PairPose, Tangent, Touching};
use super::scene::{Key, Scene, State, Surroundings};
use super::surface::{Feature, Part};
use crate::energy::BodyMotion;
use crate::skin::TouchedPart;
use finray_model::Vector;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// Distance, as a share of the object's size, up to which a pair counts.
const NEAR: f64 = 0.2;

/// An object that is carried along has left its support where the gap would take this many times the force, by the fingers' stiffness across.
const LIFTED: f64 = 10.0;

/// Friction that is as near to its bound, as a share of it, is at the bound: rounding leaves a pair that slips a little below.
const AT_BOUND: f64 = 1e-9;

/// A pair that is near, at some state.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactPair {
    pub key: Key,
    /// The part of the finger; none of the support.
    pub part: Option<Part>,
    pair: Pair,
    pub touching: Touching,
}

/// How a closed pair holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grip {
    Sticks,
    Slips { forwards: bool },
}

/// How a pair holds in a Newton step, and whether its force pulled in the last one.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactStatus {
    /// None of an open pair.
    pub(super) grip: Option<Grip>,
    pub(super) is_pulled: bool,
}

impl State {
    /// Where a part of a finger and the object are; without a part, of the support.
    fn stand(&self, finger: usize, part: Option<&Part>) -> PairPose {
        let (finger, body) = match part {
            Some(part) => (self.placements[finger], self.motions[finger][part.body]),
            None => (Placement::IDENTITY, BodyMotion::default()),
        };
        PairPose { finger, body, object: self.object }
    }
}

impl Scene<'_> {
    /// All pairs that are near each other.
    pub(super) fn near_pairs(&self, state: &State, before: &State, around: &Surroundings) -> Vec<ContactPair> {
        let mut pairs = Vec::new();
        let within_mm = NEAR * self.size_mm;
        for (finger, standing) in self.fingers.iter().enumerate() {
            for (index, part) in standing.front.parts.iter().enumerate() {
                let body = standing.lattice.assembly().bodies[part.body];
                let [now, then] = [state, before].map(|state| state.stand(finger, Some(part)));
                for (feature, pair) in self.shape.near(part, &body, &now, within_mm) {
                    let touching = pair.touching(body.position, &now, &then);
                    pairs.push(ContactPair { key: (finger, index, feature), part: Some(*part), pair, touching });
                }
            }
        }
        let Some((point, upward)) = around.support else { return pairs };
        let support = self.fingers.len();
        let [now, then] = [state, before].map(|state| state.stand(support, None));
        let (corners, disc_mm) = self.shape.corners();
        for (i, corner) in corners.iter().enumerate() {
            let radii_mm = [0.0, disc_mm];
            let pair = Pair::PieceAndCorner { on_piece: point, outward: upward, corner: *corner, radii_mm };
            let touching = pair.touching(Vector::zeros(), &now, &then);
            if touching.gap_mm < within_mm {
                pairs.push(ContactPair { key: (support, 0, Feature::Corner(i)), part: None, pair, touching });
            }
        }
        pairs
    }

    /// The tangent of a pair that was found to be near.
    pub(super) fn tangent(&self, contact: &ContactPair, state: &State, before: &State) -> Tangent {
        let ContactPair { key: (finger, ..), part, pair, .. } = contact;
        let rest = |part: Part| self.fingers[*finger].lattice.assembly().bodies[part.body].position;
        let [now, then] = [state, before].map(|state| state.stand(*finger, part.as_ref()));
        pair.tangent(part.map_or(Vector::zeros(), rest), &now, &then)
    }

    /// Forces of the pairs that are near now: their own, or for a new one those of a pair of the same part that is no longer near.
    pub(super) fn inherited(&self, state: &State, pairs: &[ContactPair]) -> BTreeMap<Key, [f64; 2]> {
        let mut gone: BTreeMap<Key, [f64; 2]> = state.forces.clone();
        pairs.iter().for_each(|pair| {
            gone.remove(&pair.key);
        });
        let mut force = |key: Key| {
            state.forces.get(&key).copied().unwrap_or_else(|| {
                let of_same = gone.keys().find(|(finger, part, feature)| {
                    *finger == key.0 && (*part == key.1 || matches!(feature, Feature::Corner(_)) && *feature == key.2)
                });
                let of_same = of_same.copied();
                of_same.and_then(|key| gone.remove(&key)).unwrap_or_default()
            })
        };
        pairs.iter().map(|pair| (pair.key, force(pair.key))).collect()
    }

    /// The status of all pairs after a step in which they had the status `before`. Where the support has let go of the object, others hold it alone,
    /// and are taken to stick until they cannot.
    pub(super) fn statuses(
        &self,
        pairs: &[ContactPair],
        forces: &BTreeMap<Key, [f64; 2]>,
        before: &BTreeMap<Key, ContactStatus>,
    ) -> BTreeMap<Key, ContactStatus> {
        let status = |pair: &ContactPair| (pair.key, self.status(pair, forces[&pair.key], before.get(&pair.key)));
        let mut statuses: BTreeMap<Key, ContactStatus> = pairs.iter().map(status).collect();
        let lets_go = |pair: &ContactPair| {
            let was_closed = before.get(&pair.key).is_some_and(|status| status.grip.is_some());
            pair.part.is_none() && was_closed && statuses[&pair.key].grip.is_none()
        };
        if pairs.iter().any(lets_go) {
            statuses.values_mut().filter_map(|status| status.grip.as_mut()).for_each(|grip| *grip = Grip::Sticks);
        }
        statuses
    }

    /// The status of a pair after a step in which it had the status `before`. A closed one opens when its force pulls twice in a row: after a long
    /// step forces are not yet what they will be.
    fn status(
        &self,
        pair: &ContactPair,
        [normal_n, friction_n]: [f64; 2],
        before: Option<&ContactStatus>,
    ) -> ContactStatus {
        let Touching { gap_mm, slip_mm, .. } = pair.touching;
        let grip = |held_n: f64, pressed_n: f64| match held_n.abs() < self.friction * pressed_n {
            true => Some(Grip::Sticks),
            false => Some(Grip::Slips { forwards: held_n < 0.0 }),
        };
        let is_lifted = pair.part.is_none() && normal_n < LIFTED * self.stiffness * gap_mm;
        let before = before.copied().unwrap_or(ContactStatus {
            grip: if normal_n > self.nothing_n() && !is_lifted {
                // A pair that slipped slips on, until it turns out to stick.
                grip(friction_n, (1.0 - AT_BOUND) * normal_n)
            } else {
                None
            },
            is_pulled: false,
        });
        let is_pulled = normal_n < -self.nothing_n() && before.grip.is_some();
        let grip = match before.grip {
            None if gap_mm >= 0.0 => None,
            None => grip(-self.stiffness * slip_mm, -self.stiffness * gap_mm),
            _ if is_pulled && before.is_pulled => None,
            closed if is_pulled => closed,
            Some(Grip::Sticks) => grip(friction_n, normal_n),
            Some(Grip::Slips { forwards }) if self.friction == 0.0 || slip_mm == 0.0 || (slip_mm > 0.0) == forwards => {
                before.grip
            }
            Some(Grip::Slips { .. }) => Some(Grip::Sticks),
        };
        ContactStatus { grip, is_pulled: is_pulled && grip.is_some() }
    }
}

/// Where on the plate a part is touched: a piece where it is met, from its first end.
pub(super) fn touched(part: &Part, arm: Vector) -> TouchedPart {
    match (part.touched, part.to) {
        (TouchedPart::Plate(from_mm), Some(to)) => {
            TouchedPart::Plate(from_mm + (arm - part.from).dot(&(to - part.from).normalize()))
        }
        (touched, _) => touched,
    }
}
