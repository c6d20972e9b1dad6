//! Fingers on moving bases with an object and its support. The bases move in increments, and each equilibrium is computed from the previous one.

mod account;
mod clearance;
mod ends;
mod motion;
mod observed;

pub use account::Account;
pub use ends::{GraspFailure, ObjectContact, TouchedBody, WorldError};

use crate::outline::{ContactOutline, PoseInFinger};
use crate::region::{Boundary, Region, boundaries};
use crate::scene::{PlacedFinger, Scene, State, Surroundings};
use crate::status::{ContactPair, touched};
use crate::{ContactError, TouchedPart, overlap};
use account::Acting;
use finray_model::frame::FrameMotion;
use finray_model::gripper::Placement;
use finray_model::{Mesh, Vector};
use motion::AT_REST;

/// A finger counts as folded if one of its nodes rotates by more than this, rad. The nodes of a finger that wraps an object rotate by half of this
/// limit.
const FOLDED_RAD: f64 = 1.0;

/// Placements of the fingers, and weight of the object, at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Placements of the fingers' frames in the world.
    pub placements: Vec<Placement>,
    /// Weight of the object, world frame, N.
    pub weight: Vector,
    /// Position of the gripper, world frame, mm; an object held by the fingers is assumed to move with the gripper.
    pub gripper: Vector,
}

impl Drive {
    /// Interpolates towards another `Drive` with the same fingers; `share` is from 0 to 1.
    fn towards(&self, to: &Drive, share: f64) -> Drive {
        let between = |(from, to): (&Placement, &Placement)| Placement {
            origin: from.origin.lerp(&to.origin, share),
            angle_rad: from.angle_rad + (to.angle_rad - from.angle_rad) * share,
            mirrored: from.mirrored,
        };
        Drive {
            placements: self.placements.iter().zip(&to.placements).map(between).collect(),
            weight: self.weight.lerp(&to.weight, share),
            gripper: self.gripper.lerp(&to.gripper, share),
        }
    }
}

/// Fingers, object and support in equilibrium.
#[derive(Debug, Clone)]
pub struct World<'m> {
    scene: Scene<'m>,
    support: Option<(Vector, Vector)>,
    now: Moment,
}

/// Everything that changes during a grasp.
#[derive(Debug, Clone)]
pub(crate) struct Moment {
    state: State,
    /// State before the last solved increment; slips are counted from it.
    before: State,
    drive: Drive,
    acting: Acting,
    account: Account,
}

impl<'m> World<'m> {
    /// Places an object at `[x, y, angle]`, mm and rad, between undeformed fingers. A point (mm) and the upward unit normal define the support.
    ///
    /// # Errors
    /// [`WorldError::Overlap`] if the object overlaps a finger or the support; [`WorldError::Finger`] if a finger cannot be used for contact.
    pub fn new(
        meshes: &[&'m Mesh],
        rod_radius_mm: f64,
        (shape, friction): (ContactOutline, f64),
        object: [f64; 3],
        drive: Drive,
        support: Option<(Vector, Vector)>,
    ) -> Result<World<'m>, WorldError> {
        let pose = |placement: &Placement| PoseInFinger::new(placement, object);
        let placed = meshes.iter().zip(&drive.placements);
        let fingers: Vec<PlacedFinger> = placed
            .map(|(mesh, placement)| {
                PlacedFinger::new(mesh, rod_radius_mm, pose(placement).point(shape.corners().0[0]))
            })
            .collect::<Result<_, ContactError>>()?;
        let stiffness = fingers.iter().map(|finger| finger.stiffness).fold(f64::INFINITY, f64::min);
        let motions = meshes.iter().map(|mesh| FrameMotion::at_rest(mesh.frame())).collect();
        let state = State { placements: drive.placements.clone(), motions, object, forces: Default::default() };
        let (centre, size_mm) = (shape.centroid(), shape.size_mm());
        let scene = Scene { fingers, shape, friction, centre, stiffness, size_mm, held: [false; 3] };
        let (acting, account) = (Acting::default(), Account::default());
        let now = Moment { before: state.clone(), state, drive, acting, account };
        let mut world = World { scene, support, now };
        world.now.acting = world.acting(&world.surroundings(), &[]);
        let of_pair = |pair: ContactPair| {
            (world.partner(&pair), pair.part.map(|part| touched(&part, &pair.pair)), -pair.touching.gap_mm)
        };
        let of_walls = |finger: usize| {
            let (part, overlap_mm) = world.overlap(finger, &boundaries(meshes[finger]))?;
            Some((TouchedBody::Finger(finger), Some(part), overlap_mm))
        };
        let overlaps = world.near_pairs().into_iter().map(of_pair).chain((0..meshes.len()).filter_map(of_walls));
        match overlaps.max_by(|a, b| a.2.total_cmp(&b.2)) {
            Some((what, part, overlap_mm)) if overlap_mm > AT_REST * size_mm => {
                Err(WorldError::Overlap { what, part, overlap_mm })
            }
            _ => Ok(world),
        }
    }

