//! The surface that a lattice shows to an object: a ball for every rod of the front plate, capsules between.

use super::bodies::BodyLoad;
use super::energy::{BodyMotion, Energy};
use super::settling::{Dynamics, rapier};
use super::springs::BodyIndex;
use super::{Lattice, LatticeError};
use finray_model::finger::Plate;
use finray_model::mesh::FingerShape;
use finray_model::{NodeId, Vector};
use rapier2d::prelude::{CoefficientCombineRule, ColliderBuilder, Group, InteractionGroups, InteractionTestMode};

/// Where on the finger an object touches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TouchedPart {
    /// The rod at a key node of the front plate.
    Rod(NodeId),
    /// The front plate, mm along it from the base.
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

/// One point at which the object pushes on the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Body of the lattice that is pushed.
    pub body: BodyIndex,
    /// The part of the finger.
    pub part: TouchedPart,
    /// Whether the part is clamped, so that the force does not bend the finger.
    pub clamped: bool,
    /// Where, finger frame, deformed, mm.
    pub point: Vector,
    /// From the centre of the body to the point, as if the body had not turned, mm.
    pub arm: Vector,
    /// Unit vector from the object into the finger.
    pub normal: Vector,
    /// Force on the finger, N, finger frame.
    pub force: Vector,
    /// Overlap of object and finger, mm; negative for a gap.
    pub overlap_mm: f64,
}

/// A collider of the finger.
#[derive(Clone, Copy)]
pub(crate) enum Skin {
    Rod(NodeId),
    /// Where the piece begins along the plate (mm), and the same point from the centre of its body.
    Plate {
        from_mm: f64,
        from_arm: Vector,
    },
}

const FINGER: Group = Group::GROUP_1;
const OBJECT: Group = Group::GROUP_2;

/// The finger touches the object alone, not itself.
fn groups(own: Group, other: Group) -> InteractionGroups {
    InteractionGroups::new(own, other, InteractionTestMode::And)
}

/// What the object touches: the finger.
pub(crate) fn groups_of_object() -> InteractionGroups {
    groups(OBJECT, FINGER)
}

/// Checks that the front plate's surface runs along its middle line.
///
/// # Errors
/// [`LatticeError::Tapered`].
pub(crate) fn require_one_thickness(lattice: &Lattice) -> Result<(), LatticeError> {
    if lattice.finger().tapers(Plate::Front) { Err(LatticeError::Tapered) } else { Ok(()) }
}

/// Gives the lattice its surface: a ball at every key node of the front plate, capsules between.
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
    /// Shape of least energy under the forces of touches, kept as they are: if these are right, the shape in which they
    /// were found. Newton's method knows nothing of contact, engine or object.
    ///
    /// # Errors
    /// [`LatticeError::NoEquilibrium`] where there is none.
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
        Energy::new(&self.assembly)
            .follow(&mut motions, &loads, 0.0, 1.0)
            .map_err(|lost| LatticeError::NoEquilibrium { converged_fraction: lost.converged_fraction })?;
        Ok(self.shape(&motions))
    }
}
