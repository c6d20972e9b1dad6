//! Contact pairs within a search distance. Each contact pair consists of a feature of the object and either a part of a finger or the support. In a
//! Newton step, each contact pair is open, sticking or slipping.

use crate::carrier::Carrier;
use crate::outline::{Feature, PoseInFinger};
use crate::pair::{Meeting, Pair, PairPose, Tangent, Touching};
use crate::part::{Part, Touches};
use crate::region::Region;
use crate::scene::{Key, Scene, State, Surroundings};
use crate::{TouchedPart, Wall};
use finray_model::Vector;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// Two pieces of the plate count as neighbours up to this distance along the plate, in piece lengths.
const NEXT: f64 = 1.5;

/// Search distance: a pair takes part in a Newton step if its gap is below this share of the object's size.
const NEAR: f64 = 0.2;

/// The object counts as lifted off its support if the normal force is less than this factor times the fingers' stiffness times the gap.
const LIFTED: f64 = 10.0;

/// A contact counts as slipping if friction is within this relative distance of its bound. Rounding leaves slipping contacts slightly below the bound.
const AT_BOUND: f64 = 1e-9;

/// A contact pair within the search distance `NEAR`, evaluated at one state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPair {
    /// Finger, part and feature that identify the pair.
    pub key: Key,
    /// Part of the finger; `None` if the object is in contact with the support.
    pub part: Option<Part>,
    /// Geometry of the contact.
    pub pair: Pair,
    /// Gap, slip, normal and point of the contact.
    pub touching: Touching,
}

/// Friction status of a pair in contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Grip {
    Sticks,
    Slips { forwards: bool },
}

/// Contact status of a pair in a Newton step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactStatus {
    /// Sticking or slipping; `None` for an open pair.
    pub(crate) grip: Option<Grip>,
    /// Whether the normal force was tensile in the previous Newton step.
    pub(crate) is_pulled: bool,
}

impl State {
    /// Poses of the object and of the finger's part of a pair, or of the support.
    fn poses(&self, finger: usize, pair: &Pair) -> PairPose {
        match self.motions.get(finger) {
            Some(motion) => PairPose::new(&pair.carrier, self.placements[finger], motion, self.object),
            None => PairPose { finger: Placement::IDENTITY, nodes: [0.0; 6], object: self.object },
        }
    }
}

impl ContactPair {
    fn new(key: Key, part: Option<Part>, pair: Pair, state: &State, before: &State) -> ContactPair {
        let touching = pair.touching(&state.poses(key.0, &pair), &before.poses(key.0, &pair));
        ContactPair { key, part, pair, touching }
    }

    /// Derivatives of the pair's gap, slip and forces.
    pub(crate) fn tangent(&self, state: &State, before: &State) -> Tangent {
        self.pair.tangent(&state.poses(self.key.0, &self.pair), &before.poses(self.key.0, &self.pair))
    }
}

