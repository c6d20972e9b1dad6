//! An object pressed onto the lattice, in quasi-static equilibrium with Coulomb friction and its history.
//!
//! The object is rigid and does not turn. It touches the front plate and its rods; neither the other plate, nor the finger itself, touches
//! anything. A hand holds it at a prescribed position, or pulls it with a force along a line on which it is guided. Where the clamped end of the plate is in
//! its way, a held object is stopped there, as neither gives way. Every step is an equilibrium of
//! [`grasp`](crate::grasp)'s Newton method, with one finger and a held object. The hand goes there in short parts: friction depends on all of the way.
//!
//! [`settled`] has the same object pressed in rapier, which verifies these equilibria.

pub mod settled;

use super::energy::BodyMotion;
use super::grasp::surface::Shape;
use super::grasp::{Drive, GraspFailure, World, WorldError};
use super::skin::Touch;
use super::{Lattice, LatticeError};
use finray_model::Vector;
use finray_model::finger::Plate;
use finray_model::gripper::Placement;
use finray_model::mesh::FingerShape;

/// Drive of the object along the line that it is pressed on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Push {
    /// The hand holds the object at a point, finger frame, mm.
    To(Vector),
    /// The hand pulls with a force, N; across the line it guides the object.
    With(f64),
}

impl Push {
    /// A share of the way to another push.
    fn towards(self, to: Push, share: f64) -> Push {
        match (self, to) {
            (Push::To(from), Push::To(to)) => Push::To(from + (to - from) * share),
            (Push::With(from), Push::With(to)) => Push::With(from + (to - from) * share),
            (Push::To(_), Push::With(to)) => Push::With(to * share),
            (Push::With(_), Push::To(to)) => Push::To(to),
        }
    }
}

/// Finger and object at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Pressed {
    /// Motion of the key nodes.
    pub shape: FingerShape,
    /// Motion of the lattice's bodies.
    pub motions: Vec<BodyMotion>,
    /// Where the object's own point is, finger frame, mm.
    pub object: Vector,
    /// Where the object pushes on the finger.
    pub touches: Vec<Touch>,
    /// Force of the hand on the object, N.
    pub hand_force: Vector,
    /// Force of the lattice's springs, and of the object where it touches a clamped part, on the clamps, N.
    pub base_force: Vector,
    /// Moment of the same about the origin, N mm.
    pub base_moment_nmm: f64,
}

impl Pressed {
    /// Force of all touches on the finger, N.
    pub fn contact_force(&self) -> Vector {
        self.touches.iter().map(|touch| touch.force).sum()
    }

    /// How far contact forces are from balance with the hand's and with those on the clamps, as a share of their sum; `None` where
    /// nothing touches.
    pub fn imbalance(&self) -> Option<f64> {
        let contact = self.contact_force();
        let off = |other: Vector| (contact - other).norm() / contact.norm();
        (!self.touches.is_empty()).then(|| off(self.hand_force).max(off(self.base_force)))
    }

    /// Moment of all touches about the origin, N mm.
    pub fn contact_moment_nmm(&self) -> f64 {
        self.touches.iter().map(|touch| touch.point.perp(&touch.force)).sum()
    }
}

/// Longest way of the hand in one part, as a share of the front plate's length.
const WAY: f64 = 1.0 / 75.0;
/// The same with friction, where the error of its history falls with the length of the parts.
const WAY_WITH_FRICTION: f64 = 1.0 / 300.0;
/// The same as a share of the radii that meet: no part of the finger gets past the object unseen.
const WAY_OF_RADII: f64 = 0.5;
/// Length by which displacements are judged, as a share of the front plate's length.
const SIZE: f64 = 1.0 / 8.0;
/// Halvings of the part of a way in which a held object meets the clamp.
const HALVINGS: usize = 40;

/// A lattice with an object in front of it.
pub struct Pressing<'l> {
    /// In a frame with x along the line that the object is pressed on.
    world: World<'l>,
    /// Longest way of the hand in one part, mm.
    way_mm: f64,
    last: Push,
    has_touched: bool,
}

