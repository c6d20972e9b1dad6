//! Where a finger stands in the frame of a gripper.

use crate::Vector;
use nalgebra::{Matrix2, Rotation2};

/// A plane frame in another one: mirrored in its x axis where it is, then turned, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Where its origin is, mm.
    pub origin: Vector,
    /// The angle of its x axis, rad.
    pub angle_rad: f64,
    /// Whether its y axis is on the right of its x axis.
    pub mirrored: bool,
}

impl Placement {
    /// The frame itself.
    pub const IDENTITY: Placement = Placement { origin: Vector::new(0.0, 0.0), angle_rad: 0.0, mirrored: false };

    /// The part that takes directions out of the frame: orthogonal, with determinant -1 where mirrored.
    pub fn axes(&self) -> Matrix2<f64> {
        let sign = if self.mirrored { -1.0 } else { 1.0 };
        Rotation2::new(self.angle_rad).into_inner() * Matrix2::new(1.0, 0.0, 0.0, sign)
    }

    /// A point of the frame as the outer frame has it, mm.
    pub fn outwards(&self, point: Vector) -> Vector {
        self.origin + self.axes() * point
    }

    /// A point of the outer frame as the frame has it, mm.
    pub fn inwards(&self, point: Vector) -> Vector {
        self.axes().transpose() * (point - self.origin)
    }

    /// The frame in what `outer` stands in; `outer` is not mirrored.
    pub fn within(&self, outer: &Placement) -> Placement {
        Placement {
            origin: outer.outwards(self.origin),
            angle_rad: self.angle_rad + outer.angle_rad,
            mirrored: self.mirrored,
        }
    }
}