impl Scene<'_> {
    /// All pairs within the search distance in `state`.
    pub(crate) fn near_pairs(&self, state: &State, before: &State, around: &Surroundings) -> Vec<ContactPair> {
        self.pairs_near_at(state, state, before, around)
    }

    /// All pairs that carried a force in `before`, evaluated at `state`.
    pub(crate) fn loaded_pairs(&self, state: &State, before: &State, around: &Surroundings) -> Vec<ContactPair> {
        let is_loaded = |pair: &ContactPair| before.forces.get(&pair.key).is_some_and(|[normal_n, _]| *normal_n > 0.0);
        self.pairs_near_at(before, state, before, around).into_iter().filter(is_loaded).collect()
    }

    /// Pairs within the search distance in the state `at`, evaluated at `state`.
    fn pairs_near_at(&self, at: &State, state: &State, before: &State, around: &Surroundings) -> Vec<ContactPair> {
        let mut pairs = Vec::new();
        let within_mm = NEAR * self.size_mm;
        for (finger, standing) in self.fingers.iter().enumerate() {
            let pose = PoseInFinger::new(&at.placements[finger], at.object);
            // If neither the finger's part nor the object can move, the contact force would be undetermined.
            let can_move = |carrier: &Carrier| self.held != [true; 3] || !carrier.is_fixed();
            let object = (&self.shape, &pose);
            standing.surface.near(&at.motions[finger], object, within_mm, can_move, |index, feature, pair, gap_mm| {
                let (key, part) = ((finger, index, feature), Some(standing.surface.parts[index]));
                let is_loaded = |state: &State| state.forces.get(&key).is_some_and(|forces| *forces != [0.0; 2]);
                let is_open = gap_mm > 0.0 && !is_loaded(state) && !is_loaded(before);
                pairs.push(if !is_open || !std::ptr::eq(at, state) {
                    ContactPair::new(key, part, pair, state, before)
                } else {
                    // Only the gap of an open pair matters.
                    let touching = Touching { gap_mm, slip_mm: 0.0, normal: Vector::zeros(), point: Vector::zeros() };
                    ContactPair { key, part, pair, touching }
                });
            });
            if standing.surface.region == Region::Outside {
                keep_nearer_plate(&mut pairs, finger, state);
            }
        }
        if std::ptr::eq(at, state) {
            let lost: Vec<ContactPair> =
                at.forces.keys().filter_map(|key| self.without_foot(*key, &pairs, state, before)).collect();
            pairs.extend(lost);
        }
        let Some((point, upward)) = around.support else { return pairs };
        let carrier = Carrier::Rigid { mount: None, from: point, along: Vector::new(upward.y, -upward.x) };
        let (corners, disc_mm) = self.shape.corners();
        for (i, corner) in corners.iter().enumerate() {
            let meeting = Meeting::PieceAndCorner { corner: *corner };
            let pair = Pair { carrier, xi: 0.0, radius_mm: 0.0, disc_mm, side: 1.0, meeting };
            let key = (self.fingers.len(), 0, Feature::Corner(i));
            let pair = ContactPair::new(key, None, pair, state, before);
            if pair.touching.gap_mm < within_mm {
                pairs.push(pair);
            }
        }
        pairs
    }

    /// A loaded pair on a piece on which the object's corner no longer has a foot, if no neighbouring piece has the foot instead. The pair then remains at
    /// the end of its piece, so that a second contact can close before this one opens: a plate that bends as sharply as a disc touches the disc at
    /// two points.
    fn without_foot(&self, key: Key, pairs: &[ContactPair], state: &State, before: &State) -> Option<ContactPair> {
        let (finger, index, Feature::Corner(corner)) = key else { return None };
        let part = self.fingers.get(finger)?.surface.parts[index];
        let is_near = |pair: &&ContactPair| {
            pair.key.0 == finger && pair.key.2 == key.2 && self.along_plate_mm(pair.key, key) <= NEXT * part.length_mm
        };
        if part.touches != Touches::Corners || state.forces[&key] == [0.0; 2] || pairs.iter().any(|pair| is_near(&pair))
        {
            return None;
        }
        let pose = PoseInFinger::new(&state.placements[finger], state.object);
        let line = part.carrier.deformed(&part.carrier.coordinates(&state.motions[finger]));
        let (corners, disc_mm) = self.shape.corners();
        let start = line.axis(part.xi[0]);
        let xi = part.xi[usize::from((pose.point(corners[corner]) - start.point).dot(&start.tangent) > 0.0)];
        let meeting = Meeting::BallAndCorner { corner: corners[corner] };
        let pair = Pair { carrier: part.carrier, xi, radius_mm: part.radius_mm, disc_mm, side: part.side, meeting };
        Some(ContactPair::new(key, Some(part), pair, state, before))
    }

    /// Contact forces of the pairs within the search distance. A new pair inherits the force of a pair that has left the search distance. A new pair
    /// and the pair whose force it inherits must have the same part of the finger, or the same corner of the object. If several new pairs could
    /// inherit a force, neighbours on the plate come first; among the neighbours, the pair with the smallest gap inherits it. If no new pair is a
    /// neighbour on the plate, the new pair nearest along the plate inherits the force.
    pub(crate) fn inherited(&self, state: &State, pairs: &[ContactPair]) -> BTreeMap<Key, [f64; 2]> {
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

    /// Distance along a wall between the starts of two parts of one finger, mm; infinite between two walls, and 0 between two pairs of the support.
    fn along_plate_mm(&self, a: Key, b: Key) -> f64 {
        let place = |(finger, part, _): Key| {
            let standing = self.fingers.get(finger);
            standing.map(|standing| standing.surface.parts[part].touched.place(standing.mesh.finger()))
        };
        match (place(a), place(b)) {
            (Some((a, _)), Some((b, _))) if a != b => f64::INFINITY,
            (Some((_, a_mm)), Some((_, b_mm))) => (a_mm - b_mm).abs(),
            _ => 0.0,
        }
    }

    /// Length of a piece of a finger's plate, mm; 0 for a disc and for the support.
    fn length_mm(&self, (finger, part, _): Key) -> f64 {
        self.fingers.get(finger).map_or(0.0, |standing| standing.surface.parts[part].length_mm)
    }

    /// Contact statuses of all pairs after a Newton step that assumed the statuses `before`. If the object is lifted off its support, only the fingers hold
    /// the object; all closed pairs are then set to sticking.
    pub(crate) fn statuses(
        &self,
        pairs: &[ContactPair],
        forces: &BTreeMap<Key, [f64; 2]>,
        before: &BTreeMap<Key, ContactStatus>,
    ) -> BTreeMap<Key, ContactStatus> {
        let status = |pair: &ContactPair| (pair.key, self.status(pair, forces[&pair.key], before.get(&pair.key)));
        let mut statuses: BTreeMap<Key, ContactStatus> = pairs.iter().map(status).collect();
        for shallow in beside_deepest(pairs, forces, &statuses) {
            statuses.insert(shallow, ContactStatus { grip: None, is_pulled: false });
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

    /// Contact status of a pair after a Newton step that assumed the status `before`. A closed pair opens only after two steps with a tensile force,
    /// because forces are inaccurate after a large step.
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
                // A slipping pair keeps slipping until a Newton step shows that it sticks.
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

/// The touched part of the finger.
pub(crate) fn touched(part: &Part, pair: &Pair) -> TouchedPart {
    match part.touched {
        TouchedPart::On(wall, from_mm) if part.xi[0] < part.xi[1] => {
            TouchedPart::On(wall, from_mm + part.length_mm * (pair.xi - part.xi[0]) / (part.xi[1] - part.xi[0]))
        }
        touched => touched,
    }
}

/// Removes unloaded pairs in which a corner outside the finger would overlap one plate, but is nearer to the middle line of the other plate. Near the
/// tip, a corner that touches one plate is within the search distance of the other plate's far side.
fn keep_nearer_plate(pairs: &mut Vec<ContactPair>, finger: usize, state: &State) {
    let wall = |pair: &ContactPair| match pair.part.map(|part| part.touched) {
        Some(TouchedPart::On(wall @ (Wall::Front | Wall::Back), _)) if pair.key.0 == finger => Some(wall),
        _ => None,
    };
    let is_corner = |pair: &ContactPair| matches!(pair.pair.meeting, Meeting::PieceAndCorner { .. });
    let off_axis_mm = |pair: &ContactPair| (pair.touching.gap_mm + pair.pair.radius_mm + pair.pair.disc_mm).abs();
    let is_far = |pair: &ContactPair| {
        let is_loaded = state.forces.get(&pair.key).is_some_and(|forces| *forces != [0.0; 2]);
        let is_candidate = pair.touching.gap_mm < 0.0 && is_corner(pair) && wall(pair).is_some() && !is_loaded;
        let is_nearer = |other: &ContactPair| {
            other.key.2 == pair.key.2
                && is_corner(other)
                && wall(other).is_some_and(|other| Some(other) != wall(pair))
                && off_axis_mm(other) < off_axis_mm(pair)
        };
        is_candidate && pairs.iter().any(is_nearer)
    };
    let far: Vec<Key> = pairs.iter().filter(|pair| is_far(pair)).map(|pair| pair.key).collect();
    if !far.is_empty() {
        pairs.retain(|pair| !far.contains(&pair.key));
    }
}

/// Unloaded pairs on consecutive pieces of the plate that would close beside a pair with a deeper overlap. When the plate moves out of the deepest
/// overlap, the other pairs mostly open. Closing all overlapping pairs at once would bend the plate without cause.
fn beside_deepest(
    pairs: &[ContactPair],
    forces: &BTreeMap<Key, [f64; 2]>,
    statuses: &BTreeMap<Key, ContactStatus>,
) -> Vec<Key> {
    let closes = |pair: &&ContactPair| {
        let is_piece = pair.part.is_some_and(|part| matches!(part.touched, TouchedPart::On(..)));
        is_piece && forces[&pair.key] == [0.0; 2] && statuses[&pair.key].grip.is_some()
    };
    let closing: Vec<&ContactPair> = pairs.iter().filter(closes).collect();
    // In the list of parts, the point at a piece's first end precedes the piece; the next piece, with a point before it or not, follows.
    let follows = |a: &&ContactPair, b: &&ContactPair| a.key.0 == b.key.0 && b.key.1 - a.key.1 <= 2;
    let mut shallow = Vec::new();
    for run in closing.chunk_by(follows) {
        let deepest = run.iter().map(|pair| pair.touching.gap_mm).fold(f64::INFINITY, f64::min);
        shallow.extend(run.iter().filter(|pair| pair.touching.gap_mm > deepest).map(|pair| pair.key));
    }
    shallow
}
