//! An object pressed onto a finger: a sequence of quasi-static equilibria with Coulomb friction.
//!
//! The object is rigid and does not rotate. It starts outside the finger or between two ribs, and touches the walls that face it; contact of the finger
//! with itself is not modelled. A "hand" (the imposed motion or force) moves the object to a prescribed position, or pulls the object along a line. An object that is
//! moved into the clamped end of the plate stops there. Every step is an equilibrium of one finger and a held object. The hand moves in short
//! increments, because friction depends on the whole path.

use crate::outline::ContactOutline;
use crate::world::{Drive, GraspFailure, Moment, World, WorldError};
use crate::{ContactError, Touch};
use finray_model::finger::Plate;
use finray_model::gripper::Placement;
use finray_model::mesh::FingerShape;
use finray_model::{Mesh, Vector};

/// Position of the hand, or the force with which the hand pulls the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Push {
    /// The hand holds the object's reference point at this position, finger frame, mm.
    To(Vector),
    /// The hand pulls the object along the pressing line with this force, N, and keeps the object on that line.
    With(f64),
}

impl Push {
    /// Interpolates between `self` and `to`, at `share` from 0 (`self`) to 1 (`to`).
    pub fn towards(self, to: Push, share: f64) -> Push {
        match (self, to) {
            (Push::To(from), Push::To(to)) => Push::To(from + (to - from) * share),
            (Push::With(from), Push::With(to)) => Push::With(from + (to - from) * share),
            (Push::To(_), Push::With(to)) => Push::With(to * share),
            (Push::With(_), Push::To(to)) => Push::To(to),
        }
    }
}

/// Finger and object in equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Pressed {
    /// Displacements and rotations of the key nodes (ends of plates and ribs), finger frame, mm and rad.
    pub shape: FingerShape,
    /// Reference point of the object, finger frame, mm.
    pub object: Vector,
    /// Contacts of the object with the finger.
    pub touches: Vec<Touch>,
    /// Force of the hand on the object, N, finger frame.
    pub hand_force: Vector,
    /// Force on the clamps, N, finger frame: from the plates, and from the object if the object touches a clamped part.
    pub base_force: Vector,
    /// Moment on the clamps about the origin, N mm.
    pub base_moment_nmm: f64,
}

impl Pressed {
    /// Sum of the contact forces on the finger, N, finger frame.
    pub fn contact_force(&self) -> Vector {
        self.touches.iter().map(|touch| touch.force).sum()
    }

    /// Force imbalance relative to the contact force. The contact force should equal both the hand's force and the force on the clamps; the larger of the two
    /// differences counts. `None` if there is no contact.
    pub fn imbalance(&self) -> Option<f64> {
        let contact = self.contact_force();
        let off = |other: Vector| (contact - other).norm() / contact.norm();
        (!self.touches.is_empty()).then(|| off(self.hand_force).max(off(self.base_force)))
    }

    /// Moment of all contact forces about the origin, N mm.
    pub fn contact_moment_nmm(&self) -> f64 {
        self.touches.iter().map(|touch| touch.point.perp(&touch.force)).sum()
    }
}

/// Without friction, the hand moves by at most this share of the front plate's length in one increment.
const WAY: f64 = 1.0 / 75.0;
/// With friction, the hand moves by at most this share of the front plate's length. The error of the friction history is proportional to the increment.
const WAY_WITH_FRICTION: f64 = 1.0 / 300.0;
/// In one increment, the hand also moves by at most this share of the disc-shaped object's radius (0 for a polygon) plus half the smallest thickness of a wall.
/// No contact is then overlooked.
const WAY_OF_RADII: f64 = 0.5;
/// Length scale of displacements for tolerances, as a share of the front plate's length.
const SIZE: f64 = 1.0 / 8.0;
/// Number of bisection steps that find the position at which the clamp stops a held object.
const HALVINGS: usize = 40;

/// A finger with an object outside it or between its ribs.
pub struct Pressing<'m> {
    /// Finger and object, in a frame whose x axis is the line along which the object is pressed.
    world: World<'m>,
    /// Largest displacement of the hand in one increment, mm.
    way_mm: f64,
    last: Push,
    has_touched: bool,
}

