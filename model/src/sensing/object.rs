//! An object of known outline that touches the front plate while forces are sensed. Sensing needs only the point of the outline at which a tangent
//! has a given direction, so the outline may be any convex curve; a pressed or grasped object has an [`Outline`](crate::scene::Outline) of its own.

use crate::Vector;
use nalgebra::{Isometry2, UnitComplex};

/// A convex outline of a touched object in the object's own frame, mm.
#[derive(Debug, Clone, PartialEq)]
pub enum TouchedOutline {
    /// A disc centred at the origin.
    Disc {
        /// Radius, mm.
        radius_mm: f64,
    },
    /// An ellipse centred at the origin, with its axes along x and y.
    Ellipse {
        /// Semi-axes along x and y, mm.
        semi_axes_mm: [f64; 2],
    },
    /// A convex polygon.
    Polygon {
        /// Corners in counterclockwise order (from x to y), in mm.
        corners: Vec<Vector>,
    },
}

/// The corners do not form a convex polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("three or more corners of a convex polygon, listed in order")]
pub struct NotConvex;

impl TouchedOutline {
    /// A polygon with the given corners, mm, listed in order along the outline, clockwise or counterclockwise.
    ///
    /// # Errors
    /// [`NotConvex`] for fewer than three corners, repeated corners, three successive corners on one line, or an outline that does not make one full
    /// turn in a single sense.
    pub fn polygon(mut corners: Vec<Vector>) -> Result<TouchedOutline, NotConvex> {
        let count = corners.len();
        let at = |i: usize| corners[i % count];
        let turn = |i: usize| (at(i + 1) - at(i)).perp(&(at(i + 2) - at(i + 1)));
        let area: f64 = (0..count).map(|i| at(i).perp(&at(i + 1))).sum();
        let exterior = |i: usize| turn(i).atan2((at(i + 1) - at(i)).dot(&(at(i + 2) - at(i + 1)))).abs();
        // The outline of a star also turns in the same sense at every corner, but makes more than one full turn.
        let once_round = (0..count).map(exterior).sum::<f64>() < 1.5 * std::f64::consts::TAU;
        if count < 3 || !(0..count).all(|i| turn(i) * area > 0.0) || !once_round {
            return Err(NotConvex);
        }
        if area < 0.0 {
            corners.reverse();
        }
        Ok(TouchedOutline::Polygon { corners })
    }

    /// Whether every rotation about the origin leaves the outline unchanged.
    pub fn is_round(&self) -> bool {
        matches!(self, TouchedOutline::Disc { .. })
    }

    /// Largest distance of the outline from the origin, mm.
    pub(super) fn largest_radius_mm(&self) -> f64 {
        match self {
            TouchedOutline::Disc { radius_mm } => *radius_mm,
            TouchedOutline::Ellipse { semi_axes_mm: [a, b] } => a.max(*b),
            TouchedOutline::Polygon { corners } => corners.iter().map(Vector::norm).fold(0.0, f64::max),
        }
    }

    /// Point of the outline, in mm, that is farthest in the direction of the unit vector `along`. The outward normal at this point is `along`.
    fn furthest(&self, along: Vector) -> Vector {
        match self {
            TouchedOutline::Disc { radius_mm } => along * *radius_mm,
            TouchedOutline::Ellipse { semi_axes_mm: [a, b] } => {
                Vector::new(a * a * along.x, b * b * along.y) / (a * along.x).hypot(b * along.y)
            }
            TouchedOutline::Polygon { corners } => {
                let further = |p: &&Vector, q: &&Vector| p.dot(&along).total_cmp(&q.dot(&along));
                corners.iter().max_by(further).copied().unwrap_or_default()
            }
        }
    }
}

/// An object that touches the front plate, with the uncertainty of its pose.
#[derive(Debug, Clone, PartialEq)]
pub struct TouchedObject {
    /// Outline of the object.
    pub shape: TouchedOutline,
    /// Pose in the finger frame of the measurement: origin of the outline, mm, and rotation from x to y, rad.
    pub pose: Isometry2<f64>,
    /// Standard deviation of each coordinate of the origin, mm. Zero if the origin is known exactly.
    pub sd_mm: f64,
    /// Standard deviation of the rotation, rad. Zero if the rotation is known exactly.
    pub sd_rad: f64,
}

impl TouchedObject {
    /// Whether the rotation of the object is an unknown.
    pub(super) fn may_turn(&self) -> bool {
        self.sd_rad > 0.0 && !self.shape.is_round()
    }

    /// Point of the outline, in mm, finger frame, at which the outward normal is `normal`. The object is shifted by `x_mm` and `y_mm` and rotated
    /// about its origin by `turn_rad`.
    pub(super) fn point_facing(&self, normal: Vector, [x_mm, y_mm, turn_rad]: [f64; 3]) -> Vector {
        let turn = UnitComplex::new(self.pose.rotation.angle() + turn_rad);
        let origin = self.pose.translation.vector + Vector::new(x_mm, y_mm);
        origin + turn * self.shape.furthest(turn.inverse() * normal)
    }
}

#[cfg(test)]
#[path = "../../tests/units/object.rs"]
mod tests;
