//! Pinhole camera with distortion.

use super::{Distortion, Pixel, ViewError};
use crate::keys::{CAMERA, Key, Kind};
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

/// Newton's method ends when a step is at most this share of 1 + radius. At a focal length of 1e5 px, this share corresponds to 1e-11 px.
const SETTLED: f64 = 1e-16;
/// Limit of the number of Newton iterations for the undistorted coordinates of a pixel.
const MOST_STEPS: usize = 50;
/// Number of points along each side of the image at which the distortion is inverted to find a fold in the image.
const SIDE_POINTS: usize = 32;

/// A lens and its image sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    size_px: [u32; 2],
    focal_px: Vector2<f64>,
    principal_point_px: Pixel,
    distortion: Distortion,
    /// Largest undistorted radius up to which the distorted radius grows, dimensionless.
    widest: f64,
}

/// Error for an invalid lens.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key}: expected {expected}")]
pub struct ImpossibleLens {
    /// Key of the scene's `[camera]` table that causes the error.
    pub key: &'static str,
    /// Expected and found value, in words.
    pub expected: String,
}

fn check<K: Kind>(key: &Key<K>, value: &K::Value) -> Result<(), ImpossibleLens> {
    key.check(value).map_err(|refused| ImpossibleLens {
        key: key.name,
        expected: format!("{}, found {}", refused.expected, refused.found),
    })
}

impl Lens {
    /// A lens with the given image size, focal lengths along u and v, and principal point (all in px), and distortion.
    ///
    /// # Errors
    /// [`ImpossibleLens`] for an empty image, focal lengths that are not positive, or values that are not finite or out of range.
    pub fn new(
        size_px: [u32; 2],
        focal_px: [f64; 2],
        principal_point_px: [f64; 2],
        distortion: Distortion,
    ) -> Result<Lens, ImpossibleLens> {
        check(&CAMERA.size_px, &size_px.map(f64::from))?;
        check(&CAMERA.focal_px, &focal_px)?;
        check(&CAMERA.principal_point_px, &principal_point_px)?;
        check(&CAMERA.distortion, &distortion.coefficients())?;
        Ok(Lens {
            size_px,
            focal_px: focal_px.into(),
            principal_point_px: principal_point_px.into(),
            distortion,
            widest: distortion.first_fold(),
        })
    }

    /// Whether a pixel on the border of the image lies beyond a fold of the distortion. The polynomials of calibrated lenses often fold in the corners of
    /// the image, beyond the calibrated points; a point there has no known pixel.
    pub fn folds_image(&self) -> bool {
        self.border().any(|pixel| self.undistorted(&pixel).is_err())
    }

    /// Width and height of the image, px.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Middle of the image, px.
    pub fn middle(&self) -> Pixel {
        Pixel::from(self.size_px.map(|side| f64::from(side.saturating_sub(1)) / 2.0))
    }

    /// Focal lengths along u and v, px.
    pub fn focal_px(&self) -> [f64; 2] {
        self.focal_px.into()
    }

    /// Principal point: the pixel on the optical axis.
    pub fn principal_point_px(&self) -> [f64; 2] {
        self.principal_point_px.into()
    }

    /// Distortion coefficients.
    pub fn distortion(&self) -> &Distortion {
        &self.distortion
    }

    /// Whether a pixel lies in the image. The border pixels of an image extend half a pixel beyond their centres.
    pub fn contains(&self, pixel: &Pixel) -> bool {
        (0..2).all(|axis| (-0.5..=f64::from(self.size_px[axis]) - 0.5).contains(&pixel[axis]))
    }

    /// Some pixels along the border of the image.
    fn border(&self) -> impl Iterator<Item = Pixel> + use<> {
        let [width, height] = self.size_px.map(f64::from);
        (0..=SIDE_POINTS).flat_map(move |i| {
            let share = i as f64 / SIDE_POINTS as f64;
            let (u, v) = (share * width - 0.5, share * height - 0.5);
            [Pixel::new(u, -0.5), Pixel::new(u, height - 0.5), Pixel::new(-0.5, v), Pixel::new(width - 0.5, v)]
        })
    }

    /// Pixel of a point of the camera frame, mm.
    ///
    /// # Errors
    /// [`ViewError`] if the point is behind the camera or beyond a fold of the distortion.
    pub fn project(&self, point: &Vector3<f64>) -> Result<Pixel, ViewError> {
        let bent = self.distortion.bend(&self.seen(point)?).ok_or(ViewError::Folded)?;
        self.on_sensor(bent)
    }

