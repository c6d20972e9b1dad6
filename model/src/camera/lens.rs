//! Pinhole camera with Brown-Conrady distortion.

use super::{Pixel, ViewError};
use crate::keys::{CAMERA, Key, Numbers};
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

/// Tangent of the largest considered angle from the optical axis, 79 degrees.
const WIDEST: f64 = 5.0;
/// Number of radii at which a fold is searched for. This number suffices, because the slope of the distorted radius is a cubic in r^2 with at most
/// three roots.
const FOLD_STEPS: usize = 2000;
/// Newton's method ends when a step is at most this share of 1 + radius. At a focal length of 1e5 px, this share corresponds to 1e-11 px.
const SETTLED: f64 = 1e-16;
/// Limit of the number of Newton iterations for the undistorted coordinates of a pixel.
const MOST_STEPS: usize = 50;
/// Number of points along each side of the image at which the distortion must be invertible.
const SIDE_POINTS: usize = 32;

/// Distortion coefficients in OpenCV's convention. Here r^2 = x^2 + y^2 and f = 1 + k1 r^2 + k2 r^4 + k3 r^6.
///
/// The distorted coordinates are x' = x f + 2 p1 x y + p2 (r^2 + 2 x^2) and y' = y f + p1 (r^2 + 2 y^2) + 2 p2 x y.
///
/// Source: D. C. Brown, Decentering distortion of lenses, Photogrammetric Engineering 32 (1966); OpenCV, calib3d.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// Radial coefficients k1, k2, k3, dimensionless.
    pub radial: [f64; 3],
    /// Tangential coefficients p1, p2, dimensionless.
    pub tangential: [f64; 2],
}

impl Distortion {
    /// Distortion from the coefficients k1, k2, p1, p2, k3, in OpenCV's order.
    pub fn from_opencv([k1, k2, p1, p2, k3]: [f64; 5]) -> Distortion {
        Distortion { radial: [k1, k2, k3], tangential: [p1, p2] }
    }

    /// The coefficients k1, k2, p1, p2, k3, in OpenCV's order.
    pub fn to_opencv(&self) -> [f64; 5] {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        [k1, k2, p1, p2, k3]
    }

    /// Radial factor f and its derivative by q = r^2; dimensionless.
    fn factor(&self, q: f64) -> (f64, f64) {
        let [k1, k2, k3] = self.radial;
        (1.0 + q * (k1 + q * (k2 + q * k3)), k1 + q * (2.0 * k2 + q * 3.0 * k3))
    }

    /// Distorted coordinates, and their 2 x 2 derivatives by the undistorted coordinates; dimensionless.
    fn bend(&self, at: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let (x, y, q) = (at.x, at.y, at.norm_squared());
        let (f, slope) = self.factor(q);
        let [p1, p2] = self.tangential;
        let bent = Vector2::new(
            x * f + 2.0 * p1 * x * y + p2 * (q + 2.0 * x * x),
            y * f + p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let mixed = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let by_x = f + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let by_y = f + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        (bent, Matrix2::new(by_x, mixed, mixed, by_y))
    }

    /// Undistorted radius of the first fold of the radial part, where r f(r^2) stops growing; dimensionless, at most [`WIDEST`].
    fn first_fold(&self) -> f64 {
        let slope = |r: f64| {
            let (f, by_q) = self.factor(r * r);
            f + 2.0 * r * r * by_q
        };
        let radius = |step: usize| WIDEST * step as f64 / FOLD_STEPS as f64;
        let Some(step) = (1..=FOLD_STEPS).find(|&step| slope(radius(step)) <= 0.0) else { return WIDEST };
        let (mut below, mut above) = (radius(step - 1), radius(step));
        while above - below > f64::EPSILON * above {
            let middle = 0.5 * (below + above);
            if middle <= below || middle >= above {
                break;
            }
            if slope(middle) > 0.0 { below = middle } else { above = middle }
        }
        below
    }
}

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

fn check<const N: usize>(key: &Key<Numbers<N>>, value: [f64; N]) -> Result<(), ImpossibleLens> {
    key.check(&value).map_err(|refused| ImpossibleLens {
        key: key.name,
        expected: format!("{}, found {}", refused.expected, refused.found),
    })
}

impl Lens {
    /// A lens with the given image size, focal lengths along u and v, and principal point (all in px), and distortion.
    ///
    /// # Errors
    /// [`ImpossibleLens`] for an empty image, focal lengths that are not positive, values that are not finite or out of range, or a distortion that
    /// folds the image.
    pub fn new(
        size_px: [u32; 2],
        focal_px: [f64; 2],
        principal_point_px: [f64; 2],
        distortion: Distortion,
    ) -> Result<Lens, ImpossibleLens> {
        check(&CAMERA.size_px, size_px.map(f64::from))?;
        check(&CAMERA.focal_px, focal_px)?;
        check(&CAMERA.principal_point_px, principal_point_px)?;
        check(&CAMERA.distortion, distortion.to_opencv())?;
        let lens = Lens {
            size_px,
            focal_px: focal_px.into(),
            principal_point_px: principal_point_px.into(),
            distortion,
            widest: distortion.first_fold(),
        };
        match lens.border().find(|pixel| lens.undistorted(pixel).is_err()) {
            None => Ok(lens),
            Some(pixel) => {
                let at = format!("pixel ({:.0}, {:.0})", pixel.x, pixel.y);
                let expected = format!(
                    "coefficients that do not fold the image; these coefficients fold the image between its middle and \
                    {at}"
                );
                Err(ImpossibleLens { key: CAMERA.distortion.name, expected })
            }
        }
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
        let bent = self.distortion.bend(&self.seen(point)?);
        self.on_sensor(bent)
    }

    /// Pixel of a point of the camera frame (mm), and the 2 x 3 derivatives of the pixel by the point's coordinates, px/mm.
    ///
    /// # Errors
    /// [`ViewError`] as for [`Lens::project`].
    pub fn project_with_derivatives(&self, point: &Vector3<f64>) -> Result<(Pixel, Matrix2x3<f64>), ViewError> {
        let at = self.seen(point)?;
        let (bent, by_at) = self.distortion.bend(&at);
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
            let (found, by_at) = self.distortion.bend(&at);
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
        let (found, by_at) = self.distortion.bend(&at);
        let solved = (found - bent).norm() <= 1e-12 * (1.0 + radius);
        if solved && at.norm() <= self.widest && by_at.determinant() > 0.0 { Ok(at) } else { Err(ViewError::Folded) }
    }

    /// Undistorted radius for the distorted radius `bent`, by the radial part alone. Both radii are dimensionless. `None` beyond the fold.
    fn radius_of(&self, bent: f64) -> Option<f64> {
        let (mut below, mut above) = (0.0, self.widest);
        let radial = |r: f64| r * self.distortion.factor(r * r).0;
        if radial(above) < bent {
            return None;
        }
        let mut r = bent.min(above);
        for _ in 0..MOST_STEPS {
            let (f, by_q) = self.distortion.factor(r * r);
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
