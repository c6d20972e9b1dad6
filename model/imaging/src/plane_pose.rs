//! Pose of a plane from the pixels of known points on it.

use finray_model::Vector;
use finray_model::camera::{Lens, Pixel, Pose, ViewError};
use finray_numerics::optimise::{Fit, LeastSquaresProblem, LevenbergMarquardt, Refusal};
use nalgebra::{DMatrix, DVector, Matrix2x6, Matrix3, Matrix6, Rotation3, Vector2, Vector3};

/// A pose needs at least this number of points. If there are only four points, no three of them may be collinear.
const LEAST_POINTS: usize = 4;
/// Points count as collinear if their spread perpendicular to their best-fitting line, divided by their spread along this line, is below this ratio.
const LEAST_SPREAD: f64 = 1e-3;

/// A fitted pose with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseFit {
    /// The pose.
    pub pose: Pose,
    /// Residual standard deviation of one pixel coordinate, px, with 2 n - 6 degrees of freedom for n points.
    pub residual_sd_px: f64,
    /// 6 x 6 covariance of the pose for pixel coordinates with a standard deviation of 1 px. The six unknowns of the pose are a small motion of the
    /// camera frame: rotation vector in rad, then translation in mm. For other pixel errors, the covariance is this matrix times the variance of a
    /// pixel coordinate in px^2.
    pub unit_covariance: Matrix6<f64>,
}

/// Reason why points do not determine a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PlanePoseError {
    /// There are too few points.
    #[error("a pose needs at least {LEAST_POINTS} points, found {found}")]
    TooFew {
        /// Number of points.
        found: usize,
    },
    /// The points are collinear in the plane or in the image.
    #[error("a pose needs points that do not lie on one line")]
    OnALine,
    /// A pixel lies beyond the radius at which the distortion of the lens folds the image.
    #[error("a pixel lies where the distortion of the lens folds the image")]
    Folded,
    /// No pose projects the points to their pixels.
    #[error("no pose of the camera projects the points onto their pixels")]
    NotFound,
}

/// Fits a pose to the pixels of points on the plane z = `height_mm` of the finger frame. `points` contains the position (mm) and the pixel of each
/// point. The homography from the points to their undistorted pixels gives the starting point of the least-squares fit. The pixels of a distant plane
/// fit nearly as well with the opposite tilt, so the fit is started from both tilts.
///
/// # Errors
/// [`PlanePoseError`] for fewer than four points, collinear points, a pixel where the lens distortion folds the image, or no pose that fits.
///
/// # Reference
/// Z. Zhang, A flexible new technique for camera calibration, IEEE Trans. PAMI 22 (2000), sec. 3.1 and app. A. The second tilt follows
/// G. Schweighofer and A. Pinz, Robust pose estimation from a planar target, IEEE Trans. PAMI 28 (2006).
pub fn plane_pose(lens: &Lens, height_mm: f64, points: &[(Vector, Pixel)]) -> Result<PoseFit, PlanePoseError> {
    if points.len() < LEAST_POINTS {
        return Err(PlanePoseError::TooFew { found: points.len() });
    }
    let seen: Result<Vec<Vector2<f64>>, _> = points.iter().map(|(_, pixel)| lens.undistorted(pixel)).collect();
    let seen = seen.map_err(|_| PlanePoseError::Folded)?;
    let positions: Vec<Vector2<f64>> = points.iter().map(|(position, _)| *position).collect();
    if on_a_line(&positions) || on_a_line(&seen) {
        return Err(PlanePoseError::OnALine);
    }
    let homography = homography(&positions, &seen).ok_or(PlanePoseError::OnALine)?;
    let mean: Vector2<f64> = positions.iter().sum::<Vector2<f64>>() / positions.len() as f64;
    let first = of_homography(&homography, &mean, height_mm).ok_or(PlanePoseError::NotFound)?;
    let starts = [first, tilted_back(&first, &mean.push(height_mm))];
    let mut problem = PoseProblem { lens, height_mm, points };
    let fits: Vec<Fit<Pose>> = starts
        .into_iter()
        .filter_map(|start| LevenbergMarquardt::default().minimise(&mut problem, start).ok())
        .collect();
    let best = fits.into_iter().min_by(|a, b| a.squares.total_cmp(&b.squares)).ok_or(PlanePoseError::NotFound)?;
    let freedom = 2 * points.len() - 6;
    let inverse = best.covariance().ok_or(PlanePoseError::OnALine)?;
    Ok(PoseFit {
        pose: best.point,
        residual_sd_px: if freedom > 0 { (best.squares / freedom as f64).sqrt() } else { 0.0 },
        unit_covariance: Matrix6::from_fn(|i, j| inverse[(i, j)]),
    })
}

/// Least-squares problem for the pixels of points on a plane. The unknowns are a small motion of the camera frame.
struct PoseProblem<'p> {
    lens: &'p Lens,
    height_mm: f64,
    points: &'p [(Vector, Pixel)],
}

