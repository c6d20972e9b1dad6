//! Contact surface of a lattice in rapier: a disc at every rod of the front plate, and capsules between the rods.

use super::bodies::BodyLoad;
use super::energy::{BodyMotion, Energy};
use super::settling::{Dynamics, rapier};
use super::springs::BodyIndex;
use super::{Lattice, LatticeError};
use finray_model::finger::Plate;
use finray_model::mesh::FingerShape;
use finray_model::{NodeId, Vector};
use rapier2d::prelude::{CoefficientCombineRule, ColliderBuilder, Group, InteractionGroups, InteractionTestMode};

/// The part of the finger that an object touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TouchedPart {
    /// Rod at a key node of the front plate.
    Rod(NodeId),
    /// Front plate, at this position from its base, mm.
    Plate(f64),
}

impl TouchedPart {
    /// Position along the front plate, mm from its base.
    pub fn position_mm(&self, lattice: &Lattice) -> f64 {
        match *self {
            TouchedPart::Rod(node) => lattice.finger().front_position_mm(node).unwrap_or_default(),
            TouchedPart::Plate(position_mm) => position_mm,
        }
    }
}

/// A point at which the object pushes on the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Body of the lattice that carries the force.
    pub body: BodyIndex,
    /// Touched part of the finger.
    pub part: TouchedPart,
    /// Whether the touched part is clamped; the force then does not bend the finger.
    pub clamped: bool,
    /// Contact point, finger frame, deformed, mm.
    pub point: Vector,
    /// Vector from the body's centre to the contact point, in the undeformed orientation of the body, mm.
    pub arm: Vector,
    /// Unit vector from the object into the finger, finger frame.
    pub normal: Vector,
    /// Force on the finger, N, finger frame.
    pub force: Vector,
    /// Overlap of object and finger, mm; negative for a gap.
    pub overlap_mm: f64,
}

/// Part of the finger that a collider represents.
#[derive(Clone, Copy)]
pub(crate) enum Skin {
    Rod(NodeId),
    /// A piece of plate. The fields give the start of the piece, as position along the plate (mm) and as vector from the body's centre (mm).
    Plate {
        from_mm: f64,
        from_arm: Vector,
    },
}

const FINGER: Group = Group::GROUP_1;
const OBJECT: Group = Group::GROUP_2;

/// Collision groups of a collider. With these groups, the finger touches the object but not itself.
fn groups(own: Group, other: Group) -> InteractionGroups {
    InteractionGroups::new(own, other, InteractionTestMode::And)
}

/// Collision groups of the object, which touches only the finger.
pub(crate) fn groups_of_object() -> InteractionGroups {
    groups(OBJECT, FINGER)
}

/// Checks that the front plate has constant thickness, so that its surface is parallel to its middle line.
///
/// # Errors
/// [`LatticeError::Tapered`] if the plate tapers.
pub(crate) fn require_one_thickness(lattice: &Lattice) -> Result<(), LatticeError> {
    if lattice.finger().tapers(Plate::Front) { Err(LatticeError::Tapered) } else { Ok(()) }
}

/// Adds the contact surface to the rapier world: a disc at every rod of the front plate, and capsules between the rods.
pub(crate) fn add_skin(
    lattice: &Lattice,
    rod_radius_mm: f64,
    friction: f64,
    dynamics: &mut Dynamics,
) -> Vec<(BodyIndex, Skin)> {
    let (finger, assembly) = (lattice.finger(), lattice.assembly());
    let mut skin = Vec::new();
    if rod_radius_mm > 0.0 {
        for node in finger.plate_nodes(Plate::Front).into_iter().filter(|node| finger.junction(*node) == *node) {
            let anchor = assembly.key_nodes[node.0 - 1];
            let ball = ColliderBuilder::ball(rod_radius_mm).translation(rapier(anchor.arm));
            skin.push((anchor.body, Skin::Rod(node), ball));
        }
    }
    let half_mm = 0.5 * finger.description().front.thickness_mm;
    for piece in assembly.front_pieces() {
        let [from, to] = piece.ends.map(rapier);
        let part = Skin::Plate { from_mm: piece.from_mm, from_arm: piece.ends[0] };
        skin.push((piece.body, part, ColliderBuilder::capsule_from_endpoints(from, to, half_mm)));
    }
    let world = &mut dynamics.world;
    skin.into_iter()
        .enumerate()
        .map(|(index, (body, part, collider))| {
            let collider = collider
                .density(0.0)
                .friction(friction)
                .friction_combine_rule(CoefficientCombineRule::Min)
                .collision_groups(groups(FINGER, OBJECT))
                .user_data(index as u128);
            world.colliders.insert_with_parent(collider, dynamics.handles[body], &mut world.bodies);
            (body, part)
        })
        .collect()
}

impl Lattice {
    /// Equilibrium under the forces of the given contacts, applied as fixed loads. Newton's method finds the equilibrium, without contact search or
    /// physics engine. Correct contact forces yield the shape in which the contacts were found.
    ///
    /// # Errors
    /// [`LatticeError::NoEquilibrium`] if no stable equilibrium is found.
    pub fn equilibrium_under(&self, touches: &[Touch]) -> Result<FingerShape, LatticeError> {
        let load = |touch: &Touch| BodyLoad {
            body: touch.body,
            force: touch.force,
            share: 1.0,
            lever: touch.arm,
            moment_nmm: 0.0,
        };
        let loads: Vec<BodyLoad> = touches.iter().map(load).collect();
        let mut motions = vec![BodyMotion::default(); self.assembly.bodies.len()];
        Energy::new(&self.assembly).follow(&mut motions, &loads, 0.0, 1.0)?;
        Ok(self.shape(&motions))
    }
}
