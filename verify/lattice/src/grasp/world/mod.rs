//! Fingers on bases that move, an object and its support: from one settled step to the next.

mod account;
mod clearance;
mod ends;
mod motion;
mod observed;

pub use account::Account;
pub use ends::{GraspFailure, ObjectContact, TouchedBody, WorldError};

use super::near::ContactPair;
use super::scene::{PlacedFinger, Scene, State, Surroundings};
use super::surface::Shape;
use crate::energy::BodyMotion;
use crate::skin::require_one_thickness;
use crate::{Lattice, LatticeError};
use account::Acting;
use finray_model::Vector;
use finray_model::gripper::Placement;
use finray_model::mesh::Load;
use motion::{AT_REST, BOLDER, FIRST_DRAG};

/// A finger of which a part turns further than this, rad, folds: one that wraps an object turns half as far, one of which a plate buckles more.
const FOLDED_RAD: f64 = 1.0;

/// Where the fingers stand and what acts on the object.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The fingers' frames in the world.
    pub placements: Vec<Placement>,
    /// Weight, N.
    pub weight: Vector,
    /// Where the gripper is, mm: an object that it holds goes along.
    pub gripper: Vector,
}

impl Drive {
    /// A share of the way to another drive; both have the same fingers.
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

/// Fingers, object and support at rest.
#[derive(Debug, Clone)]
pub struct World<'l> {
    scene: Scene<'l>,
    state: State,
    /// The state before the last step that was solved: slips count from there.
    before: State,
    drive: Drive,
    support: Option<(Vector, Vector)>,
    acting: Acting,
    account: Account,
}

impl<'l> World<'l> {
    /// Puts an object, `[x, y, angle]` in mm and rad, between fingers at rest. The support is a point and its upward unit normal.
    ///
    /// # Errors
    /// [`WorldError`] for an object that overlaps a finger or the support.
    pub fn new(
        lattices: &[&'l Lattice],
        rod_radius_mm: f64,
        (shape, friction): (Shape, f64),
        object: [f64; 3],
        drive: Drive,
        support: Option<(Vector, Vector)>,
    ) -> Result<World<'l>, WorldError> {
        let mut stiffness = f64::INFINITY;
        let mut fingers = Vec::new();
        for &lattice in lattices {
            require_one_thickness(lattice)?;
            stiffness = stiffness.min(middle_stiffness(lattice)?);
            fingers.push(PlacedFinger::new(lattice, rod_radius_mm));
        }
        let motions = lattices.iter().map(|lattice| vec![BodyMotion::default(); lattice.assembly().bodies.len()]);
        let placements = drive.placements.clone();
        let state = State { placements, motions: motions.collect(), object, forces: Default::default() };
        let (centre, size_mm) = (shape.centroid(), shape.size_mm());
        let scene = Scene { fingers, shape, friction, centre, stiffness, size_mm, held: [false; 3] };
        let mut world = World {
            scene,
            before: state.clone(),
            state,
            drive,
            support,
            acting: Acting::default(),
            account: Account::default(),
        };
        world.acting = world.acting(&world.surroundings());
        let overlaps = world.near_pairs().into_iter().map(|pair| (-pair.touching.gap_mm, pair));
        match overlaps.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((overlap_mm, pair)) if overlap_mm > AT_REST * size_mm => {
                Err(WorldError::Overlap { what: world.partner(&pair), overlap_mm })
            }
            _ => Ok(world),
        }
    }

    /// The same with an object that a hand holds where it is. By `size_mm`, instead of the object's size, lengths are judged: a large object does not move by
    /// a share of its size, and a small one moves the finger by more.
    pub fn holding(mut self, size_mm: f64) -> World<'l> {
        self.scene.size_mm = size_mm;
        for finger in &mut self.scene.fingers {
            finger.front = finger.front.clone().round_at_both_ends();
        }
        self.hold([true; 3]);
        self
    }

    /// Lets the hand hold the object where it is in x and y, and keep it from turning, each if asked.
    pub fn hold(&mut self, held: [bool; 3]) {
        self.scene.held = held;
    }

    /// Moves the fingers' bases and the weight, and lets all come to rest.
    ///
    /// # Errors
    /// [`GraspFailure`]; fingers and object are then where they last were at rest.
    pub fn advance(&mut self, to: &Drive) -> Result<(), GraspFailure> {
        self.attempt(|world| world.move_to(to).and_then(|()| world.come_to_rest(FIRST_DRAG, BOLDER)))
    }

    /// Moves the fingers' bases and the weight. An object that nothing holds is then where the resistance against its motion left it.
    ///
    /// # Errors
    /// As of [`advance`](Self::advance).
    pub fn pass(&mut self, to: &Drive) -> Result<(), GraspFailure> {
        self.attempt(|world| world.move_to(to))
    }

    fn attempt(&mut self, moves: impl FnOnce(&mut Self) -> Result<(), GraspFailure>) -> Result<(), GraspFailure> {
        let start = self.clone();
        let outcome = moves(self);
        if outcome.is_err() {
            *self = start;
        }
        outcome
    }

    /// What keeps the last step from being solved.
    fn failure(&self) -> GraspFailure {
        if self.is_folded() {
            GraspFailure::Folded
        } else if self.contacts().iter().any(|contact| matches!(contact.partner, TouchedBody::Finger(_))) {
            GraspFailure::Jammed
        } else {
            GraspFailure::Dropped
        }
    }

    /// Whether a finger has folded.
    pub fn is_folded(&self) -> bool {
        self.state.motions.iter().flatten().any(|motion| motion.rotation.abs() > FOLDED_RAD)
    }

    fn near_pairs(&self) -> Vec<ContactPair> {
        self.scene.near_pairs(&self.state, &self.before, &self.surroundings())
    }

    /// What acts on the object at rest.
    fn surroundings(&self) -> Surroundings {
        Surroundings {
            weight: self.drive.weight,
            support: self.support,
            carried: Vector::zeros(),
            drag: 0.0,
            finger_drag: 0.0,
        }
    }

    fn partner(&self, pair: &ContactPair) -> TouchedBody {
        if pair.part.is_some() { TouchedBody::Finger(pair.key.0) } else { TouchedBody::Support }
    }

    /// Force and moment about its frame's origin on the base of each finger, world, N and N mm.
    fn on_bases(&self) -> Vec<(Vector, f64)> {
        let on_base = |(finger, placement): (usize, &Placement)| {
            let (force, moment_nmm) = self.on_base(finger);
            (placement.axes() * force, if placement.mirrored { -moment_nmm } else { moment_nmm })
        };
        self.state.placements.iter().enumerate().map(on_base).collect()
    }
}

/// Stiffness of a finger's middle at rest, N/mm.
fn middle_stiffness(lattice: &Lattice) -> Result<f64, LatticeError> {
    // A force under which every finger is linear.
    const TINY_N: f64 = 1e-9;
    let finger = lattice.finger();
    let middle = finger.contact_nodes().nth(finger.contact_nodes().len() / 2).unwrap_or(finger.tip());
    let load = Load::at_node(middle, finger.direction(0.0) * TINY_N);
    let moved_mm = lattice.equilibrium(&[load])?.largest_displacement_mm();
    Ok(TINY_N / moved_mm)
}
