//! Outline of an object in contact: its corners and sides, and the features that are near a part of a finger.
//!
//! A scene states an [`Outline`], which [`ContactOutline::of_object`] turns into the only outline that contact knows: corners, with a radius about
//! each. A disc is one corner with its radius; a box or a polygon has the radius 0. A new outline of a scene is a variant of [`Outline`] and its
//! corners here. [`Meeting`] is the geometry of each kind of feature.

use crate::carrier::{AxisPoint, Deformed};
use crate::pair::{Meeting, Pair};
use crate::part::{Part, Touches};
use earcut::Earcut;
use finray_model::Vector;
use finray_model::gripper::Placement;
use finray_model::scene::{ObjectDescription, Outline};
use nalgebra::{Matrix2, Rotation2};

/// Why an outline is invalid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OutlineError {
    /// The outline has fewer than three corners.
    #[error("expected three corners or more, found {corners}")]
    TooFewCorners {
        /// Number of corners found.
        corners: usize,
    },
    /// The outline encloses no area, or crosses itself.
    #[error("expected the corners in order around the object: the outline crosses itself or encloses nothing")]
    Crossed,
    /// A corner is too far from the object's reference point.
    #[error("corner {corner} is not within {FARTHEST_MM} mm of the origin")]
    TooFar {
        /// Number of the corner in the list, from 1.
        corner: usize,
    },
}

/// Largest admissible distance of a corner from the object's reference point, mm.
const FARTHEST_MM: f64 = 1e4;
/// Number of corners of a disc in drawings only.
const DRAWN_CORNERS: usize = 90;
/// Tolerance of the relative difference between the area of an outline and the total area of its triangles. Only an outline that crosses itself
/// exceeds this tolerance.
const AREA_TOLERANCE: f64 = 1e-9;

/// Outline of an object in its own frame, mm: either one corner with a radius (a disc), or three or more corners with radius 0 (a polygon). Polygons with
/// rounded corners are not supported, because sides ignore the radius.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactOutline {
    /// Corners, counter-clockwise, mm; for a disc, only its centre.
    corners: Vec<Vector>,
    /// Radius about each corner, mm: that of a disc, 0 for a polygon.
    disc_mm: f64,
    /// Largest distance of an outline point from the object's origin, mm.
    size_mm: f64,
}

/// A disc whose centre is deeper than this below a side, mm, is assumed to touch another side of a thin object.
const BEHIND_MM: f64 = 0.5;
/// Margin of the coarse distance test, mm; it is larger than rounding errors.
const FAR_MM: f64 = 1e-3;
/// A corner can touch a piece whose end is this share of the piece's length short of the corner's foot. Rounding thus opens no gap between two pieces.
const BEYOND: f64 = 1e-9;
/// Largest number of steps in which the foot of a corner on a piece is found.
const FOOT_STEPS: usize = 30;

impl ContactOutline {
    /// The outline of a scene's object about its reference point, rotated as the scene states. `corners` (mm) are a polygon's corners from its file;
    /// they are ignored for other outlines.
    ///
    /// # Errors
    /// [`OutlineError`] for corners that form no valid outline.
    pub fn of_object(object: &ObjectDescription, corners: &[Vector]) -> Result<ContactOutline, OutlineError> {
        let turn = Rotation2::new(object.rotation_deg.to_radians()).into_inner();
        Ok(match object.outline {
            Outline::Disc { radius_mm } => ContactOutline::disc(radius_mm),
            Outline::Box { width_mm, height_mm } => {
                let (x, y) = (0.5 * width_mm, 0.5 * height_mm);
                let corners = [Vector::new(-x, -y), Vector::new(x, -y), Vector::new(x, y), Vector::new(-x, y)];
                ContactOutline::polygon(&corners).mapped(turn)
            }
            Outline::Polygon { .. } => {
                triangles(corners)?;
                ContactOutline::polygon(corners).mapped(turn)
            }
        })
    }

    /// A disc of the given radius, mm, centred at the object's origin.
    pub fn disc(radius_mm: f64) -> ContactOutline {
        ContactOutline { corners: vec![Vector::zeros()], disc_mm: radius_mm, size_mm: radius_mm }
    }

    /// A polygon with these corners, mm, clockwise or counter-clockwise.
    pub fn polygon(corners: &[Vector]) -> ContactOutline {
        let mut corners = corners.to_vec();
        if doubled_area(&corners) < 0.0 {
            corners.reverse();
        }
        let size_mm = corners.iter().map(Vector::norm).fold(0.0, f64::max);
        ContactOutline { corners, disc_mm: 0.0, size_mm }
    }

