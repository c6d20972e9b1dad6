//! The camera converts points of the finger frame to pixels, and pixels to points.
//!
//! A point X (mm, finger frame, z = x cross y) has the camera coordinates X_camera = R X + t ([`Pose`]). The lens ([`Lens`]) projects the point to x
//! = X/Z, y = Y/Z, applies its distortion, and scales the result to pixels. Pixel coordinates are u to the right and v down; the centre of the first
//! pixel is (0, 0). One image does not determine the distance of a point. However, a pixel determines one point on a plane z = height if the height
//! is known.

mod distortion;
mod lens;
mod pose;

pub use distortion::{CoefficientsError, Distortion, Radial};
pub use lens::{ImpossibleLens, Lens};
pub use pose::Pose;

use crate::Vector;
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

/// A position in an image, px: u to the right, v down.
pub type Pixel = Vector2<f64>;

/// A pixel has no position on a plane if the sine of the angle between its ray and the plane is below this limit. At the limit of 1 degree, an error
/// of 0.01 px moves the position as far as an error of about 0.5 px does in a perpendicular view.
const LEAST_SLOPE: f64 = 0.0175;

/// A camera with its lens and its pose, both known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Lens and image sensor.
    pub lens: Lens,
    /// Pose of the finger frame relative to the camera.
    pub pose: Pose,
}

/// Reason why a point has no pixel, or a pixel has no point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ViewError {
    /// The point is behind the camera.
    #[error("is behind the camera")]
    Behind,
    /// The point lies beyond a fold of the distortion model, so that another point has the same pixel.
    #[error("lies where the distortion of the lens folds the image")]
    Folded,
    /// The ray of the pixel does not meet the plane, or meets it at an angle below one degree.
    #[error("is on a line of sight (nearly) parallel to the finger's plane")]
    Grazing,
}

impl Camera {
    /// Pixel of a point of the finger frame, mm. The pixel may lie outside the image: see [`Lens::contains`].
    ///
    /// # Errors
    /// [`ViewError`] if the point is behind the camera or beyond a fold of the distortion.
    pub fn project(&self, point: &Vector3<f64>) -> Result<Pixel, ViewError> {
        self.lens.project(&self.pose.to_camera(point))
    }

    /// Pixel of a point of the finger frame (mm), and the 2 x 3 derivatives of the pixel by the point's coordinates, px/mm.
    ///
    /// # Errors
    /// [`ViewError`] as for [`Camera::project`].
    pub fn project_with_derivatives(&self, point: &Vector3<f64>) -> Result<(Pixel, Matrix2x3<f64>), ViewError> {
        let (pixel, by_camera) = self.lens.project_with_derivatives(&self.pose.to_camera(point))?;
        Ok((pixel, by_camera * self.pose.rotation.matrix()))
    }

    /// Point (mm, finger frame) that a pixel shows on the plane z = `height_mm`.
    ///
    /// # Errors
    /// [`ViewError`] if the ray grazes or misses the plane, or the distortion folds the image at the pixel.
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

    /// Point (mm, finger frame) that a pixel shows on the plane z = `height_mm`, and the 2 x 2 derivatives of this point by the pixel, mm/px.
    ///
    /// # Errors
    /// [`ViewError`] as for [`Camera::on_plane`].
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

    /// Standard deviation per coordinate, mm, of the point that a pixel shows on the plane z = `height_mm`: the root mean square of the standard
    /// deviations of x and y. Each coordinate of the pixel has the standard deviation `pixel_sd_px`. To first order, the covariance of the point is J
    /// J^T times the pixel's variance. J is the matrix of derivatives of the point by the pixel.
    ///
    /// # Errors
    /// [`ViewError`] as for [`Camera::on_plane`].
    pub fn position_sd_mm(&self, pixel: &Pixel, height_mm: f64, pixel_sd_px: f64) -> Result<f64, ViewError> {
        let (_, by_pixel) = self.on_plane_with_derivatives(pixel, height_mm)?;
        Ok(pixel_sd_px * (by_pixel.norm_squared() / 2.0).sqrt())
    }
}