impl LeastSquaresProblem for PoseProblem<'_> {
    type Point = Pose;
    type Error = ViewError;

    fn residual(&mut self, pose: &Pose) -> Result<DVector<f64>, Refusal<ViewError>> {
        let mut residual = DVector::zeros(2 * self.points.len());
        for (i, (position, pixel)) in self.points.iter().enumerate() {
            let found = self.lens.project(&pose.to_camera(&position.push(self.height_mm))).map_err(Refusal::Here)?;
            residual.fixed_rows_mut::<2>(2 * i).copy_from(&(found - pixel));
        }
        Ok(residual)
    }

    fn jacobian(&mut self, pose: &Pose, _: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<ViewError>> {
        let mut jacobian = DMatrix::zeros(2 * self.points.len(), 6);
        for (i, (position, _)) in self.points.iter().enumerate() {
            let by_motion = by_motion(self.lens, pose, &position.push(self.height_mm)).map_err(Refusal::Here)?;
            jacobian.fixed_rows_mut::<2>(2 * i).copy_from(&by_motion);
        }
        Ok(jacobian)
    }

    fn moved(&self, pose: &Pose, step: &DVector<f64>) -> Pose {
        pose.moved(&step.fixed_rows::<6>(0).into_owned())
    }
}

/// 2 x 6 derivatives of the pixel of a point by a small motion of the camera frame, px/rad and px/mm. A small rotation vector w changes R X by d(R X)
/// = w x R X = -[R X]x w, where [v]x is the matrix of the cross product with v.
pub(super) fn by_motion(lens: &Lens, pose: &Pose, point: &Vector3<f64>) -> Result<Matrix2x6<f64>, ViewError> {
    let (_, by_camera) = lens.project_with_derivatives(&pose.to_camera(point))?;
    let turned = pose.rotation * point;
    let mut by = Matrix2x6::zeros();
    by.fixed_columns_mut::<3>(0).copy_from(&(-by_camera * turned.cross_matrix()));
    by.fixed_columns_mut::<3>(3).copy_from(&by_camera);
    Ok(by)
}

/// Transform after which the points have mean zero and a root mean square distance of sqrt(2) from the origin.
fn normalisation(points: &[Vector2<f64>]) -> Matrix3<f64> {
    let count = points.len() as f64;
    let mean = points.iter().sum::<Vector2<f64>>() / count;
    let spread = (points.iter().map(|point| (point - mean).norm_squared()).sum::<f64>() / count).sqrt();
    let scale = std::f64::consts::SQRT_2 / spread;
    Matrix3::new(scale, 0.0, -scale * mean.x, 0.0, scale, -scale * mean.y, 0.0, 0.0, 1.0)
}

fn on_a_line(points: &[Vector2<f64>]) -> bool {
    let mean = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let centred = DMatrix::from_fn(points.len(), 2, |i, j| (points[i] - mean)[j]);
    let spreads = centred.svd(false, false).singular_values;
    spreads.min() <= LEAST_SPREAD * spreads.max()
}

/// Homography H with seen ~ H (position, 1), by the direct linear transform of normalised points; `None` if H is not unique.
///
/// # Reference
/// R. Hartley and A. Zisserman, Multiple View Geometry, algorithm 4.2.
pub(super) fn homography(positions: &[Vector2<f64>], seen: &[Vector2<f64>]) -> Option<Matrix3<f64>> {
    let (from, to) = (normalisation(positions), normalisation(seen));
    let mut rows = DMatrix::zeros((2 * positions.len()).max(9), 9);
    for (i, (position, seen)) in positions.iter().zip(seen).enumerate() {
        let (p, q) = (from * position.push(1.0), to * seen.push(1.0));
        for k in 0..3 {
            rows[(2 * i, k)] = p[k];
            rows[(2 * i, 6 + k)] = -q.x * p[k];
            rows[(2 * i + 1, 3 + k)] = p[k];
            rows[(2 * i + 1, 6 + k)] = -q.y * p[k];
        }
    }
    let parts = rows.svd(false, true);
    // If three of four points are collinear, the homography is not unique.
    if parts.singular_values[7] <= LEAST_SPREAD.powi(2) * parts.singular_values[0] {
        return None;
    }
    let right = parts.v_t?;
    let last = right.row(8);
    let normalised = Matrix3::from_fn(|i, j| last[3 * i + j]);
    Some(to.try_inverse()? * normalised * from)
}

/// Pose from the homography H ~ [r1 r2 R (0, 0, height) + t] of the plane z = `height_mm`. The sign of H is chosen so that the points' mean lies in
/// front of the camera.
fn of_homography(homography: &Matrix3<f64>, mean: &Vector2<f64>, height_mm: f64) -> Option<Pose> {
    let scale = 2.0 / (homography.column(0).norm() + homography.column(1).norm());
    let depth = (homography * mean.push(1.0)).z;
    let scale = if depth < 0.0 { -scale } else { scale };
    let columns = homography * scale;
    let (first, second) = (columns.column(0).into_owned(), columns.column(1).into_owned());
    let near = Matrix3::from_columns(&[first, second, first.cross(&second)]);
    let parts = near.svd(true, true);
    let (left, right) = (parts.u?, parts.v_t?);
    let sign = (left * right).determinant().signum();
    let rotation = left * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * right;
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    let translation_mm = columns.column(2) - rotation * Vector3::new(0.0, 0.0, height_mm);
    Some(Pose { rotation, translation_mm })
}

/// The pose after the plane's normal is mirrored about the ray from the camera to a point of the plane. This point keeps its position.
fn tilted_back(pose: &Pose, point: &Vector3<f64>) -> Pose {
    let seen = pose.to_camera(point);
    let ray = seen.normalize();
    let normal = pose.rotation * Vector3::z();
    let mirrored = ray * (2.0 * ray.dot(&normal)) - normal;
    let turn = Rotation3::rotation_between(&normal, &mirrored).unwrap_or_else(Rotation3::identity);
    let rotation = turn * pose.rotation;
    Pose { rotation, translation_mm: seen - rotation * point }
}
