//! Parts of finger and object that can touch: discs and flat pieces of a finger's front, corners and sides of an object.

use super::contact::{Pair, PairPose};
use crate::Lattice;
use crate::bodies::Body;
use crate::energy::BodyMotion;
use crate::skin::TouchedPart;
use crate::springs::BodyIndex;
use finray_model::Vector;
use finray_model::finger::Plate;
use nalgebra::Rotation2;

/// A part of a finger's front surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Body that carries the part.
    pub body: BodyIndex,
    /// Centre of a disc, or first end of a flat piece's middle line, relative to the body's centre, undeformed, mm.
    pub from: Vector,
    /// Other end of a flat piece's middle line, relative to the body's centre, mm; `None` for a disc.
    pub to: Option<Vector>,
    /// Radius of a disc, or half the thickness of a flat piece, mm.
    pub radius_mm: f64,
    /// Rod, or position along the plate at which the part begins; reported to callers.
    pub touched: TouchedPart,
}

/// Front surface of a finger: a disc for every rod, flat pieces between the rods, and a disc where two pieces meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Front {
    /// Discs of the rods, followed by flat pieces and their end discs along the plate from base to tip.
    pub parts: Vec<Part>,
}

impl Front {
    /// Front surface of a lattice whose rods have the given radius, mm (0: no rods).
    pub fn new(lattice: &Lattice, rod_radius_mm: f64) -> Front {
        let (finger, assembly) = (lattice.finger(), lattice.assembly());
        let half_mm = 0.5 * finger.description().front.thickness_mm;
        let mut parts = Vec::new();
        if rod_radius_mm > half_mm {
            for node in finger.plate_nodes(Plate::Front).into_iter().filter(|node| finger.junction(*node) == *node) {
                let anchor = assembly.key_nodes[node.0 - 1];
                let touched = TouchedPart::Rod(node);
                parts.push(Part { body: anchor.body, from: anchor.arm, to: None, radius_mm: rod_radius_mm, touched });
            }
        }
        for piece in assembly.front_pieces() {
            let [from, to] = piece.ends;
            let touched = TouchedPart::Plate(piece.from_mm);
            let flat = Part { body: piece.body, from, to: Some(to), radius_mm: half_mm, touched };
            parts.extend([flat, Part { to: None, ..flat }]);
        }
        Front { parts }
    }

    /// Adds a disc at the second end of every piece. The disc closes the gap between the surfaces of two pieces where the plate bends sharply or a clamped
    /// piece ends.
    pub fn round_at_both_ends(mut self) -> Front {
        let end = |flat: &Part| {
            let (to, TouchedPart::Plate(from_mm)) = (flat.to?, flat.touched) else { return None };
            let touched = TouchedPart::Plate(from_mm + (to - flat.from).norm());
            Some(Part { from: to, to: None, touched, ..*flat })
        };
        let ends: Vec<Part> = self.parts.iter().filter_map(end).collect();
        self.parts.extend(ends);
        self
    }
}

/// Outline of an object in its own frame, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Corners of a polygon, counter-clockwise, mm; for a disc, only its centre.
    corners: Vec<Vector>,
    /// Radius of a disc, mm; 0 for a polygon.
    disc_mm: f64,
    /// Largest distance of an outline point from the object's origin, mm.
    size_mm: f64,
}

/// A disc whose centre is deeper than this below a side, mm, is assumed to touch another side of a thin object.
const BEHIND_MM: f64 = 0.5;
/// Margin of the coarse distance test, mm; it is larger than rounding errors.
const FAR_MM: f64 = 1e-3;
/// A corner can touch a piece up to this share of the piece's length beyond the piece's ends. If two pieces meet at a concave angle, both pieces can
/// therefore touch the corner.
const BEYOND: f64 = 1e-9;

impl Shape {
    /// A disc of the given radius, mm, centred at the object's origin.
    pub fn disc(radius_mm: f64) -> Shape {
        Shape { corners: vec![Vector::zeros()], disc_mm: radius_mm, size_mm: radius_mm }
    }

    /// A polygon with these corners, mm, clockwise or counter-clockwise.
    pub fn polygon(corners: &[Vector]) -> Shape {
        let mut corners = corners.to_vec();
        if doubled_area(&corners) < 0.0 {
            corners.reverse();
        }
        let size_mm = corners.iter().map(Vector::norm).fold(0.0, f64::max);
        Shape { corners, disc_mm: 0.0, size_mm }
    }

    /// Centroid of the area, mm.
    pub fn centroid(&self) -> Vector {
        if self.corners.len() < 3 {
            return self.corners[0];
        }
        let moments = self.sides().map(|[a, b]| (a + b) * a.perp(&b)).sum::<Vector>();
        moments / (3.0 * doubled_area(&self.corners))
    }

    /// Largest distance of an outline point from the object's origin, mm.
    pub fn size_mm(&self) -> f64 {
        self.size_mm
    }