impl<'m> Pressing<'m> {
    /// Places an object (shape, coefficient of friction) clear of the finger; the object's reference point is at `start` (mm, finger frame). The
    /// object will be pressed along the unit vector `along`.
    ///
    /// # Errors
    /// [`ContactError::Overlap`] if the object overlaps the finger at the start; [`ContactError::Tapered`] if the front plate tapers.
    pub fn new(
        mesh: &'m Mesh,
        rod_radius_mm: f64,
        (shape, friction): (ContactOutline, f64),
        start: Vector,
        along: Vector,
    ) -> Result<Pressing<'m>, ContactError> {
        let description = mesh.finger().description();
        let length_mm = mesh.finger().plate_length_mm(Plate::Front);
        let turn_rad = -along.y.atan2(along.x);
        let disc_mm = shape.corners().1;
        let way_mm = if friction > 0.0 { WAY_WITH_FRICTION } else { WAY } * length_mm;
        let drive = still(placed(turn_rad, start), 0.0);
        let object = [0.0, 0.0, turn_rad];
        let world = World::new(&[mesh], rod_radius_mm, (shape, friction), object, drive, None);
        let world = world.map_err(|error| match error {
            WorldError::Overlap { part, overlap_mm, .. } => ContactError::Overlap { part, overlap_mm },
            WorldError::Finger(error) => error,
        })?;
        let ribs = description.ribs.strip.filter(|_| world.is_inside(0));
        let walls = [Some(description.front), Some(description.back), ribs].into_iter().flatten();
        let radii_mm = disc_mm + 0.5 * walls.map(|wall| wall.thickness_mm).fold(f64::INFINITY, f64::min);
        Ok(Pressing {
            world: world.holding(SIZE * length_mm),
            way_mm: way_mm.min(WAY_OF_RADII * radii_mm),
            last: Push::To(start),
            has_touched: false,
        })
    }

    /// Moves the hand to a new position, or changes its pull, without waiting for a pulled object to come to rest.
    ///
    /// # Errors
    /// [`ContactError::LetGo`] if the finger does not hold the object against the pull; [`ContactError::NoEquilibrium`] if no equilibrium is
    /// found.
    pub fn pass(&mut self, push: Push) -> Result<(), ContactError> {
        let from = self.last;
        let parts = (self.parts(from, push).ceil() as usize).max(1);
        for part in 1..=parts {
            self.go(from.towards(push, part as f64 / parts as f64), part == parts)?;
        }
        Ok(())
    }

    /// Moves the hand to a new position, or changes its pull, and brings finger and object to rest.
    ///
    /// # Errors
    /// As for [`pass`](Self::pass).
    pub fn push(&mut self, push: Push) -> Result<Pressed, ContactError> {
        self.pass(push)?;
        Ok(self.pressed(push))
    }

    /// Finger and object at rest after the hand's last motion.
    fn pressed(&self, push: Push) -> Pressed {
        let outwards = self.placement().axes().transpose();
        let touches: Vec<Touch> = self.world.contacts().iter().filter_map(|contact| contact.touch).collect();
        let contact: Vector = touches.iter().map(|touch| touch.force).sum();
        let in_world = self.placement().axes() * contact;
        let along_n = if let Push::With(force_n) = push { force_n } else { in_world.x };
        let (base_force, base_moment_nmm) = self.world.on_base(0);
        Pressed {
            shape: self.world.finger_shape(0),
            object: self.object(),
            hand_force: outwards * Vector::new(along_n, in_world.y),
            touches,
            base_force,
            base_moment_nmm,
        }
    }

    /// Finger and object at present, from which [`push_near`](Self::push_near) starts on a finer mesh.
    pub(crate) fn moment(&self) -> Moment {
        self.world.moment()
    }

    /// Brings finger and object to rest near `there`, an equilibrium under the same push on `coarse`, a mesh with half as many elements per member.
    /// `None` if no equilibrium is found there; nothing has changed then. Without friction, the equilibrium does not depend on the path.
    pub(crate) fn push_near(&mut self, coarse: &Pressing, there: &Moment, push: Push) -> Option<Pressed> {
        let before = self.moment();
        self.world.take_from(&coarse.world, there);
        let gone = match push {
            Push::To(at) => {
                self.world.hold([true; 3]);
                self.world.meet(&still(self.placement_towards(at), 0.0))
            }
            Push::With(force_n) => {
                self.world.hold([false, true, true]);
                self.world.meet(&still(self.placement(), force_n)).and_then(|()| self.world.rest())
            }
        };
        if gone.is_err() || self.world.reached(0).is_some() {
            self.world.restore(before);
            return None;
        }
        self.last = push;
        self.has_touched |= coarse.has_touched;
        Some(self.pressed(push))
    }

    /// Number of increments (not rounded) in which the hand moves to another position or changes its pull.
    fn parts(&self, from: Push, to: Push) -> f64 {
        let by_force = |change_n: f64| change_n.abs() / (self.world.stiffness() * self.way_mm);
        match (from, to) {
            (Push::To(from), Push::To(to)) => (to - from).norm() / self.way_mm,
            (Push::With(from), Push::With(to)) => by_force(to - from),
            (Push::To(_), Push::With(to)) => by_force(to),
            (Push::With(_), Push::To(to)) => (to - self.object()).norm() / self.way_mm,
        }
    }

    fn placement(&self) -> Placement {
        self.world.placements()[0]
    }

    /// Reference point of the object, finger frame, mm.
    fn object(&self) -> Vector {
        let [x, y, _] = self.world.object();
        self.placement().inwards(Vector::new(x, y))
    }

    /// Moves the hand by one increment.
    fn go(&mut self, to: Push, is_last: bool) -> Result<(), ContactError> {
        let gone = match to {
            Push::To(at) => {
                self.world.hold([true; 3]);
                self.world.pass(&still(self.placement_towards(at), 0.0))
            }
            Push::With(force_n) => {
                self.world.hold([false, true, true]);
                let drive = still(self.placement(), force_n);
                if is_last { self.world.advance(&drive) } else { self.world.pass(&drive) }
            }
        };
        self.has_touched |= self.world.contacts().iter().any(|contact| contact.touch.is_some());
        if let Some(part) = self.world.reached(0) {
            return Err(ContactError::Unmodelled { part });
        }
        match (gone, to) {
            (Ok(()), _) => {
                self.last = to;
                Ok(())
            }
            (Err(_), Push::With(force_n)) => {
                Err(ContactError::LetGo { touched_n: self.has_touched.then_some(force_n) })
            }
            (Err(failure), _) => Err(ContactError::NoEquilibrium { is_folded: failure == GraspFailure::Folded }),
        }
    }

    /// Placement of the finger that brings the object to the point `at` (mm, finger frame). If the clamped end is in the way, the object is as near
    /// to the point as possible.
    fn placement_towards(&self, at: Vector) -> Placement {
        let (from, [x, y, _]) = (self.placement(), self.world.object());
        let to = Placement { origin: placed(from.angle_rad, at).origin + Vector::new(x, y), ..from };
        let between = |share: f64| Placement { origin: from.origin.lerp(&to.origin, share), ..from };
        // An object that is stopped may be far from the hand's position, which may even be clear of the clamp on the other side.
        let checks = ((to.origin - from.origin).norm() / self.way_mm).ceil().max(1.0);
        let is_stopped = |check: &usize| self.world.meets_clamp(0, &between(*check as f64 / checks));
        let Some(stop) = (1..=checks as usize).find(is_stopped) else { return to };
        let (mut clear, mut part) = ((stop - 1) as f64 / checks, 1.0 / checks);
        for _ in 0..HALVINGS {
            part *= 0.5;
            if !self.world.meets_clamp(0, &between(clear + part)) {
                clear += part;
            }
        }
        between(clear)
    }
}

/// A finger at rest at a placement, and an object that is pulled along the x axis of the world, N.
fn still(placement: Placement, pull_n: f64) -> Drive {
    Drive { placements: vec![placement], weight: Vector::new(pull_n, 0.0), gripper: Vector::zeros() }
}

/// Placement of a finger, rotated by `angle_rad`, in which `point` (mm, finger frame) lies at the origin.
fn placed(angle_rad: f64, point: Vector) -> Placement {
    let turned = Placement { origin: Vector::zeros(), angle_rad, mirrored: false };
    Placement { origin: -(turned.axes() * point), ..turned }
}
