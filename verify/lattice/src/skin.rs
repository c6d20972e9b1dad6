//! Contact surface of a lattice in rapier: a disc at every rod of the front plate, and capsules along both plates.

use super::bodies::BodyLoad;
use super::energy::{BodyMotion, Energy};
use super::settling::{Dynamics, rapier};
use super::springs::BodyIndex;
use super::{Lattice, LatticeError};
use finray_contact::{ContactError, Touch, TouchedPart, Wall};
use finray_model::finger::{FingerPoint, Plate, PlatePosition};
use finray_model::mesh::{FingerShape, Load};
use finray_model::{NodeId, Vector};
use rapier2d::prelude::{CoefficientCombineRule, ColliderBuilder, Group, InteractionGroups, InteractionTestMode};

/// Part of the finger that a collider represents.
#[derive(Clone, Copy)]
pub(crate) enum Skin {
    Rod(NodeId),
    /// A piece of a plate. The fields give the start of the piece, as position on the plate and as vector from the body's centre (mm).
    Plate {
        from: PlatePosition,
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
/// [`ContactError::Tapered`] if the plate tapers.
pub(crate) fn require_one_thickness(lattice: &Lattice) -> Result<(), LatticeError> {
    if lattice.finger().tapers(Plate::Front) { Err(ContactError::Tapered.into()) } else { Ok(()) }
}

/// Adds the contact surface to the rapier world: a disc at every rod of the front plate, and capsules along both plates.
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
    for plate in [Plate::Front, Plate::Back] {
        for piece in assembly.plate_pieces(plate) {
            let half_mm = 0.5 * finger.thickness_mm(plate, piece.from_mm);
            let [from, to] = piece.ends.map(rapier);
            let part = Skin::Plate { from: PlatePosition { plate, s_mm: piece.from_mm }, from_arm: piece.ends[0] };
            skin.push((piece.body, part, ColliderBuilder::capsule_from_endpoints(from, to, half_mm)));
        }
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
    /// Loads on the bodies from the contact forces of an object on a finger of the given deformed shape, which another solver has found.
    ///
    /// # Errors
    /// [`LatticeError::Load`] if a touched position is not on the plate, [`LatticeError::OffPlates`] if a rib is touched.
    pub fn contact_loads(&self, touches: &[Touch], shape: &FingerShape) -> Result<Vec<BodyLoad>, LatticeError> {
        let half_mm =
            |wall: Wall, s_mm: f64| wall.plate().map_or(0.0, |plate| 0.5 * self.finger.thickness_mm(plate, s_mm));
        let load = |touch: &Touch| -> Result<Load, LatticeError> {
            Ok(match touch.part {
                TouchedPart::Rod(node) => {
                    let arm = touch.point - shape.point(FingerPoint::Node(node));
                    Load::Node { node, force: touch.force, moment_nmm: arm.perp(&touch.force) }
                }
                TouchedPart::On(wall, s_mm) => {
                    let plate = wall.plate().ok_or(LatticeError::OffPlates)?;
                    Load::at_position(PlatePosition { plate, s_mm }, touch.force)
                }
            })
        };
        let bending: Vec<&Touch> = touches.iter().filter(|touch| !touch.clamped).collect();
        let mut loads = self.body_loads(&bending.iter().map(|touch| load(touch)).collect::<Result<Vec<_>, _>>()?)?;
        // Friction acts on the surface, half a thickness from the axis on which the loads act.
        for touch in bending {
            let TouchedPart::On(wall, s_mm) = touch.part else { continue };
            let friction_nmm = -half_mm(wall, s_mm) * touch.normal.perp(&touch.force);
            let of_touch = loads.iter_mut().find(|load| load.force == touch.force);
            of_touch.into_iter().for_each(|load| load.moment_nmm += friction_nmm);
        }
        Ok(loads)
    }

    /// Motions of the bodies in the equilibrium under loads. Newton's method finds the equilibrium, without contact search or physics engine.
    ///
    /// # Errors
    /// [`LatticeError::NoEquilibrium`] if no stable equilibrium is found.
    pub fn motions_under(&self, loads: &[BodyLoad]) -> Result<Vec<BodyMotion>, LatticeError> {
        let mut motions = vec![BodyMotion::default(); self.assembly.bodies.len()];
        Energy::new(&self.assembly).follow(&mut motions, loads, 0.0, 1.0)?;
        Ok(motions)
    }
}
