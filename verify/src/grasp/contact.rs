//! Kinematics of one contact: its gap, how far it slipped, and what its forces do to finger and object.
//!
//! Unknowns are the displacement and rotation of a body of the finger, in the finger's frame, and the pose of the object in the world. All is
//! written once, in dual numbers: their derivatives are the tangent of Newton's method.

use crate::lattice::energy::BodyMotion;
use finray_model::Vector;
use finray_model::gripper::Placement;
use nalgebra::Vector2;
use num_dual::{Dual64, DualNum};

/// Displacement x, y and rotation of the finger's body, then x, y and angle of the object.
pub type Unknowns = [f64; 6];

/// What meets what. Points of the finger's body are from its centre, undeformed; points of the object in its own frame; mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pair {
    /// A ball of the finger and a corner of the object, or a disc about its axis.
    BallAndCorner {
        /// Centre of the ball.
        centre: Vector,
        /// The corner.
        corner: Vector,
        /// Radii of the ball and of the disc; that of a corner is nothing.
        radii_mm: [f64; 2],
    },
    /// A ball of the finger and a straight side of the object.
    BallAndSide {
        /// Centre of the ball.
        centre: Vector,
        /// A point of the side.
        on_side: Vector,
        /// Outward unit normal of the side.
        outward: Vector,
        /// Radius of the ball.
        radius_mm: f64,
    },
    /// A flat piece of the finger and a corner of the object, or a disc about its axis.
    PieceAndCorner {
        /// A point of the piece's middle line.
        on_piece: Vector,
        /// Unit normal of the piece, towards the object.
        outward: Vector,
        /// The corner.
        corner: Vector,
        /// Half the piece's thickness, and the radius of the disc.
        radii_mm: [f64; 2],
    },
}

/// Where finger and object were, or are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// The finger's frame in the world.
    pub finger: Placement,
    /// Its body's motion in that frame.
    pub body: BodyMotion,
    /// Position of the object, mm, and its angle, rad.
    pub object: [f64; 3],
}

/// A contact with its derivatives by the six unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touching {
    /// Distance, mm; negative for an overlap.
    pub gap_mm: f64,
    /// How far the finger has slipped over the object since it stood as before, mm, along the normal turned by a quarter.
    pub slip_mm: f64,
    /// Derivatives of the slip.
    pub slip_by: Unknowns,
    /// Generalised forces of 1 N along the normal, and of 1 N across it: on the finger's body and on the object. The first are the gap's
    /// derivatives.
    pub pull: [Unknowns; 2],
    /// Derivatives of both, a row an unknown.
    pub pull_by: [[Unknowns; 2]; 6],
    /// From the object into the finger, world; a unit vector.
    pub normal: Vector,
    /// Where, world, mm.
    pub point: Vector,
}

type Point = Vector2<Dual64>;

fn constant(vector: Vector) -> Point {
    vector.map(Dual64::from)
}

fn turned(by: Dual64, vector: Point) -> Point {
    let (sin, cos) = by.sin_cos();
    Vector2::new(vector.x * cos - vector.y * sin, vector.x * sin + vector.y * cos)
}

fn across(vector: Point) -> Point {
    Vector2::new(-vector.y, vector.x)
}

fn inner(a: Point, b: Point) -> Dual64 {
    a.x * b.x + a.y * b.y
}

fn value(vector: Point) -> Vector {
    vector.map(|x| x.re)
}

/// Gap, slip and generalised forces, as dual numbers.
struct Evaluated {
    gap: Dual64,
    slip: Dual64,
    pull: [[Dual64; 6]; 2],
    normal: Vector,
    point: Vector,
}

impl Pair {
    /// The contact between a body of the finger that rests at `rest` in the finger's frame, and the object. `before` is where both stood when
    /// the step began: a slip is measured from there.
    pub fn touching(&self, rest: Vector, now: &Stand, before: &Stand) -> Touching {
        let evaluate = |seed: usize| {
            let motion = now.body;
            let values = [motion.displacement.x, motion.displacement.y, motion.rotation]
                .into_iter()
                .chain(now.object)
                .enumerate()
                .map(|(i, value)| Dual64::new(value, if i == seed { 1.0 } else { 0.0 }));
            let mut unknowns = [Dual64::from(0.0); 6];
            unknowns.iter_mut().zip(values).for_each(|(unknown, value)| *unknown = value);
            self.evaluate(rest, &now.finger, unknowns, before)
        };
        let all = [0, 1, 2, 3, 4, 5].map(evaluate);
        let first = &all[0];
        Touching {
            gap_mm: first.gap.re,
            slip_mm: first.slip.re,
            slip_by: all.each_ref().map(|at| at.slip.eps),
            pull: first.pull.map(|pull| pull.map(|x| x.re)),
            pull_by: all.each_ref().map(|at| at.pull.map(|pull| pull.map(|x| x.eps))),
            normal: first.normal,
            point: first.point,
        }
    }

    fn evaluate(&self, rest: Vector, finger: &Placement, unknowns: [Dual64; 6], before: &Stand) -> Evaluated {
        let axes = finger.axes().map(Dual64::from);
        let [ux, uy, rotation, x, y, angle] = unknowns;
        let body = constant(rest) + Vector2::new(ux, uy);
        let (body_world, object) = (constant(finger.origin) + axes * body, Vector2::new(x, y));
        let on_body = |arm: Vector| body_world + axes * turned(rotation, constant(arm));
        let on_object = |point: Vector| object + turned(angle, constant(point));
        // The contact point is on the surface of the object.
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
                let outward = axes * turned(rotation, constant(outward));
                let height = inner(on_object(corner) - on_body(on_piece), outward);
                (height - half_mm - disc_mm, -outward, on_object(corner) - outward.map(|x| x * disc_mm))
            }
        };
        let tangent = across(normal);
        // Where the two material points that meet now were before.
        let arm_of_body = axes.transpose() * (point - body_world);
        let in_body = turned(-rotation, arm_of_body);
        let in_object = turned(-angle, point - object);
        let body_before = constant(before.finger.origin)
            + before.finger.axes().map(Dual64::from)
                * (constant(rest + before.body.displacement) + turned(before.body.rotation.into(), in_body));
        let [x_before, y_before, angle_before] = before.object.map(Dual64::from);
        let object_before = Vector2::new(x_before, y_before) + turned(angle_before, in_object);
        let slip = inner(tangent, object_before - body_before);
        let pull = [normal, tangent].map(|force| {
            let on_finger = axes.transpose() * force;
            let turning = inner(across(arm_of_body), on_finger);
            let turning_object = inner(across(point - object), force);
            [on_finger.x, on_finger.y, turning, -force.x, -force.y, -turning_object]
        });
        Evaluated { gap, slip, pull, normal: value(normal), point: value(point) }
    }
}