impl<'l> Pressing<'l> {
    /// Puts an object, with its coefficient of friction, where it does not yet touch; it is going to be pressed along the unit vector `along`.
    ///
    /// # Errors
    /// [`LatticeError::Overlap`] if it does not start outside the finger.
    pub fn new(
        lattice: &'l Lattice,
        rod_radius_mm: f64,
        (shape, friction): (Shape, f64),
        start: Vector,
        along: Vector,
    ) -> Result<Pressing<'l>, LatticeError> {
        let description = lattice.finger().description();
        let length_mm = lattice.finger().plate_length_mm(Plate::Front);
        let turn_rad = -along.y.atan2(along.x);
        let radii_mm = shape.corners().1 + 0.5 * description.front.thickness_mm;
        let way_mm = if friction > 0.0 { WAY_WITH_FRICTION } else { WAY } * length_mm;
        let drive =
            Drive { placements: vec![placed(turn_rad, start)], weight: Vector::zeros(), gripper: Vector::zeros() };
        let object = [0.0, 0.0, turn_rad];
        let world = World::new(&[lattice], rod_radius_mm, (shape, friction), object, drive, None);
        let world = world.map_err(|error| match error {
            WorldError::Overlap { overlap_mm, .. } => LatticeError::Overlap { overlap_mm },
            WorldError::Lattice(error) => error,
        })?;
        Ok(Pressing {
            world: world.holding(SIZE * length_mm),
            way_mm: way_mm.min(WAY_OF_RADII * radii_mm),
            last: Push::To(start),
            has_touched: false,
        })
    }

    /// Moves the hand, without letting an object that it pulls come to rest.
    ///
    /// # Errors
    /// [`LatticeError::LetGo`] if the finger, on the way, no longer holds against a force; [`LatticeError::NoContactEquilibrium`] if no equilibrium is
    /// found.
    pub fn pass(&mut self, push: Push) -> Result<(), LatticeError> {
        let from = self.last;
        let parts = (self.parts(from, push).ceil() as usize).max(1);
        for part in 1..=parts {
            self.go(from.towards(push, part as f64 / parts as f64), part == parts)?;
        }
        Ok(())
    }

    /// Moves the hand and lets everything come to rest.
    ///
    /// # Errors
    /// As of [`pass`](Self::pass).
    pub fn push(&mut self, push: Push) -> Result<Pressed, LatticeError> {
        self.pass(push)?;
        let outwards = self.placement().axes().transpose();
        let touches: Vec<Touch> = self.world.contacts().iter().filter_map(|contact| contact.touch).collect();
        let contact: Vector = touches.iter().map(|touch| touch.force).sum();
        let in_world = self.placement().axes() * contact;
        let along_n = if let Push::With(force_n) = push { force_n } else { in_world.x };
        let (base_force, base_moment_nmm) = self.world.on_base(0);
        Ok(Pressed {
            shape: self.world.finger_shape(0),
            motions: self.world.motions(0).to_vec(),
            object: self.object(),
            hand_force: outwards * Vector::new(along_n, in_world.y),
            touches,
            base_force,
            base_moment_nmm,
        })
    }

    /// How many of the longest parts a way has.
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

    /// Where the object's own point is, finger frame, mm.
    fn object(&self) -> Vector {
        let [x, y, _] = self.world.object();
        self.placement().inwards(Vector::new(x, y))
    }

    /// One part of the way.
    fn go(&mut self, to: Push, is_last: bool) -> Result<(), LatticeError> {
        let drive = |placement: Placement, pull_n: f64| Drive {
            placements: vec![placement],
            weight: Vector::new(pull_n, 0.0),
            gripper: Vector::zeros(),
        };
        let gone = match to {
            Push::To(at) => {
                self.world.hold([true; 3]);
                self.world.pass(&drive(self.placement_towards(at), 0.0))
            }
            Push::With(force_n) => {
                self.world.hold([false, true, true]);
                let drive = drive(self.placement(), force_n);
                if is_last { self.world.advance(&drive) } else { self.world.pass(&drive) }
            }
        };
        self.has_touched |= self.world.contacts().iter().any(|contact| contact.touch.is_some());
        match (gone, to) {
            (Ok(()), _) => {
                self.last = to;
                Ok(())
            }
            (Err(_), Push::With(force_n)) => {
                Err(LatticeError::LetGo { touched_n: self.has_touched.then_some(force_n) })
            }
            (Err(failure), _) => Err(LatticeError::NoContactEquilibrium { is_folded: failure == GraspFailure::Folded }),
        }
    }

    /// Where the finger stands when the object is at a point of it, mm, or as near on the way there as its clamped end lets the object come.
    fn placement_towards(&self, at: Vector) -> Placement {
        let (from, [x, y, _]) = (self.placement(), self.world.object());
        let to = Placement { origin: placed(from.angle_rad, at).origin + Vector::new(x, y), ..from };
        if !self.world.meets_clamp(0, &to) {
            return to;
        }
        let between = |share: f64| Placement { origin: from.origin.lerp(&to.origin, share), ..from };
        let (mut clear, mut part) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            part *= 0.5;
            if !self.world.meets_clamp(0, &between(clear + part)) {
                clear += part;
            }
        }
        between(clear)
    }
}

/// Placement of a finger, turned by an angle, in which a point of it, mm, is at the origin.
fn placed(angle_rad: f64, point: Vector) -> Placement {
    let turned = Placement { origin: Vector::zeros(), angle_rad, mirrored: false };
    Placement { origin: -(turned.axes() * point), ..turned }
}
