//! Placement of a finger in an image, relative to where the scene's camera pose puts the finger.

use finray_model::Vector;
use nalgebra::{Complex, Rotation2};

/// Range of the finger's size in the image, relative to its size at the scene's camera pose. Outside this range, markers are not detected.
const SCALES: std::ops::Range<f64> = 0.4..2.5;
/// A rotation of the finger by less than this, degrees, counts as no rotation.
const TURN_DEG: f64 = 1.0;
/// A scale that deviates from 1 by less than this counts as 1.
const SCALE: f64 = 0.01;
/// A displacement of less than this, mm, counts as no displacement.
const SHIFT_MM: f64 = 1.0;

/// Placement of the finger in an image, relative to where the scene's camera pose puts the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FingerPlacement {
    /// Whether the finger is mirrored.
    pub is_mirrored: bool,
    /// Rotation of the finger in the plane, rad; for a mirrored finger, the rotation after mirroring about the finger's x axis.
    pub turn_rad: f64,
    /// Size of the finger in the image, relative to its size at the scene's camera pose, dimensionless.
    pub scale: f64,
    /// Position of the finger's origin, mm, in the finger frame at the scene's camera pose.
    pub origin: Vector,
}

impl std::fmt::Display for FingerPlacement {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let turn_deg = self.turn_rad.to_degrees().abs();
        let mut parts = Vec::new();
        if self.is_mirrored {
            parts.push("mirrored".to_owned());
        }
        if turn_deg > TURN_DEG {
            parts.push(format!("turned by {turn_deg:.0} degrees"));
        }
        if (self.scale - 1.0).abs() > SCALE {
            parts.push(format!("{:.2} times as large", self.scale));
        }
        if self.origin.norm() > SHIFT_MM {
            parts.push(format!("its base displaced by {:.1} mm", self.origin.norm()));
        }
        write!(f, "{}", parts.join(", "))
    }
}

impl FingerPlacement {
    /// The placement that maps two points of the finger frame (mm) to two observed points (mm). `None` if the scale is out of range.
    pub(super) fn through(ends: [Vector; 2], seen: [Vector; 2], is_mirrored: bool) -> Option<FingerPlacement> {
        let [from, to] = ends.map(|end| mirrored(&end, is_mirrored));
        let [along, seen_along] = [to - from, seen[1] - seen[0]].map(|step| Complex::new(step.x, step.y));
        let ratio = seen_along / along;
        let (scale, turn_rad) = (ratio.norm(), ratio.arg());
        let origin = seen[0] - Rotation2::new(turn_rad) * from * scale;
        SCALES.contains(&scale).then_some(FingerPlacement { is_mirrored, turn_rad, scale, origin })
    }

    /// Finger coordinates of an observed point, mm.
    pub(super) fn to_finger(self, seen: &Vector) -> Vector {
        let turned = Rotation2::new(-self.turn_rad) * (seen - self.origin) / self.scale;
        mirrored(&turned, self.is_mirrored)
    }

    /// Whether the placement differs noticeably from where the scene's camera pose puts the finger.
    pub(super) fn is_other(&self) -> bool {
        self.is_mirrored
            || self.turn_rad.to_degrees().abs() > TURN_DEG
            || (self.scale - 1.0).abs() > SCALE
            || self.origin.norm() > SHIFT_MM
    }
}

pub(super) fn mirrored(at: &Vector, is_mirrored: bool) -> Vector {
    if is_mirrored { Vector::new(at.x, -at.y) } else { *at }
}
