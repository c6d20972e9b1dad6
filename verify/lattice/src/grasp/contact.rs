//! Kinematics of one contact: gap, slip, and the effect of its forces on finger and object.
//!
//! The unknowns are displacement and rotation of a body of the finger, in the finger's frame, and the pose of the object in the world. Each formula
//! is written once, for plain and for dual numbers; dual numbers yield the derivatives for Newton's method.

use crate::energy::BodyMotion;
use finray_model::Vector;
use finray_model::gripper::Placement;
use nalgebra::{Matrix2, Vector2};
use num_dual::{Dual64, DualNum};

/// Displacement x, y (mm) and rotation (rad) of the finger's body, then x, y (mm) and angle (rad) of the object.
pub type Unknowns = [f64; 6];

/// Geometry of the two parts in contact, mm. Points of the finger are relative to the body's centre, undeformed; points of the object are in the object's
/// frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pair {
    /// A disc of the finger, and a corner or a disc of the object.
    BallAndCorner {
        /// Centre of the finger's disc, mm.
        centre: Vector,
        /// Corner of the object, or centre of its disc, mm.
        corner: Vector,
        /// Radius of the finger's disc, and radius of the object's disc (0 for a corner), mm.
        radii_mm: [f64; 2],
    },
    /// A disc of the finger and a straight side of the object.
    BallAndSide {
        /// Centre of the finger's disc, mm.
        centre: Vector,
        /// A point of the side, mm.
        on_side: Vector,
        /// Outward unit normal of the side.
        outward: Vector,
        /// Radius of the finger's disc, mm.
        radius_mm: f64,
    },
    /// A flat piece of the finger, and a corner or a disc of the object.
    PieceAndCorner {
        /// A point of the piece's middle line, mm.
        on_piece: Vector,
        /// Unit normal of the piece, towards the object.
        outward: Vector,
        /// Corner of the object, or centre of its disc, mm.
        corner: Vector,
        /// Half the thickness of the piece, and radius of the object's disc (0 for a corner), mm.
        radii_mm: [f64; 2],
    },
}

/// Poses of finger and object at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairPose {
    /// Placement of the finger's frame in the world.
    pub finger: Placement,
    /// Motion of the body in the finger's frame.
    pub body: BodyMotion,
    /// Position of the object, mm, and its angle, rad.
    pub object: [f64; 3],
}

impl PairPose {
    fn unknowns(&self) -> Unknowns {
        let BodyMotion { displacement, rotation } = self.body;
        let [x, y, angle] = self.object;
        [displacement.x, displacement.y, rotation, x, y, angle]
    }
}

/// Gap, slip and location of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touching {
    /// Gap, mm; negative for an overlap.
    pub gap_mm: f64,
    /// Slip of the finger over the object since the reference poses, mm; positive along the normal rotated by +90 degrees.
    pub slip_mm: f64,
    /// Unit vector from the object into the finger, world frame.
    pub normal: Vector,
    /// Contact point on the object's surface, world frame, mm.
    pub point: Vector,
}

/// Generalised forces of a contact, and derivatives with respect to the six unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// Derivatives of the slip, mm per mm and mm per rad.
    pub slip_by: Unknowns,
    /// Generalised forces due to a contact force of 1 N along the normal, and due to a contact force of 1 N along the tangent. Each vector has the
    /// force (N) and moment (N mm) on the body in the finger's frame, then the force and moment on the object in the world frame. The vector for the
    /// normal direction is also the gradient of the gap.
    pub pull: [Unknowns; 2],
    /// Derivatives of both vectors in `pull` with respect to each unknown (mm or rad), one row per unknown.
    pub pull_by: [[Unknowns; 2]; 6],
}

/// A real number or a dual number.
trait Number: DualNum<Primitive = f64> + Copy {}

impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

fn constant<D: Number>(vector: Vector) -> Vector2<D> {
    vector.map(D::from)
}

fn times<D: Number>(matrix: Matrix2<f64>, vector: Vector2<D>) -> Vector2<D> {
    let row = |i: usize| vector.x * matrix[(i, 0)] + vector.y * matrix[(i, 1)];
    Vector2::new(row(0), row(1))
}

fn turned<D: Number>(by: D, vector: Vector2<D>) -> Vector2<D> {
    let (sin, cos) = by.sin_cos();
    Vector2::new(vector.x * cos - vector.y * sin, vector.x * sin + vector.y * cos)
}

fn across<D: Number>(vector: Vector2<D>) -> Vector2<D> {
    Vector2::new(-vector.y, vector.x)
}

