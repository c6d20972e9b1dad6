//! Balance of fingers, object and contacts, by Newton's method.
//!
//! Unknown are the motions of all bodies of the fingers, the pose of the object, and for every pair of parts that are near each other the
//! contact's normal and friction force. Signorini's and Coulomb's laws are equations without inequalities (Alart and Curnier 1991): with a
//! stiffness c, a contact is open where normal force minus c gap is negative; it sticks where friction minus c slip is within the cone, and slips
//! otherwise. Newton's method takes each pair for what it looks like and looks again.
//!
//! Reference: Alart, Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods" (Comput. Methods Appl.
//! Mech. Eng. 92, 1991).

use super::elimination::Order;
use super::near::{Grip, Key, Look, Near};
use super::surface::{Front, Shape};
use crate::Lattice;
use crate::bodies::BodyIndex;
use crate::energy::{BodyMotion, Energy};
use finray_model::Vector;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// Newton's method is given up after so many steps; of those that converge 99 in a hundred take fewer.
const MOST_STEPS: usize = 30;
/// It is given up where something has gone this many times as far as it may: of those that converge 99 in a hundred never do.
const ASTRAY: f64 = 2.5;
/// From this step on friction lags behind the normal force by a step: where pairs stick and slip in turn, this mostly ends it.
const LAGGING: usize = 15;
/// Newton's method goes round where pairs look as they did before and its step differs from the one then by no more than this share...
const ROUND: f64 = 1e-3;
/// ...and is not small, as a share of the object's size: small ones may still end.
const ROUND_MM: f64 = 1e-6;
/// Longest step of a body or the object, as a share of the object's size, and rad.
const LONGEST: [f64; 2] = [0.3, 0.2];
/// It has converged when a step moves nothing by more than this share of the object's size.
const CONVERGED: f64 = 1e-11;
/// A force is rounding up to this share of what bends a finger by the object's size.
const ROUNDING: f64 = 1e-11;
/// Overlap of a pair that was missed, as a share of the object's size.
const OVERLAP: f64 = 1e-6;
/// Yield of a contact, as a share of what the finger yields, so that parts of the rigid object that touch the rigid support at two
/// points share friction.
const YIELD: f64 = 1e-6;

/// A finger that stands somewhere.
#[derive(Debug, Clone)]
pub(super) struct Standing<'l> {
    pub lattice: &'l Lattice,
    pub energy: Energy<'l>,
    pub front: Front,
    /// How its bodies are eliminated.
    pub order: Order,
}

impl<'l> Standing<'l> {
    /// A finger with rods of a radius, mm.
    pub fn new(lattice: &'l Lattice, rod_radius_mm: f64) -> Standing<'l> {
        let energy = Energy::new(lattice.assembly());
        let free = |body: BodyIndex| Some(energy.first_unknown(body)? / 3);
        let springs = lattice.assembly().springs.iter();
        let links: Vec<_> =
            springs.map(|spring| Some([free(spring.ends[0].body)?, free(spring.ends[1].body)?])).collect();
        let order = Order::of(energy.unknown_count() / 3, &links);
        Standing { lattice, energy, front: Front::new(lattice, rod_radius_mm), order }
    }
}

/// All that is there.
#[derive(Debug, Clone)]
pub(super) struct Scene<'l> {
    pub fingers: Vec<Standing<'l>>,
    pub shape: Shape,
    pub friction: f64,
    /// Centre of mass in the object's frame, mm.
    pub centre: Vector,
    /// A stiffness of the fingers, N/mm.
    pub stiffness: f64,
    /// Size of the object, mm.
    pub size_mm: f64,
}

/// Where all is, and the forces of contacts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct State {
    pub placements: Vec<Placement>,
    pub motions: Vec<Vec<BodyMotion>>,
    pub object: [f64; 3],
    /// Normal and friction force of each pair that is near, N.
    pub forces: BTreeMap<Key, [f64; 2]>,
}

/// What acts on the object beside the fingers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surroundings {
    /// Weight, N.
    pub weight: Vector,
    /// A point of the support and its upward unit normal.
    pub support: Option<(Vector, Vector)>,
    /// How far the object is carried in the step where it goes along with the gripper, mm: Newton's method begins there, and from there the
    /// resistance counts.
    pub carried: Vector,
    /// Resistance of the object against having moved since the step began, N/mm; against turning it is this times the square of its size.
    pub drag: f64,
    /// The same of each body of the fingers in their own frames, against moving alone: for snaps, which no equilibrium leads through.
    pub finger_drag: f64,
}

impl Surroundings {
    /// Where an object would be that goes along with the gripper.
    pub(super) fn carried_from(&self, object: [f64; 3]) -> [f64; 3] {
        let [x, y, angle] = object;
        [x + self.carried.x, y + self.carried.y, angle]
    }
}

