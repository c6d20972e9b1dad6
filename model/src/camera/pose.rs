//! Pose of the finger relative to a camera.

use crate::gripper::Placement;
use nalgebra::{Isometry2, Rotation3, Vector3, Vector6};
use std::f64::consts::PI;

/// Rigid motion from the finger frame to the camera frame: X_camera = R X + t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation R.
    pub rotation: Rotation3<f64>,
    /// Translation t, mm: the position of the finger frame's origin in the camera frame.
    pub translation_mm: Vector3<f64>,
}

impl Pose {
    /// A pose from the Rodrigues vector of R (axis times angle, rad) and the translation t (mm).
    pub fn new(rotation_vector_rad: [f64; 3], translation_mm: [f64; 3]) -> Pose {
        Pose {
            rotation: Rotation3::from_scaled_axis(rotation_vector_rad.into()),
            translation_mm: translation_mm.into(),
        }
    }

    /// Rodrigues vector of R (axis times angle), rad.
    pub fn rotation_vector_rad(&self) -> [f64; 3] {
        self.rotation.scaled_axis().into()
    }

    /// Pose of a frame in a visible plane. The frame's z axis is normal to the plane and points to the camera; its x axis runs along the rows of the
    /// image (u). The frame's origin `origin_mm` is a point of the plane. `normal` and `origin_mm` are in the camera frame.
    pub fn in_plane(normal: &Vector3<f64>, origin_mm: &Vector3<f64>) -> Pose {
        let z = if normal.dot(origin_mm) > 0.0 { -normal.normalize() } else { normal.normalize() };
        let x = (Vector3::x() - z * z.x).normalize();
        let rotation = Rotation3::from_basis_unchecked(&[x, z.cross(&x), z]);
        Pose { rotation, translation_mm: *origin_mm }
    }

    /// Camera coordinates of a point of the finger frame, mm.
    pub fn to_camera(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation_mm
    }

    /// Position of the camera's optical centre in the finger frame, mm.
    pub fn eye(&self) -> Vector3<f64> {
        -(self.rotation.inverse() * self.translation_mm)
    }

    /// The pose after a motion of the finger in the camera frame: a rotation about the finger frame's origin (rotation vector, rad) and a translation (mm).
    pub fn moved(&self, motion: &Vector6<f64>) -> Pose {
        let turn = Rotation3::from_scaled_axis(motion.fixed_rows::<3>(0).into_owned());
        Pose { rotation: turn * self.rotation, translation_mm: self.translation_mm + motion.fixed_rows::<3>(3) }
    }

    /// The pose after the finger has moved in its plane by `base`, so that a point at X lies at `base` X.
    pub fn of_moved_base(&self, base: &Isometry2<f64>) -> Pose {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), base.rotation.angle());
        let shift = base.translation.vector.push(0.0);
        Pose { rotation: self.rotation * turn, translation_mm: self.to_camera(&shift) }
    }

    /// The pose of a finger with a `placement` in the frame of this pose, by eqs (9) and (10) of Xu et al. 2021. A mirrored finger is rotated by half
    /// a turn about its x axis, so its z axis is opposite to the z axis of the frame.
    pub fn of_placed_finger(&self, placement: &Placement) -> Pose {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), placement.angle_rad);
        let turn = if placement.mirrored { turn * Rotation3::from_axis_angle(&Vector3::x_axis(), PI) } else { turn };
        Pose { rotation: self.rotation * turn, translation_mm: self.to_camera(&placement.origin.push(0.0)) }
    }
}
