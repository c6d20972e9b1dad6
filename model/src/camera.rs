//! The camera: from points of the finger frame to pixels and back.
//!
//! A point X (mm, finger frame, z = x cross y) stands at X_camera = R X + t ([`Pose`]). The lens ([`Lens`]) projects it to
//! x = X/Z, y = Y/Z, bends these by its distortion and scales them to pixels: u to the right, v down, the centre of the first pixel at
//! (0, 0). One image does not show how far away a point is; a point of a known plane z = height has one pixel, and back.

mod leave_one_out;
mod lens;
mod lens_fit;
mod plane_pose;
mod pose;
mod usual_lens;

pub use lens::{Distortion, ImpossibleLens, Lens};
pub use lens_fit::{LENS_PARAMETERS, LensFit, LensFitError, fit_lens};
pub use plane_pose::{PlanePoseError, PoseFit, plane_pose};
pub use pose::Pose;

use crate::Vector;
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

/// A position in an image, px: u to the right, v down.
pub type Pixel = Vector2<f64>;

/// Smallest cosine between the ray and a plane's normal at which a pixel has a position on the plane: at 1 degree to the plane, a
/// hundredth of a pixel is seen as half a pixel.
const LEAST_SLOPE: f64 = 0.0175;

/// A camera whose lens and pose are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Its lens and sensor.
    pub lens: Lens,
    /// Where the finger stands before it.
    pub pose: Pose,
}

/// Why a point has no pixel, or a pixel no point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ViewError {
    /// The point is not in front of the camera.
    #[error("is behind the camera")]
    Behind,
    /// The distortion model folds the image before the point: beyond, two points share a pixel.
    #[error("is where the lens's distortion folds the image")]
    Folded,
    /// The ray meets the plane at less than a degree, or not at all.
    #[error("is seen along the plane of the finger")]
    Grazing,
}

impl Camera {
    /// The pixel of a point of the finger frame, mm. It may lie outside the image: see [`Lens::contains`].
    ///
    /// # Errors
    /// [`ViewError`] for a point that the lens does not project.
    pub fn project(&self, point: &Vector3<f64>) -> Result<Pixel, ViewError> {
        self.lens.project(&self.pose.to_camera(point))
    }

    /// The pixel of a point and its derivatives by the point's coordinates, px/mm.
    ///
    /// # Errors
    /// As [`Camera::project`].
    pub fn project_with_derivatives(&self, point: &Vector3<f64>) -> Result<(Pixel, Matrix2x3<f64>), ViewError> {
        let (pixel, by_camera) = self.lens.project_with_derivatives(&self.pose.to_camera(point))?;
        Ok((pixel, by_camera * self.pose.rotation.matrix()))
    }

    /// The point of the plane z = `height_mm` of the finger frame that is seen at a pixel, mm.
    ///
    /// # Errors
    /// [`ViewError`] if no point of the plane is seen there.
    pub fn on_plane(&self, pixel: &Pixel, height_mm: f64) -> Result<Vector, ViewError> {
        let ray = self.pose.rotation.inverse() * self.lens.ray(pixel)?;
        let eye = self.pose.eye();
        if ray.z.abs() < LEAST_SLOPE * ray.norm() {
            return Err(ViewError::Grazing);
        }
        let along = (height_mm - eye.z) / ray.z;
        if along <= 0.0 {
            return Err(ViewError::Behind);
        }
        Ok((eye + ray * along).xy())
    }

    /// The point of the plane z = `height_mm` at a pixel, mm, and its derivatives by the pixel, mm/px.
    ///
    /// # Errors
    /// As [`Camera::on_plane`].
    pub fn on_plane_with_derivatives(
        &self,
        pixel: &Pixel,
        height_mm: f64,
    ) -> Result<(Vector, Matrix2<f64>), ViewError> {
        let point = self.on_plane(pixel, height_mm)?;
        let (_, by_point) = self.project_with_derivatives(&point.push(height_mm))?;
        let in_plane: Matrix2<f64> = by_point.fixed_columns::<2>(0).into_owned();
        Ok((point, in_plane.try_inverse().ok_or(ViewError::Grazing)?))
    }

    /// Standard deviation of one coordinate of a point of the plane z = `height_mm`, mm, root mean square of x and y, if each coordinate
    /// of its pixel has the standard deviation `pixel_sd_px`. To first order: J J^T times the variance, J by the pixel.
    ///
    /// # Errors
    /// As [`Camera::on_plane`].
    pub fn position_sd_mm(&self, pixel: &Pixel, height_mm: f64, pixel_sd_px: f64) -> Result<f64, ViewError> {
        let (_, by_pixel) = self.on_plane_with_derivatives(pixel, height_mm)?;
        Ok(pixel_sd_px * (by_pixel.norm_squared() / 2.0).sqrt())
    }
}