    /// Largest extent from the origin along a unit vector, mm, for an object rotated by `angle_rad`.
    pub fn reach_mm(&self, along: Vector, angle_rad: f64) -> f64 {
        let turn = Rotation2::new(angle_rad);
        self.disc_mm + self.corners.iter().map(|corner| (turn * corner).dot(&along)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Corners of the outline (mm), and the radius of the disc about each corner (mm).
    pub fn corners(&self) -> (&[Vector], f64) {
        (&self.corners, self.disc_mm)
    }

    fn sides(&self) -> impl Iterator<Item = [Vector; 2]> + '_ {
        let ends = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(ends).map(|(a, b)| [*a, *b]).filter(|_| self.corners.len() > 1)
    }

    /// Features of the object that are closer to a part than `within_mm`, each with the geometry of the contact.
    pub fn near(&self, part: &Part, body: &Body, stand: &PairPose, within_mm: f64) -> Vec<(Feature, Pair)> {
        let world = |arm: Vector| {
            let BodyMotion { displacement, .. } = stand.body;
            stand.finger.outwards(body.position + displacement + stand.body.carried(arm))
        };
        let [x, y, angle] = stand.object;
        let turn = Rotation2::new(angle);
        let in_object = |point: Vector| turn.inverse() * (point - Vector::new(x, y));
        let ends = [in_object(world(part.from)), in_object(world(part.to.unwrap_or(part.from)))];
        // A point of the piece is at most one piece length away from the piece's first end.
        let away_mm = ends[0].norm() - (ends[1] - ends[0]).norm() - self.size_mm;
        if away_mm > part.radius_mm + within_mm + FAR_MM {
            return Vec::new();
        }
        match part.to {
            None => self.near_ball(part, ends[0], within_mm),
            Some(to) => self.near_piece(part, to, ends, within_mm),
        }
    }

    /// Pairs of a disc and features of the object; `at` is the disc's centre in the object's frame, mm.
    fn near_ball(&self, part: &Part, at: Vector, within_mm: f64) -> Vec<(Feature, Pair)> {
        let Part { from: centre, radius_mm, .. } = *part;
        let mut pairs = Vec::new();
        let count = self.corners.len();
        // For each corner: whether the disc is beyond the end of the side before it, and beyond the start of the side after it.
        let mut beyond = vec![[count == 1; 2]; count];
        for (i, [a, b]) in self.sides().enumerate() {
            let along = (b - a).normalize();
            let outward = Vector::new(along.y, -along.x);
            let (way, length) = ((at - a).dot(&along), (b - a).norm());
            beyond[i][1] = way < 0.0;
            beyond[(i + 1) % count][0] = way > length;
            let height = (at - a).dot(&outward);
            if (0.0..=length).contains(&way) && height > -BEHIND_MM && height - radius_mm < within_mm {
                pairs.push((Feature::Side(i), Pair::BallAndSide { centre, on_side: a, outward, radius_mm }));
            }
        }
        for (i, corner) in self.corners.iter().enumerate() {
            let radii_mm = [radius_mm, self.disc_mm];
            if beyond[i] == [true; 2] && (at - corner).norm() - radius_mm - self.disc_mm < within_mm {
                pairs.push((Feature::Corner(i), Pair::BallAndCorner { centre, corner: *corner, radii_mm }));
            }
        }
        pairs
    }

    /// Pairs of a flat piece and features of the object; `ends` are the piece's ends in the object's frame, mm.
    fn near_piece(&self, part: &Part, to: Vector, ends: [Vector; 2], within_mm: f64) -> Vec<(Feature, Pair)> {
        let Part { from: on_piece, radius_mm: half_mm, .. } = *part;
        let along = (to - on_piece).normalize();
        let outward = Vector::new(-along.y, along.x);
        let (line, length) = ((ends[1] - ends[0]).normalize(), (ends[1] - ends[0]).norm());
        let mut pairs = Vec::new();
        for (i, corner) in self.corners.iter().enumerate() {
            let (way, off) = ((corner - ends[0]).dot(&line), (corner - ends[0]).perp(&line).abs());
            let is_beside = (-BEYOND * length..=(1.0 + BEYOND) * length).contains(&way);
            if is_beside && off - half_mm - self.disc_mm < within_mm {
                let radii_mm = [half_mm, self.disc_mm];
                pairs.push((Feature::Corner(i), Pair::PieceAndCorner { on_piece, outward, corner: *corner, radii_mm }));
            }
        }
        pairs
    }
}

/// Twice the area of a polygon, mm^2; positive for counter-clockwise corners.
fn doubled_area(corners: &[Vector]) -> f64 {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a.perp(b)).sum()
}

/// A corner or side of an object, identified by its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    /// A corner of a polygon, or the centre of a disc.
    Corner(usize),
    /// The side of a polygon from the corner with this index to the next corner.
    Side(usize),
}
