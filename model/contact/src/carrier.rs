//! Kinematics of the plate's axis and of points that move with it.
//!
//! A carrier is a rigid piece of the finger that is fixed to a mesh node, or the axis of a beam element. The axis of an element is the cubic of the
//! co-rotational element: p(xi) = (1 - xi) a + xi b + w n with the ends a and b of the element, the unit vector n across its chord, and the deflection
//! w = L (psi_a xi (1 - xi)^2 - psi_b xi^2 (1 - xi)). The end slopes psi count from the chord. Neighbouring elements share the slope at their node, so
//! that the axis has no kinks.

use crate::number::{Number, across, constant, inner, turned};
use finray_model::Vector;
use finray_model::element::Beam;
use finray_model::frame::{FrameMotion, NodeIndex, RotationSlot};
use nalgebra::Vector2;

/// Displacement x, y (mm) and rotation (rad) of the first node of a carrier, then of the second node.
pub(crate) type Coordinates<D> = [D; 6];

/// A mesh node with which a carrier moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Index of the node.
    pub node: NodeIndex,
    /// Rotation slot of the node.
    pub rotation: RotationSlot,
    /// Undeformed position, mm, finger frame.
    pub position: Vector,
    /// Whether the node is clamped and never moves.
    pub clamped: bool,
}

/// A line that moves with one or two nodes of the mesh. Points on the line have a parameter xi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Carrier {
    /// A straight line that is fixed to a node, or to the world without a node: point `from` at xi = 0, `from + along` at xi = 1, relative to the
    /// node, undeformed, mm.
    Rigid {
        /// The node; `None` for a line that does not move.
        mount: Option<Mount>,
        /// Start of the line, mm.
        from: Vector,
        /// Vector from the start to the end of the line, mm.
        along: Vector,
    },
    /// The axis of a beam element between the ends of two rigid arms.
    Beam {
        /// Nodes of the element.
        mounts: [Mount; 2],
        /// Arms from each node to the end of the element, undeformed, mm.
        arms: [Vector; 2],
        /// The element.
        beam: Beam,
    },
}

/// A carrier in its deformed position.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Deformed<D> {
    /// Node, start of the line, vector along the line, and unit vector that rotates with the node.
    Rigid { node: Vector2<D>, from: Vector2<D>, along: Vector2<D>, unit: Vector2<D> },
    /// Chord of an element.
    Beam(Chord<D>),
}

/// The chord of a deformed element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chord<D> {
    beam: Beam,
    /// Ends of the element, mm, and vectors from the nodes to the ends, mm.
    ends: [Vector2<D>; 2],
    arms: [Vector2<D>; 2],
    along: Vector2<D>,
    across: Vector2<D>,
    length: D,
    /// Rotations of the ends relative to the chord, rad.
    rotations: [D; 2],
}

/// A point of a carrier's line in the finger frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AxisPoint<D> {
    /// Position, mm.
    pub point: Vector2<D>,
    /// First and second derivative of the position by xi, mm.
    pub by_xi: [Vector2<D>; 2],
    /// Unit tangent; for a line of zero length, a unit vector that rotates with the node.
    pub tangent: Vector2<D>,
}

/// Deflection of a beam by the rotations of its two ends, and first and second derivatives by xi.
fn shape<D: Number>(beam: &Beam, xi: D) -> [[D; 2]; 3] {
    let (length, rest) = (beam.length_mm, -xi + 1.0);
    let by_shear = 0.5 * (1.0 - beam.sway_factor);
    let of_slopes = [
        [xi * rest * rest * length, -(xi * xi * rest) * length],
        [rest * (-xi * 3.0 + 1.0) * length, xi * (xi * 3.0 - 2.0) * length],
        [(xi * 6.0 - 4.0) * length, (xi * 6.0 - 2.0) * length],
    ];
    of_slopes.map(|[a, b]| {
        let shear = (a + b) * by_shear;
        [a - shear, b - shear]
    })
}

impl<D: Number> Chord<D> {
    fn new(mounts: &[Mount; 2], arms: &[Vector; 2], beam: &Beam, &[ax, ay, a, bx, by, b]: &Coordinates<D>) -> Chord<D> {
        let swung = |arm: Vector, by: D| if arm == Vector::zeros() { constant(arm) } else { turned(by, constant(arm)) };
        let arms = [swung(arms[0], a), swung(arms[1], b)];
        let at = |mount: &Mount, x, y| constant::<D>(mount.position) + Vector2::new(x, y);
        let ends = [at(&mounts[0], ax, ay) + arms[0], at(&mounts[1], bx, by) + arms[1]];
        let between = ends[1] - ends[0];
        let length = inner(between, between).sqrt();
        let along = between.map(|x| x / length);
        let rest = constant::<D>(beam.direction);
        let rotation = inner(across(rest), along).atan2(inner(rest, along));
        Chord { beam: *beam, ends, arms, along, across: across(along), length, rotations: [a - rotation, b - rotation] }
    }