    /// Deepest overlap of the object with members of a deformed finger: the touched part, and the depth, mm.
    fn overlap(&self, finger: usize, members: &[Boundary]) -> Option<(TouchedPart, f64)> {
        let pose = PoseInFinger::new(&self.now.state.placements[finger], self.now.state.object);
        let standing = (self.scene.fingers[finger].mesh, &self.now.state.motions[finger]);
        overlap::deepest(standing, (&self.scene.shape, &pose), members.iter())
    }

    /// The wall of a finger that the object reaches although contact with this wall is not modelled.
    pub(crate) fn reached(&self, finger: usize) -> Option<TouchedPart> {
        let overlap = self.overlap(finger, &self.scene.fingers[finger].surface.unmodelled);
        overlap.filter(|(_, overlap_mm)| *overlap_mm > AT_REST * self.scene.size_mm).map(|(part, _)| part)
    }

    /// Whether the object lies between the walls of a finger.
    pub fn is_inside(&self, finger: usize) -> bool {
        self.scene.fingers[finger].surface.region != Region::Outside
    }

    /// Lets a hand hold the object against all motion. `size_mm` then replaces the object's size as the length scale. The size of a held object does
    /// not determine the displacements.
    pub fn holding(mut self, size_mm: f64) -> World<'m> {
        self.scene.size_mm = size_mm;
        self.hold([true; 3]);
        self
    }

    /// Sets whether the hand holds the object against motion in x, motion in y, and rotation.
    pub fn hold(&mut self, held: [bool; 3]) {
        self.scene.held = held;
    }

    /// Moves the fingers' bases, applies the weight, and brings everything to rest.
    ///
    /// # Errors
    /// [`GraspFailure`] if no equilibrium is reached; fingers and object then return to their previous equilibrium.
    pub fn advance(&mut self, to: &Drive) -> Result<(), GraspFailure> {
        self.attempt(|world| world.move_to(to).and_then(|()| world.rest()))
    }

    /// Moves the fingers' bases and applies the weight, without waiting for rest. While the bases move, only numerical resistance holds an object
    /// without contact.
    ///
    /// # Errors
    /// As for [`advance`](Self::advance).
    pub fn pass(&mut self, to: &Drive) -> Result<(), GraspFailure> {
        self.attempt(|world| world.move_to(to))
    }

    /// Everything that changes during a grasp, at present.
    pub(crate) fn moment(&self) -> Moment {
        self.now.clone()
    }

    /// Returns to an earlier moment.
    pub(crate) fn restore(&mut self, moment: Moment) {
        self.now = moment;
    }

    fn attempt(&mut self, moves: impl FnOnce(&mut Self) -> Result<(), GraspFailure>) -> Result<(), GraspFailure> {
        let start = self.now.clone();
        let outcome = moves(self);
        if outcome.is_err() {
            self.now = start;
        }
        outcome
    }

    /// Reason why the last increment has no solution.
    fn failure(&self) -> GraspFailure {
        if self.is_folded() {
            GraspFailure::Folded
        } else if self.contacts().iter().any(|contact| matches!(contact.partner, TouchedBody::Finger(_))) {
            GraspFailure::Jammed
        } else {
            GraspFailure::Dropped
        }
    }

    /// Whether a node of any finger has rotated so far that the finger counts as folded.
    pub fn is_folded(&self) -> bool {
        self.now.state.motions.iter().any(|motion| motion.largest_rotation() > FOLDED_RAD)
    }

    fn near_pairs(&self) -> Vec<ContactPair> {
        self.scene.near_pairs(&self.now.state, &self.now.before, &self.surroundings())
    }

    /// Loads on the object at rest, without numerical resistance.
    fn surroundings(&self) -> Surroundings {
        Surroundings {
            weight: self.now.drive.weight,
            support: self.support,
            carried: Vector::zeros(),
            drag: 0.0,
            finger_drag: 0.0,
        }
    }

    fn partner(&self, pair: &ContactPair) -> TouchedBody {
        if pair.part.is_some() { TouchedBody::Finger(pair.key.0) } else { TouchedBody::Support }
    }

    /// Force (N) on the base of each finger, and moment (N mm) about the origin of the finger's frame; both in the world frame.
    fn on_bases(&self, pairs: &[ContactPair]) -> Vec<(Vector, f64)> {
        let on_base = |(finger, placement): (usize, &Placement)| {
            let (force, moment_nmm) = self.on_base_with(finger, pairs);
            (placement.axes() * force, if placement.mirrored { -moment_nmm } else { moment_nmm })
        };
        self.now.state.placements.iter().enumerate().map(on_base).collect()
    }
}
