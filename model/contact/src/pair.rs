//! Kinematics of one contact: gap, slip, and the effect of its forces on finger and object.
//!
//! The unknowns are the motions of the nodes that carry the finger's part, in the finger's frame, and the pose of the object in the world. Each formula
//! is written once, for plain and for dual numbers; dual numbers yield the derivatives for Newton's method.

use crate::carrier::{AxisPoint, Carrier, Deformed};
use crate::number::{Number, across, constant, inner, times, turned};
use finray_model::Vector;
use finray_model::frame::FrameMotion;
use finray_model::gripper::Placement;
use nalgebra::Vector2;
use num_dual::DualSVec64;

/// Number of unknowns of a contact.
pub const UNKNOWNS: usize = 9;

/// Displacement x, y (mm) and rotation (rad) of the carrier's first and second node, then x, y (mm) and angle (rad) of the object.
pub type Unknowns = [f64; UNKNOWNS];

type Dual = DualSVec64<UNKNOWNS>;

/// Geometry of the two parts in contact. Points of the object are in the object's frame, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meeting {
    /// A disc of the finger, and a corner or a disc of the object.
    BallAndCorner {
        /// Corner of the object, or centre of its disc, mm.
        corner: Vector,
    },
    /// A disc of the finger and a straight side of the object.
    BallAndSide {
        /// A point of the side, mm.
        on_side: Vector,
        /// Outward unit normal of the side.
        outward: Vector,
    },
    /// A piece of the plate's surface, and a corner or a disc of the object.
    PieceAndCorner {
        /// Corner of the object, or centre of its disc, mm.
        corner: Vector,
    },
}

/// Two parts in contact. A pair lives for one Newton step, so that its geometry has to be exact to second order only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The part of the finger moves with this line.
    pub carrier: Carrier,
    /// Point of the line at the contact: the centre of the finger's disc, or the foot of the object's corner.
    pub xi: f64,
    /// Radius of the finger's disc, or half the thickness of the plate, mm.
    pub radius_mm: f64,
    /// Radius of the object's disc, mm; 0 for a corner or a side.
    pub disc_mm: f64,
    /// 1 if the surface is to the left of the line (seen along increasing xi), -1 if it is to the right.
    pub side: f64,
    /// Geometry of the contact.
    pub meeting: Meeting,
}

/// Poses of finger and object at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairPose {
    /// Placement of the finger's frame in the world.
    pub finger: Placement,
    /// Displacements and rotations of the carrier's nodes, finger frame, mm and rad.
    pub nodes: [f64; 6],
    /// Position of the object, mm, and its angle, rad.
    pub object: [f64; 3],
}

impl PairPose {
    /// Poses of a carrier and of the object.
    pub fn new(carrier: &Carrier, finger: Placement, motion: &FrameMotion, object: [f64; 3]) -> PairPose {
        PairPose { finger, nodes: carrier.coordinates(motion), object }
    }

    fn unknowns(&self) -> Unknowns {
        let mut all = [0.0; UNKNOWNS];
        all[..6].copy_from_slice(&self.nodes);
        all[6..].copy_from_slice(&self.object);
        all
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

/// Generalised forces of a contact, and derivatives with respect to the unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// Derivatives of the slip, mm per mm and mm per rad.
    pub slip_by: Unknowns,
    /// Generalised forces due to a contact force of 1 N along the normal, and due to a contact force of 1 N along the tangent: force (N) and moment
    /// (N mm) on each node in the finger's frame, then on the object in the world frame. The vector for the normal direction is also the gradient of
    /// the gap.
    pub pull: [Unknowns; 2],
    /// Derivatives of both vectors in `pull` with respect to each unknown (mm or rad), one row per unknown.
    pub pull_by: [[Unknowns; 2]; UNKNOWNS],
}

/// Gap, slip, normal and point of a contact, in plain or dual numbers.
struct Evaluated<D> {
    gap: D,
    slip: D,
    normal: Vector2<D>,
    point: Vector2<D>,
    /// Vectors to the contact point, mm: from the point of the carrier's line in the finger's frame, and from the object's origin in the world frame.
    arms: [Vector2<D>; 2],
    line: Deformed<D>,
    axis: AxisPoint<D>,
    xi: D,
}

impl Pair {
    /// Gap and slip between the finger's part and the object. Slip is zero in the poses `before`, at the start of the step.
    pub fn touching(&self, now: &PairPose, before: &PairPose) -> Touching {
        let Evaluated { gap, slip, normal, point, .. } = self.evaluate(&now.finger, now.unknowns(), before);
        Touching { gap_mm: gap, slip_mm: slip, normal, point }
    }

