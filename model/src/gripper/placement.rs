//! Placement of a finger in the frame of a gripper.

use crate::Vector;
use nalgebra::{Matrix2, Rotation2};

/// Transform from a plane frame to an outer frame: mirroring about the x axis if `mirrored`, then rotation, then translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Position of the frame's origin in the outer frame, mm.
    pub origin: Vector,
    /// Angle of the frame's x axis in the outer frame, rad.
    pub angle_rad: f64,
    /// Whether the frame is mirrored, so that its y axis lies to the right of its x axis.
    pub mirrored: bool,
}

impl Placement {
    /// The identity transform.
    pub const IDENTITY: Placement = Placement { origin: Vector::new(0.0, 0.0), angle_rad: 0.0, mirrored: false };

    /// Matrix that transforms directions to the outer frame. The matrix is orthogonal, with determinant -1 if the frame is mirrored.
    pub fn axes(&self) -> Matrix2<f64> {
        let sign = if self.mirrored { -1.0 } else { 1.0 };
        Rotation2::new(self.angle_rad).into_inner() * Matrix2::new(1.0, 0.0, 0.0, sign)
    }

    /// Transforms the coordinates of a point from this frame to the outer frame, mm.
    pub fn outwards(&self, point: Vector) -> Vector {
        self.origin + self.axes() * point
    }

    /// Transforms the coordinates of a point from the outer frame to this frame, mm.
    pub fn inwards(&self, point: Vector) -> Vector {
        self.axes().transpose() * (point - self.origin)
    }

    /// Concatenates two transforms: first this placement, then `outer`, which must not be mirrored.
    pub fn within(&self, outer: &Placement) -> Placement {
        Placement {
            origin: outer.outwards(self.origin),
            angle_rad: self.angle_rad + outer.angle_rad,
            mirrored: self.mirrored,
        }
    }
}