fn inner<D: Number>(a: Vector2<D>, b: Vector2<D>) -> D {
    a.x * b.x + a.y * b.y
}

/// Gap, slip, normal and point of a contact, in plain or dual numbers.
struct Evaluated<D> {
    gap: D,
    slip: D,
    normal: Vector2<D>,
    point: Vector2<D>,
    /// Vectors to the contact point, mm: from the body's centre in the finger's frame, and from the object's origin in the world frame.
    arms: [Vector2<D>; 2],
}

impl Pair {
    /// Gap and slip between the object and a body whose undeformed centre is `rest`, mm, finger frame. Slip is zero in the poses `before`, at the start of
    /// the step.
    pub fn touching(&self, rest: Vector, now: &PairPose, before: &PairPose) -> Touching {
        let Evaluated { gap, slip, normal, point, .. } = self.evaluate(rest, &now.finger, now.unknowns(), before);
        Touching { gap_mm: gap, slip_mm: slip, normal, point }
    }

    /// Derivatives of gap and slip, as [`touching`](Self::touching) computes them, and generalised forces.
    pub fn tangent(&self, rest: Vector, now: &PairPose, before: &PairPose) -> Tangent {
        let axes = now.finger.axes();
        let by = |seed: usize| {
            let mut unknowns = now.unknowns().map(Dual64::from);
            unknowns[seed].eps = 1.0;
            let Evaluated { slip, normal, arms, .. } = self.evaluate(rest, &now.finger, unknowns, before);
            let pull = [normal, across(normal)].map(|force| {
                let on_finger = times(axes.transpose(), force);
                let turning = arms.map(across);
                [on_finger.x, on_finger.y, inner(turning[0], on_finger), -force.x, -force.y, -inner(turning[1], force)]
            });
            (slip, pull)
        };
        let all = [0, 1, 2, 3, 4, 5].map(by);
        Tangent {
            slip_by: all.map(|(slip, _)| slip.eps),
            pull: all[0].1.map(|pull| pull.map(|x| x.re)),
            pull_by: all.map(|(_, pull)| pull.map(|pull| pull.map(|x| x.eps))),
        }
    }

    fn evaluate<D: Number>(
        &self,
        rest: Vector,
        finger: &Placement,
        unknowns: [D; 6],
        before: &PairPose,
    ) -> Evaluated<D> {
        let axes = finger.axes();
        let [ux, uy, rotation, x, y, angle] = unknowns;
        let body = constant::<D>(rest) + Vector2::new(ux, uy);
        let (body_world, object) = (constant::<D>(finger.origin) + times(axes, body), Vector2::new(x, y));
        let on_body = |arm: Vector| body_world + times(axes, turned(rotation, constant(arm)));
        let on_object = |point: Vector| object + turned(angle, constant(point));
        // The contact point lies on the surface of the object.
        let (gap, normal, point) = match *self {
            Pair::BallAndCorner { centre, corner, radii_mm: [ball_mm, disc_mm] } => {
                let between = on_body(centre) - on_object(corner);
                let distance = inner(between, between).sqrt();
                let normal = between.map(|x| x / distance);
                (distance - ball_mm - disc_mm, normal, on_object(corner) + normal.map(|x| x * disc_mm))
            }
            Pair::BallAndSide { centre, on_side, outward, radius_mm } => {
                let normal = turned(angle, constant(outward));
                let height = inner(on_body(centre) - on_object(on_side), normal);
                (height - radius_mm, normal, on_body(centre) - normal.map(|x| x * height))
            }
            Pair::PieceAndCorner { on_piece, outward, corner, radii_mm: [half_mm, disc_mm] } => {
                let outward = times(axes, turned(rotation, constant(outward)));
                let height = inner(on_object(corner) - on_body(on_piece), outward);
                (height - half_mm - disc_mm, -outward, on_object(corner) - outward.map(|x| x * disc_mm))
            }
        };
        // Positions, in the poses `before`, of the two material points that are now in contact.
        let arms = [times(axes.transpose(), point - body_world), point - object];
        let (in_body, in_object) = (turned(-rotation, arms[0]), turned(-angle, arms[1]));
        let then = constant::<D>(rest + before.body.displacement) + turned(before.body.rotation.into(), in_body);
        let body_before = constant::<D>(before.finger.origin) + times(before.finger.axes(), then);
        let [x_before, y_before, angle_before] = before.object.map(D::from);
        let object_before = Vector2::new(x_before, y_before) + turned(angle_before, in_object);
        let slip = inner(across(normal), object_before - body_before);
        Evaluated { gap, slip, normal, point, arms }
    }
}
