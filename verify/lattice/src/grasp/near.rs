//! Pairs of parts of finger, object and support that are near each other, and their status in a Newton step: open, sticking or slipping.

use super::contact::{Pair, PairPose, Tangent, Touching};
use super::scene::{Key, Scene, State, Surroundings};
use super::surface::{Feature, Part};
use crate::energy::BodyMotion;
use crate::skin::TouchedPart;
use finray_model::Vector;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// Distance, in lengths of a piece of plate, up to which others are next to it.
const NEXT: f64 = 1.5;

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
        self.pairs_near_at(state, state, before, around)
    }

    /// All pairs that carried a force before, as they are now.
    pub(super) fn loaded_pairs(&self, state: &State, before: &State, around: &Surroundings) -> Vec<ContactPair> {
        let is_loaded = |pair: &ContactPair| before.forces.get(&pair.key).is_some_and(|[normal_n, _]| *normal_n > 0.0);
        self.pairs_near_at(before, state, before, around).into_iter().filter(is_loaded).collect()
    }

    /// All pairs that are near each other at one state, as they are at another.
    fn pairs_near_at(&self, at: &State, state: &State, before: &State, around: &Surroundings) -> Vec<ContactPair> {
        let mut pairs = Vec::new();
        let within_mm = NEAR * self.size_mm;
        for (finger, standing) in self.fingers.iter().enumerate() {
            for (index, part) in standing.front.parts.iter().enumerate() {
                let body = standing.lattice.assembly().bodies[part.body];
                if body.fixed && self.held == [true; 3] {
                    // Neither gives way: no force is determined.
                    continue;
                }
                let [now, then] = [state, before].map(|state| state.stand(finger, Some(part)));
                for (feature, pair) in self.shape.near(part, &body, &at.stand(finger, Some(part)), within_mm) {
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

    /// Forces of the pairs that are near now: their own, or those of a pair of the same part, or of the same corner, that is no longer near. Of several new
    /// ones next to it on the plate that which overlaps most takes them, or else the nearest.
    pub(super) fn inherited(&self, state: &State, pairs: &[ContactPair]) -> BTreeMap<Key, [f64; 2]> {
        let own = |pair: &ContactPair| (pair.key, state.forces.get(&pair.key).copied().unwrap_or_default());
        let mut forces: BTreeMap<Key, [f64; 2]> = pairs.iter().map(own).collect();
        let mut new: Vec<&ContactPair> = pairs.iter().filter(|pair| !state.forces.contains_key(&pair.key)).collect();
        let is_gone = |(key, force): &(&Key, &[f64; 2])| !forces.contains_key(key) && **force != [0.0; 2];
        let gone: Vec<(&Key, &[f64; 2])> = state.forces.iter().filter(is_gone).collect();
        for (gone, force) in gone {
            let is_heir = |key: &Key| {
                key.0 == gone.0 && (key.1 == gone.1 || matches!(gone.2, Feature::Corner(_)) && key.2 == gone.2)
            };
            let rank = |pair: &ContactPair| {
                let away_mm = self.along_plate_mm(pair.key, *gone);
                let (beyond_mm, gap_mm) = (away_mm - NEXT * self.length_mm(*gone), pair.touching.gap_mm);
                if beyond_mm <= 0.0 { (0.0, gap_mm) } else { (beyond_mm, 0.0) }
            };
            let heirs = new.iter().enumerate().filter(|(_, pair)| is_heir(&pair.key));
            let heir = heirs
                .map(|(index, pair)| (rank(pair), index))
                .min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
            if let Some((_, index)) = heir {
                forces.insert(new.swap_remove(index).key, *force);
            }
        }
        forces
    }

    /// Distance of two parts of a finger along its plate, mm, from where each begins; 0 of the support.
    fn along_plate_mm(&self, a: Key, b: Key) -> f64 {
        let at_mm = |(finger, part, _): Key| {
            let standing = self.fingers.get(finger);
            standing.map_or(0.0, |standing| standing.front.parts[part].touched.position_mm(standing.lattice))
        };
        (at_mm(a) - at_mm(b)).abs()
    }

    /// Length of a flat piece of a finger, mm; 0 of a ball and of the support.
    fn length_mm(&self, (finger, part, _): Key) -> f64 {
        let part = self.fingers.get(finger).map(|standing| standing.front.parts[part]);
        part.and_then(|part| Some((part.to? - part.from).norm())).unwrap_or(0.0)
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
        if self.held == [true; 3] {
            for shallow in beside_deepest(pairs, forces, &statuses) {
                statuses.insert(shallow, ContactStatus { grip: None, is_pulled: false });
            }
        }
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

/// Pairs without force that would close beside one that overlaps deeper, where pieces of the plate follow each other. A step that moves the plate off the
/// deepest mostly frees the others, which all together would bend it at will.
fn beside_deepest(
    pairs: &[ContactPair],
    forces: &BTreeMap<Key, [f64; 2]>,
    statuses: &BTreeMap<Key, ContactStatus>,
) -> Vec<Key> {
    let closes = |pair: &&ContactPair| {
        let is_piece = pair.part.is_some_and(|part| matches!(part.touched, TouchedPart::Plate(_)));
        is_piece && forces[&pair.key] == [0.0; 2] && statuses[&pair.key].grip.is_some()
    };
    let closing: Vec<&ContactPair> = pairs.iter().filter(closes).collect();
    // A flat piece and the ball at its end follow each other, and so do two flat pieces.
    let follows = |a: &&ContactPair, b: &&ContactPair| a.key.0 == b.key.0 && b.key.1 - a.key.1 <= 2;
    let mut shallow = Vec::new();
    for run in closing.chunk_by(follows) {
        let deepest = run.iter().map(|pair| pair.touching.gap_mm).fold(f64::INFINITY, f64::min);
        shallow.extend(run.iter().filter(|pair| pair.touching.gap_mm > deepest).map(|pair| pair.key));
    }
    shallow
}