    /// Sum over both ends of `by` times the rotation of the end relative to the chord.
    fn total(&self, by: [D; 2]) -> D {
        by[0] * self.rotations[0] + by[1] * self.rotations[1]
    }
}

impl Carrier {
    /// The nodes with which the carrier moves.
    pub fn mounts(&self) -> [Option<Mount>; 2] {
        match *self {
            Carrier::Rigid { mount, .. } => [mount, None],
            Carrier::Beam { mounts: [first, second], .. } => [Some(first), Some(second)],
        }
    }

    /// Whether the carrier never moves in the finger's frame.
    pub fn is_fixed(&self) -> bool {
        self.mounts().iter().flatten().all(|mount| mount.clamped)
    }

    /// Displacements and rotations of the carrier's nodes.
    pub(crate) fn coordinates(&self, motion: &FrameMotion) -> Coordinates<f64> {
        let [a, b] = self.mounts().map(|mount| {
            mount.map_or([0.0; 3], |mount| {
                let u = motion.displacements[mount.node];
                [u.x, u.y, motion.rotations[mount.rotation]]
            })
        });
        [a[0], a[1], a[2], b[0], b[1], b[2]]
    }

    /// The carrier in the position given by the motions of its nodes.
    pub(crate) fn deformed<D: Number>(&self, at: &Coordinates<D>) -> Deformed<D> {
        match self {
            Carrier::Rigid { mount, from, along } => {
                let position = mount.map_or(Vector::zeros(), |mount| mount.position);
                let node = constant::<D>(position) + Vector2::new(at[0], at[1]);
                let unit = along.try_normalize(0.0).unwrap_or(Vector::x());
                let [from, along, unit] = [*from, *along, unit].map(|vector| turned(at[2], constant(vector)));
                Deformed::Rigid { node, from: node + from, along, unit }
            }
            Carrier::Beam { mounts, arms, beam } => Deformed::Beam(Chord::new(mounts, arms, beam, at)),
        }
    }
}

impl<D: Number> Deformed<D> {
    /// The point of the line at xi.
    pub(crate) fn axis(&self, xi: D) -> AxisPoint<D> {
        match self {
            Deformed::Rigid { from, along, unit, .. } => AxisPoint {
                point: from + along.map(|x| x * xi),
                by_xi: [*along, constant(Vector::zeros())],
                tangent: *unit,
            },
            Deformed::Beam(chord) => {
                let between = chord.ends[1] - chord.ends[0];
                let [w, slope, bend] = shape(&chord.beam, xi).map(|by| chord.across.map(|x| x * chord.total(by)));
                let slope = between + slope;
                let speed = inner(slope, slope).sqrt();
                AxisPoint {
                    point: chord.ends[0] + between.map(|x| x * xi) + w,
                    by_xi: [slope, bend],
                    tangent: slope.map(|x| x / speed),
                }
            }
        }
    }

    /// Generalised forces (N and N mm on each node) of a force (N) at the point `axis` of the line at xi, and of a moment (N mm) on the line's tangent
    /// there.
    pub(crate) fn generalised(
        &self,
        xi: D,
        AxisPoint { point, by_xi, tangent }: &AxisPoint<D>,
        (force, moment): (Vector2<D>, D),
    ) -> Coordinates<D> {
        match self {
            Deformed::Rigid { node, .. } => {
                let zero = D::from(0.0);
                [force.x, force.y, inner(across(point - node), force) + moment, zero, zero, zero]
            }
            Deformed::Beam(chord) => {
                let normal = across(*tangent);
                let (along_n, across_n) = (inner(force, chord.along), inner(force, chord.across));
                let moment_per_speed = moment / inner(by_xi[0], *tangent);
                let [shapes, slopes, _] = shape(&chord.beam, xi);
                let turning = inner(normal, chord.across) * moment_per_speed;
                let [a, b] = [0, 1].map(|i| across_n * shapes[i] + turning * slopes[i]);
                // Moment that turns the chord, with fixed rotations of the nodes.
                let on_chord = -chord.total(shapes) * along_n
                    - a
                    - b
                    - chord.total(slopes) * inner(normal, chord.along) * moment_per_speed;
                let couple = chord.across.map(|x| x * (on_chord / chord.length)) + normal.map(|x| x * moment_per_speed);
                let on_ends = [force.map(|x| x * (-xi + 1.0)) - couple, force.map(|x| x * xi) + couple];
                let on_arm = |end: usize| inner(across(chord.arms[end]), on_ends[end]);
                let [first, second] = on_ends;
                [first.x, first.y, a + on_arm(0), second.x, second.y, b + on_arm(1)]
            }
        }
    }
}