    /// The point of the carrier's line at `xi` and the unit normal of the finger's surface there, world frame, mm.
    pub fn foot(&self, now: &PairPose) -> [Vector; 2] {
        let axis = self.carrier.deformed(&now.nodes).axis(self.xi);
        [now.finger.outwards(axis.point), now.finger.axes() * across(axis.tangent) * self.side]
    }

    /// Derivatives of gap and slip, as [`touching`](Self::touching) computes them, and generalised forces.
    pub fn tangent(&self, now: &PairPose, before: &PairPose) -> Tangent {
        let (axes, plain) = (now.finger.axes(), now.unknowns());
        let unknowns: [Dual; UNKNOWNS] = std::array::from_fn(|i| Dual::from_re(plain[i]).derivative(i));
        let Evaluated { slip, normal, arms, line, axis, xi, .. } = self.evaluate(&now.finger, unknowns, before);
        let pull = [normal, across(normal)].map(|force| {
            let on_finger = times(axes.transpose(), force);
            let moment = inner(across(arms[0]), on_finger);
            let on_nodes = line.generalised(xi, &axis, (on_finger, moment));
            let on_object = [-force.x, -force.y, -inner(across(arms[1]), force)];
            std::array::from_fn::<Dual, UNKNOWNS, _>(|i| if i < 6 { on_nodes[i] } else { on_object[i - 6] })
        });
        let by = |number: &Dual, unknown: usize| number.eps.0.map_or(0.0, |eps| eps[unknown]);
        Tangent {
            slip_by: std::array::from_fn(|unknown| by(&slip, unknown)),
            pull: pull.each_ref().map(|pull| pull.each_ref().map(|x| x.re)),
            pull_by: std::array::from_fn(|unknown| pull.each_ref().map(|pull| pull.each_ref().map(|x| by(x, unknown)))),
        }
    }

    fn evaluate<D: Number>(&self, finger: &Placement, unknowns: [D; UNKNOWNS], before: &PairPose) -> Evaluated<D> {
        let axes = finger.axes();
        let [ax, ay, a, bx, by, b, x, y, angle] = unknowns;
        let (line, object) = (self.carrier.deformed(&[ax, ay, a, bx, by, b]), Vector2::new(x, y));
        let in_world = |at: Vector2<D>| constant::<D>(finger.origin) + times(axes, at);
        let on_object = |point: Vector| object + turned(angle, constant(point));
        let mut xi = D::from(self.xi);
        let mut axis = line.axis(xi);
        // The contact point lies on the surface of the object.
        let (gap, normal, point) = match self.meeting {
            Meeting::BallAndCorner { corner } => {
                let between = in_world(axis.point) - on_object(corner);
                let distance = inner(between, between).sqrt();
                let normal = between.map(|x| x / distance);
                let point = on_object(corner) + normal.map(|x| x * self.disc_mm);
                (distance - self.radius_mm - self.disc_mm, normal, point)
            }
            Meeting::BallAndSide { on_side, outward } => {
                let (normal, centre) = (turned(angle, constant(outward)), in_world(axis.point));
                let height = inner(centre - on_object(on_side), normal);
                (height - self.radius_mm, normal, centre - normal.map(|x| x * height))
            }
            Meeting::PieceAndCorner { corner } => {
                let corner = on_object(corner);
                let at = times(axes.transpose(), corner - constant::<D>(finger.origin));
                // One Newton step in dual numbers moves the foot of the corner with the unknowns.
                let off = at - axis.point;
                let slope = inner(axis.by_xi[0], axis.by_xi[0]).re() - inner(off, axis.by_xi[1]).re();
                xi += inner(off, axis.by_xi[0]) * (1.0 / slope);
                axis = line.axis(xi);
                let outward = across(axis.tangent).map(|x| x * self.side);
                let height = inner(at - axis.point, outward);
                let outward = times(axes, outward);
                (height - self.radius_mm - self.disc_mm, -outward, corner - outward.map(|x| x * self.disc_mm))
            }
        };
        // Positions, in the poses `before`, of the two material points that are now in contact.
        let arms = [times(axes.transpose(), point - in_world(axis.point)), point - object];
        let in_section = [inner(arms[0], axis.tangent), inner(arms[0], across(axis.tangent))];
        let then = self.carrier.deformed(&before.nodes.map(D::from)).axis(xi);
        let then =
            then.point + then.tangent.map(|x| x * in_section[0]) + across(then.tangent).map(|x| x * in_section[1]);
        let finger_before = constant::<D>(before.finger.origin) + times(before.finger.axes(), then);
        let [x_before, y_before, angle_before] = before.object.map(D::from);
        let object_before = Vector2::new(x_before, y_before) + turned(angle_before, turned(-angle, arms[1]));
        let slip = inner(across(normal), object_before - finger_before);
        Evaluated { gap, slip, normal, point, arms, line, axis, xi }
    }
}