    /// The outline after an orthogonal map: a rotation or a reflection.
    pub fn mapped(&self, map: Matrix2<f64>) -> ContactOutline {
        let corners: Vec<Vector> = self.corners.iter().map(|corner| map * corner).collect();
        ContactOutline { disc_mm: self.disc_mm, ..ContactOutline::polygon(&corners) }.with_size(self.size_mm)
    }

    fn with_size(self, size_mm: f64) -> ContactOutline {
        ContactOutline { size_mm, ..self }
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

    /// Corners of the outline (mm), and the radius of the disc about each corner (mm; 0 for a polygon). An outline whose corners depend on the direction
    /// changes all readers: pairs (`surface`, `status`), `overlap`, the length of steps (`pressing`, which reads only the radius), the camera's baseline (`press::camera`), the side on
    /// which an object is (`world`), and the shape of the physics engine (`engine_pressing` of the lattice).
    pub fn corners(&self) -> (&[Vector], f64) {
        (&self.corners, self.disc_mm)
    }

    /// Sides of a polygon, each from one corner to the next, mm; none for a disc.
    pub fn sides(&self) -> impl Iterator<Item = [Vector; 2]> + '_ {
        let ends = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(ends).map(|(a, b)| [*a, *b]).filter(|_| self.corners.len() > 1)
    }

    /// Whether a point (mm) is inside a polygon.
    pub(crate) fn contains(&self, point: Vector) -> bool {
        let is_crossed = |[a, b]: &[Vector; 2]| {
            (a.y > point.y) != (b.y > point.y) && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
        };
        self.sides().filter(is_crossed).count() % 2 == 1
    }

    /// Triangles of a polygon as indices of its corners, counter-clockwise; none for a disc.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        triangles(&self.corners).unwrap_or_default()
    }

    /// The outline as a closed polyline, mm; a disc becomes a polygon.
    pub fn points(&self) -> Vec<Vector> {
        let corner = |i: usize| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / DRAWN_CORNERS as f64).sin_cos();
            Vector::new(cos, sin) * self.disc_mm
        };
        match self.disc_mm > 0.0 {
            true => (0..=DRAWN_CORNERS).map(|i| corner(i % DRAWN_CORNERS)).collect(),
            false => self.corners.iter().chain(self.corners.first()).copied().collect(),
        }
    }

    /// Features of the object that are closer to a part than `within_mm`, each with the geometry of the contact and the gap, mm. `line` is the part's
    /// line in the finger's frame, with the points `ends` at the part's start and end; `pose` is the object's pose in the finger's frame, and `corners`
    /// are its corners there, mm.
    pub(crate) fn near(
        &self,
        part: &Part,
        line: &Deformed<f64>,
        ends: [&AxisPoint<f64>; 2],
        (pose, corners): (&PoseInFinger, &[Vector]),
        within_mm: f64,
        mut add: impl FnMut(Feature, Pair, f64),
    ) {
        let (from, &PoseInFinger { origin, axes: into_finger }) = (ends[0], pose);
        if (from.point - origin).norm() - part.length_mm - self.size_mm > part.radius_mm + within_mm + FAR_MM {
            return;
        }
        let mut add = |feature: Feature, meeting: Meeting, xi: f64, gap_mm: f64| {
            let (carrier, radius_mm, side, disc_mm) = (part.carrier, part.radius_mm, part.side, self.disc_mm);
            if gap_mm < within_mm {
                add(feature, Pair { carrier, xi, radius_mm, disc_mm, side, meeting }, gap_mm);
            }
        };
        if part.touches == Touches::Corners {
            for (i, (corner, at)) in self.corners.iter().zip(corners).enumerate() {
                let Some((xi, height_mm)) = foot(line, part, ends, *at) else { continue };
                if height_mm > -part.radius_mm - within_mm {
                    let gap_mm = height_mm - part.radius_mm - self.disc_mm;
                    add(Feature::Corner(i), Meeting::PieceAndCorner { corner: *corner }, xi, gap_mm);
                }
            }
            return;
        }
        let at = into_finger.transpose() * (from.point - origin);
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
            // The far side of a thin finger faces away from the object.
            let faces = |axis: &AxisPoint<f64>| {
                part.side * axis.tangent.perp(&(into_finger * outward)) < 0.0 || part.touches == Touches::All
            };
            if (0.0..=length).contains(&way) && height > -BEHIND_MM && faces(from) {
                let gap_mm = height - part.radius_mm;
                add(Feature::Side(i), Meeting::BallAndSide { on_side: a, outward }, part.xi[0], gap_mm);
            }
        }
        for (i, corner) in self.corners.iter().enumerate().filter(|_| part.touches == Touches::All) {
            if beyond[i] == [true; 2] {
                let gap_mm = (at - corner).norm() - part.radius_mm - self.disc_mm;
                add(Feature::Corner(i), Meeting::BallAndCorner { corner: *corner }, part.xi[0], gap_mm);
            }
        }
    }
}

