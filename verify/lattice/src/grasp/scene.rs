//! Fingers, object and support, their state, and what acts on the object.

use super::elimination::Order;
use super::surface::{Feature, Front, Shape};
use crate::Lattice;
use crate::energy::{BodyMotion, Energy};
use crate::springs::BodyIndex;
use finray_model::Vector;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// A force is rounding up to this share of what bends a finger by the object's size.
const ROUNDING: f64 = 1e-11;
/// Yield of a contact, as a share of what the finger yields, so that parts of the rigid object that touch the rigid support at two
/// points share friction.
const YIELD: f64 = 1e-6;

/// Which pair of parts: the finger by its number (the support comes after the last), its part, and the object's feature.
pub(super) type Key = (usize, usize, Feature);

/// A finger that stands somewhere.
#[derive(Debug, Clone)]
pub(super) struct PlacedFinger<'l> {
    pub lattice: &'l Lattice,
    pub energy: Energy<'l>,
    pub front: Front,
    /// How its bodies are eliminated.
    pub order: Order,
}

impl<'l> PlacedFinger<'l> {
    /// A finger with rods of a radius, mm.
    pub fn new(lattice: &'l Lattice, rod_radius_mm: f64) -> PlacedFinger<'l> {
        let energy = Energy::new(lattice.assembly());
        let free = |body: BodyIndex| Some(energy.first_unknown(body)? / 3);
        let springs = lattice.assembly().springs.iter();
        let links: Vec<_> =
            springs.map(|spring| Some([free(spring.ends[0].body)?, free(spring.ends[1].body)?])).collect();
        let order = Order::of(energy.unknown_count() / 3, &links);
        PlacedFinger { lattice, energy, front: Front::new(lattice, rod_radius_mm), order }
    }
}

/// All that is there.
#[derive(Debug, Clone)]
pub(super) struct Scene<'l> {
    pub fingers: Vec<PlacedFinger<'l>>,
    pub shape: Shape,
    pub friction: f64,
    /// Centre of mass in the object's frame, mm.
    pub centre: Vector,
    /// A stiffness of the fingers, N/mm.
    pub stiffness: f64,
    /// Size of the object, mm, or of one that a hand holds a share of the finger's.
    pub size_mm: f64,
    /// Whether a hand holds the object where it is in x and y, and keeps it from turning.
    pub held: [bool; 3],
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
}