    /// Pixel of a point of the camera frame (mm), and the 2 x 3 derivatives of the pixel by the point's coordinates, px/mm.
    ///
    /// # Errors
    /// [`ViewError`] as for [`Lens::project`].
    pub fn project_with_derivatives(&self, point: &Vector3<f64>) -> Result<(Pixel, Matrix2x3<f64>), ViewError> {
        let at = self.seen(point)?;
        let (bent, by_at) = self.distortion.bend(&at).ok_or(ViewError::Folded)?;
        let pixel = self.on_sensor((bent, by_at))?;
        let by_point = Matrix2x3::new(1.0, 0.0, -at.x, 0.0, 1.0, -at.y) / point.z;
        Ok((pixel, Matrix2::from_diagonal(&self.focal_px) * by_at * by_point))
    }

    /// Undistorted coordinates X/Z and Y/Z of a point of the camera frame (mm), dimensionless.
    fn seen(&self, point: &Vector3<f64>) -> Result<Vector2<f64>, ViewError> {
        if point.z.is_nan() || point.z <= 0.0 {
            return Err(ViewError::Behind);
        }
        let at = point.xy() / point.z;
        if at.norm() > self.widest { Err(ViewError::Folded) } else { Ok(at) }
    }

    fn on_sensor(&self, (bent, by_at): (Vector2<f64>, Matrix2<f64>)) -> Result<Pixel, ViewError> {
        // The tangential part of the distortion may also fold the image.
        if by_at.determinant() <= 0.0 {
            return Err(ViewError::Folded);
        }
        Ok(self.principal_point_px + self.focal_px.component_mul(&bent))
    }

    /// Direction of the ray through a pixel, in the camera frame, scaled to z = 1.
    ///
    /// # Errors
    /// [`ViewError::Folded`] if the distortion has no inverse at the pixel.
    pub fn ray(&self, pixel: &Pixel) -> Result<Vector3<f64>, ViewError> {
        self.undistorted(pixel).map(|at| at.push(1.0))
    }

    /// Undistorted coordinates of a pixel, dimensionless. Newton's method first inverts the radial part, between bounds within which the solution is
    /// unique. Newton's method then inverts the radial and the tangential part together.
    pub fn undistorted(&self, pixel: &Pixel) -> Result<Vector2<f64>, ViewError> {
        let bent = (pixel - self.principal_point_px).component_div(&self.focal_px);
        let radius = bent.norm();
        let mut at = if radius > 0.0 { bent * (self.radius_of(radius).unwrap_or(self.widest) / radius) } else { bent };
        for _ in 0..MOST_STEPS {
            let (found, by_at) = self.distortion.bend(&at).ok_or(ViewError::Folded)?;
            if by_at.determinant() <= 0.0 {
                return Err(ViewError::Folded);
            }
            let step = by_at.lu().solve(&(bent - found)).ok_or(ViewError::Folded)?;
            at += step;
            // The tangential part may lead the iteration beyond the fold and back, so the limit is twice the radius of the fold.
            if at.norm() > 2.0 * self.widest {
                return Err(ViewError::Folded);
            }
            if step.norm() <= SETTLED * (1.0 + at.norm()) {
                break;
            }
        }
        let (found, by_at) = self.distortion.bend(&at).ok_or(ViewError::Folded)?;
        let solved = (found - bent).norm() <= 1e-12 * (1.0 + radius);
        if solved && at.norm() <= self.widest && by_at.determinant() > 0.0 { Ok(at) } else { Err(ViewError::Folded) }
    }

    /// Undistorted radius for the distorted radius `bent`, by the radial part alone. Both radii are dimensionless. `None` beyond the fold.
    fn radius_of(&self, bent: f64) -> Option<f64> {
        let (mut below, mut above) = (0.0, self.widest);
        if self.distortion.factor(above * above).is_none_or(|(f, _)| above * f < bent) {
            return None;
        }
        // At a pole, where a rational lens may end, Newton's method would hardly move.
        let mut r = if bent < above { bent } else { 0.5 * above };
        for _ in 0..MOST_STEPS {
            let (f, by_q) = self.distortion.factor(r * r)?;
            let excess = r * f - bent;
            if excess > 0.0 {
                above = r
            } else {
                below = r
            }
            let newton = r - excess / (f + 2.0 * r * r * by_q);
            let next = if newton > below && newton < above { newton } else { 0.5 * (below + above) };
            if (next - r).abs() <= f64::EPSILON * r {
                break;
            }
            r = next;
        }
        Some(r)
    }
}
