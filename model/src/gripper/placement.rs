//! Placement of a finger in the frame of a gripper.

use crate::Vector;
use nalgebra::{Matrix2, Rotation2};

/// Transform of a plane frame into an outer frame: mirrored about its x axis if `mirrored`, then rotated, then translated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Position of the origin in the outer frame, mm.
    pub origin: Vector,
    /// Angle of the x axis in the outer frame, rad.
    pub angle_rad: f64,
    /// Whether the y axis lies to the right of the x axis.
    pub mirrored: bool,
}

impl Placement {
    /// The identity transform.
    pub const IDENTITY: Placement = Placement { origin: Vector::new(0.0, 0.0), angle_rad: 0.0, mirrored: false };

    /// Matrix that transforms directions to the outer frame: orthogonal, with determinant -1 if mirrored.
    pub fn axes(&self) -> Matrix2<f64> {
        let sign = if self.mirrored { -1.0 } else { 1.0 };
        Rotation2::new(self.angle_rad).into_inner() * Matrix2::new(1.0, 0.0, 0.0, sign)
    }

    /// Outer coordinates of a point of the frame, mm.
    pub fn outwards(&self, point: Vector) -> Vector {
        self.origin + self.axes() * point
    }

    /// Coordinates in the frame of a point of the outer frame, mm.
    pub fn inwards(&self, point: Vector) -> Vector {
        self.axes().transpose() * (point - self.origin)
    }

    /// The placement in the frame that contains `outer`; `outer` must not be mirrored.
    pub fn within(&self, outer: &Placement) -> Placement {
        Placement {
            origin: outer.outwards(self.origin),
            angle_rad: self.angle_rad + outer.angle_rad,
            mirrored: self.mirrored,
        }
    }
}