/// Foot of a point (mm, finger frame) on a piece of a line: the point of the piece at which its distance is smallest, and the height of the point above
/// the line there, mm. `None` if the distance is smallest at an end of the piece.
fn foot(line: &Deformed<f64>, part: &Part, ends: [&AxisPoint<f64>; 2], point: Vector) -> Option<(f64, f64)> {
    let towards = |xi: f64| {
        let axis = line.axis(xi);
        let off = point - axis.point;
        (off.dot(&axis.by_xi[0]), off.dot(&axis.by_xi[1]) - axis.by_xi[0].norm_squared())
    };
    let [mut from, mut to] = part.xi;
    let slack = BEYOND * part.length_mm;
    let [at_start, at_end] = ends.map(|end| (point - end.point).dot(&end.tangent));
    if at_start < -slack || at_end > slack {
        return None;
    }
    // The secant through the ends is a good start.
    let mut xi = from + (to - from) * (at_start / (at_start - at_end)).clamp(0.0, 1.0);
    for _ in 0..FOOT_STEPS {
        let (along, slope) = towards(xi);
        *(if along > 0.0 { &mut from } else { &mut to }) = xi;
        let next = xi - along / slope;
        // Bisection, where Newton's method leaves the bracket.
        let next = if slope < 0.0 && (from..=to).contains(&next) { next } else { 0.5 * (from + to) };
        let moved = (next - xi).abs();
        xi = next;
        if moved < 1e-15 {
            break;
        }
    }
    let axis = line.axis(xi);
    Some((xi, part.side * axis.tangent.perp(&(point - axis.point))))
}

/// Twice the area of a polygon, mm^2; positive for counter-clockwise corners.
fn doubled_area(corners: &[Vector]) -> f64 {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a.perp(b)).sum()
}

/// Divides an outline into triangles, counter-clockwise.
fn triangles(corners: &[Vector]) -> Result<Vec<[u32; 3]>, OutlineError> {
    if corners.len() < 3 {
        return Err(OutlineError::TooFewCorners { corners: corners.len() });
    }
    if let Some(far) = corners.iter().position(|corner| corner.norm().is_nan() || corner.norm() > FARTHEST_MM) {
        return Err(OutlineError::TooFar { corner: far + 1 });
    }
    let vertices: Vec<[f64; 2]> = corners.iter().map(|corner| [corner.x, corner.y]).collect();
    let mut indices: Vec<u32> = Vec::new();
    Earcut::new().earcut(vertices.iter().copied(), &[], &mut indices);
    let missed = earcut::deviation(vertices.iter().copied(), &[] as &[u32], &indices);
    if indices.is_empty() || missed.is_nan() || missed > AREA_TOLERANCE {
        return Err(OutlineError::Crossed);
    }
    let corner = |index: u32| corners[index as usize];
    let counter_clockwise = |&[a, b, c]: &[u32; 3]| {
        if (corner(b) - corner(a)).perp(&(corner(c) - corner(a))) > 0.0 { [a, b, c] } else { [a, c, b] }
    };
    Ok(indices.as_chunks::<3>().0.iter().map(counter_clockwise).collect())
}

/// Pose of an object in the frame of a finger.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PoseInFinger {
    /// Origin of the object's frame, mm.
    pub origin: Vector,
    /// Map of directions from the object's frame to the finger's frame.
    axes: Matrix2<f64>,
}

impl PoseInFinger {
    /// Pose of an object at `[x, y, angle]` (mm, rad) in the frame of a placed finger.
    pub(crate) fn new(finger: &Placement, [x, y, angle]: [f64; 3]) -> PoseInFinger {
        let axes = finger.axes().transpose() * Rotation2::new(angle).into_inner();
        PoseInFinger { origin: finger.inwards(Vector::new(x, y)), axes }
    }

    /// Maps a point of the finger's frame to the object's frame, mm.
    pub(crate) fn inwards(&self, point: Vector) -> Vector {
        self.axes.transpose() * (point - self.origin)
    }

    /// Maps a point of the object to the finger's frame, mm.
    pub(crate) fn point(&self, point: Vector) -> Vector {
        self.origin + self.axes * point
    }
}

/// A corner or side of an object, identified by its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    /// A corner of a polygon, or the centre of a disc.
    Corner(usize),
    /// The side of a polygon from the corner with this index to the next corner.
    Side(usize),
}
