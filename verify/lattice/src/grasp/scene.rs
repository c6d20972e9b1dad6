//! Fingers, object and support, their state, and the loads on the object.

use super::elimination::Order;
use super::surface::{Feature, Front, Shape};
use crate::Lattice;
use crate::energy::{BodyMotion, Energy};
use crate::springs::BodyIndex;
use finray_model::Vector;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// A contact counts as unloaded below this force, relative to the force that would bend a finger by the object's size.
const ROUNDING: f64 = 1e-11;
/// Compliance of a contact, relative to the finger's compliance. The compliance of contacts determines how friction is shared between two contacts of
/// the rigid object with the rigid support.
const YIELD: f64 = 1e-6;

/// Identifies a contact pair by the index of the finger, the index of its part, and the object's feature. The support has the index after the last finger.
pub(super) type Key = (usize, usize, Feature);

/// A finger with the data that its equilibrium needs: energy, contact surface and elimination order.
#[derive(Debug, Clone)]
pub(super) struct PlacedFinger<'l> {
    /// Bodies and springs.
    pub lattice: &'l Lattice,
    /// Elastic energy of the lattice.
    pub energy: Energy<'l>,
    /// Contact surface of the finger's front.
    pub front: Front,
    /// Order in which the finger's bodies are eliminated.
    pub order: Order,
}

impl<'l> PlacedFinger<'l> {
    /// A finger whose rods have the given radius, mm.
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

/// Data that do not change during a grasp.
#[derive(Debug, Clone)]
pub(super) struct Scene<'l> {
    /// The fingers, the left one first.
    pub fingers: Vec<PlacedFinger<'l>>,
    /// Outline of the object.
    pub shape: Shape,
    /// Coefficient of Coulomb friction, dimensionless.
    pub friction: f64,
    /// Centre of mass in the object's frame, mm.
    pub centre: Vector,
    /// Stiffness of the softest finger, N/mm; the scale for tolerances.
    pub stiffness: f64,
    /// Length scale, mm: the object's size, or a share of the finger's length if a hand holds the object.
    pub size_mm: f64,
    /// Whether a hand holds the object against motion in x, motion in y, and rotation.
    pub held: [bool; 3],
}

/// Placements, motions and contact forces at one instant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct State {
    /// Placement of each finger's frame in the world.
    pub placements: Vec<Placement>,
    /// Motions of each finger's bodies, in the finger's frame.
    pub motions: Vec<Vec<BodyMotion>>,
    /// Position of the object, mm, and its angle, rad, world frame.
    pub object: [f64; 3],
    /// Normal and friction force of each contact pair within the search distance, N.
    pub forces: BTreeMap<Key, [f64; 2]>,
}

/// Numerical resistance, and the loads on the object other than the contact forces of the fingers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surroundings {
    /// Weight of the object, world frame, N.
    pub weight: Vector,
    /// A point of the support (mm) and its upward unit normal, world frame.
    pub support: Option<(Vector, Vector)>,
    /// Displacement of the gripper in this step, mm. The Newton iteration starts with the object displaced by this vector; numerical resistance acts
    /// against further displacement.
    pub carried: Vector,
    /// Numerical resistance to the object's translation since the start of the step, N/mm. Resistance to rotation is this value times the square of the
    /// object's size, in N mm per rad.
    pub drag: f64,
    /// Numerical resistance to the motion of each body in its finger's frame, N/mm. With the numerical resistance, an increment across a snap is
    /// solvable although no equilibrium path crosses the snap.
    pub finger_drag: f64,
}

impl Surroundings {
    /// Pose `[x, y, angle]` (mm, rad) of an object that has moved along with the gripper.
    pub(super) fn carried_from(&self, object: [f64; 3]) -> [f64; 3] {
        let [x, y, angle] = object;
        [x + self.carried.x, y + self.carried.y, angle]
    }
}

impl Scene<'_> {
    /// Largest displacement between two states, mm, of the object or of any body in its finger's frame. A rotation of the object counts as its angle
    /// times the object's size.
    pub(super) fn way_mm(&self, from: &State, to: &State) -> f64 {
        let [x, y, angle] = [0, 1, 2].map(|i| to.object[i] - from.object[i]);
        let bodies = from.motions.iter().flatten().zip(to.motions.iter().flatten());
        let bent = bodies.map(|(a, b)| (b.displacement - a.displacement).norm());
        bent.fold(x.hypot(y).max(angle.abs() * self.size_mm), f64::max)
    }

    /// Numerical resistance of the object in x and y, N/mm, and to rotation, N mm per rad.
    pub(super) fn drags(&self, around: &Surroundings) -> [f64; 3] {
        [around.drag, around.drag, around.drag * self.size_mm * self.size_mm]
    }

    /// Compression of a contact under a force, mm.
    pub(super) fn yield_mm(&self, force_n: f64) -> f64 {
        YIELD / self.stiffness * force_n
    }

    /// Force below which a contact counts as unloaded, N.
    pub(super) fn nothing_n(&self) -> f64 {
        ROUNDING * self.stiffness * self.size_mm
    }

    /// Index of the first unknown of a finger. For the index after the last finger, returns the index of the object's first unknown.
    pub(super) fn first(&self, finger: usize) -> usize {
        self.fingers[..finger].iter().map(|standing| standing.energy.unknown_count()).sum()
    }
}