impl Scene<'_> {
    /// Equilibrium with the fingers at `placements`, from a state of which slips are counted, in which nothing has gone farther than `farthest_mm`;
    /// `None` where Newton's method does not arrive there.
    pub(super) fn equilibrium(
        &self,
        before: &State,
        placements: &[Placement],
        around: &Surroundings,
        farthest_mm: f64,
    ) -> Option<State> {
        let mut state =
            State { placements: placements.to_vec(), object: around.carried_from(before.object), ..before.clone() };
        let mut looks: BTreeMap<Key, Look> = BTreeMap::new();
        let mut passed: Vec<(Vec<Option<Grip>>, f64)> = Vec::new();
        for step in 0..MOST_STEPS {
            let near = self.near(&state, before, around);
            state.forces = self.inherited(&state, &near);
            looks = self.looks(&near, &state.forces, &looks);
            let grips: Vec<Option<Grip>> = near.iter().map(|near| looks[&near.key].grip).collect();
            let mut closed = Vec::new();
            for (near, grip) in near.into_iter().zip(&grips) {
                match grip {
                    Some(grip) => closed.push((near, *grip)),
                    None => drop(state.forces.insert(near.key, [0.0; 2])),
                }
            }
            let correction = self.correction(&state, before, around, &closed, step >= LAGGING)?;
            let (share, largest_mm) = self.share(&correction);
            self.apply(&mut state, &closed, &correction, share);
            let way_mm = self.way_mm(before, &state);
            if way_mm > ASTRAY * farthest_mm {
                return None;
            }
            let is_same = passed.last().is_some_and(|(last, _)| *last == grips);
            let is_settled = is_same && looks.values().all(|look| !look.is_pulled);
            if share == 1.0 && largest_mm <= CONVERGED * self.size_mm && is_settled {
                return (way_mm <= farthest_mm && self.is_equilibrium(&mut state, before, around)).then_some(state);
            }
            let goes_round = |(grips_then, then_mm): &(Vec<Option<Grip>>, f64)| {
                *grips_then == grips && (largest_mm - then_mm).abs() <= ROUND * largest_mm
            };
            if largest_mm > ROUND_MM * self.size_mm && passed.iter().skip(LAGGING).any(goes_round) {
                return None;
            }
            passed.push((grips, largest_mm));
        }
        None
    }

    /// Whether nothing overlaps or pulls; forces that are rounding are dropped.
    fn is_equilibrium(&self, state: &mut State, before: &State, around: &Surroundings) -> bool {
        state.forces.retain(|_, [normal_n, _]| normal_n.abs() > self.nothing_n());
        let given_mm = |near: &Near| self.yield_mm(state.forces.get(&near.key).map_or(0.0, |forces| forces[0]));
        let overlaps = |near: &Near| near.touching.gap_mm + given_mm(near) < -OVERLAP * self.size_mm;
        let pulls = state.forces.values().any(|[normal_n, _]| *normal_n < -self.nothing_n());
        !pulls && !self.near(state, before, around).iter().any(overlaps)
    }

    /// How far object (a turn at its size) and fingers in their frames are from one state to another, mm.
    pub(super) fn way_mm(&self, from: &State, to: &State) -> f64 {
        let [x, y, angle] = [0, 1, 2].map(|i| to.object[i] - from.object[i]);
        let bodies = from.motions.iter().flatten().zip(to.motions.iter().flatten());
        let bent = bodies.map(|(a, b)| (b.displacement - a.displacement).norm());
        bent.fold(x.hypot(y).max(angle.abs() * self.size_mm), f64::max)
    }

    /// Resistance of the object by x, y, N/mm, and angle, N mm.
    pub(super) fn drags(&self, around: &Surroundings) -> [f64; 3] {
        [around.drag, around.drag, around.drag * self.size_mm * self.size_mm]
    }

    /// How far a contact gives way under a force, mm.
    pub(super) fn yield_mm(&self, force_n: f64) -> f64 {
        YIELD / self.stiffness * force_n
    }

    /// A force that is rounding, N.
    pub(super) fn nothing_n(&self) -> f64 {
        ROUNDING * self.stiffness * self.size_mm
    }

    /// Number of the first unknown of a finger; of the object for the number after the last.
    pub(super) fn first(&self, finger: usize) -> usize {
        self.fingers[..finger].iter().map(|standing| standing.energy.unknown_count()).sum()
    }

    /// The share of a correction that moves nothing too far, and its largest movement, mm (rotations at the object's size).
    fn share(&self, correction: &[f64]) -> (f64, f64) {
        let object = self.first(self.fingers.len());
        let (mut moved_mm, mut turned_rad) = (0.0_f64, 0.0_f64);
        for motion in correction[..object + 3].chunks(3) {
            moved_mm = moved_mm.max(motion[0].hypot(motion[1]));
            turned_rad = turned_rad.max(motion[2].abs());
        }
        let share = (LONGEST[0] * self.size_mm / moved_mm).min(LONGEST[1] / turned_rad).min(1.0);
        (share, moved_mm.max(turned_rad * self.size_mm))
    }

    fn apply(&self, state: &mut State, closed: &[(Near, Grip)], correction: &[f64], share: f64) {
        for (finger, standing) in self.fingers.iter().enumerate() {
            let first = self.first(finger);
            for (body, motion) in state.motions[finger].iter_mut().enumerate() {
                if let Some(i) = standing.energy.first_unknown(body).map(|i| first + i) {
                    motion.displacement += Vector::new(correction[i], correction[i + 1]) * share;
                    motion.rotation += correction[i + 2] * share;
                }
            }
        }
        let object = self.first(self.fingers.len());
        for i in 0..3 {
            state.object[i] += share * correction[object + i];
        }
        for (k, (near, _)) in closed.iter().enumerate() {
            if let Some(forces) = state.forces.get_mut(&near.key) {
                forces[0] += share * correction[object + 3 + 2 * k];
                forces[1] += share * correction[object + 4 + 2 * k];
            }
        }
    }
}
