//! Estimation of a lens from images of a plane grid.

mod leave_one_out;
mod usual_lens;

use crate::plane_pose::{PlanePoseError, by_motion, homography, plane_pose};
use finray_model::Vector;
use finray_model::camera::{Distortion, ImpossibleLens, Lens, Pixel, Pose};
use finray_model::keys::CAMERA;
use finray_numerics::optimise::{Fit, LeastSquaresProblem, LevenbergMarquardt, Prior, Refusal};
use nalgebra::{DMatrix, DVector, Vector2};
use usual_lens::{PARAMETERS, UsualLens};

/// Names of the lens's parameters, in order. fx, fy, cx and cy are in px; the others are dimensionless.
pub const LENS_PARAMETERS: [&str; PARAMETERS] = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];
/// Prior standard deviation of the logarithm of the focal lengths.
const FOCAL_SD: f64 = 0.7;
/// Prior standard deviation of the logarithm of the focal lengths in the first fit of the distortion, which holds the focal lengths near their
/// starting values.
const HELD_FOCAL_SD: f64 = 0.01;
/// Typical focal length in image widths, for a field of view of 45 degrees.
const USUAL_FOCUS: f64 = 1.2;
/// Focal lengths at the starting points of the search, in image widths: wide-angle, normal and telephoto lens.
const STARTS: [f64; 3] = [0.6, 1.2, 3.0];
/// Assumed noise of a dot's centre, px, in the first fit. The assumed noise determines the weight of the priors until the residual is known.
const FIRST_NOISE_PX: f64 = 0.1;
/// Lower bound of the estimated noise of a dot's centre, px.
const LEAST_NOISE_PX: f64 = 0.002;
/// Number of rounds that alternate fit and noise estimate.
const ROUNDS: usize = 3;
/// An image must show at least this number of dots.
const LEAST_POINTS: usize = 12;

/// A fitted lens with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct LensFit {
    /// The lens.
    pub lens: Lens,
    /// Standard deviations of the parameters, in the order and units of [`LENS_PARAMETERS`]. Each standard deviation is the larger of two estimates:
    /// one from independent noise of the residuals' size, the other from the scatter between images.
    pub sds: [f64; PARAMETERS],
    /// For each parameter, whether the images determine it better than the prior: its variance from noise is below half of the prior's variance.
    pub is_shown: [bool; PARAMETERS],
    /// Pose of the grid relative to the camera, one per image.
    pub poses: Vec<Pose>,
    /// Residual standard deviation of one pixel coordinate, px.
    pub residual_sd_px: f64,
}

impl LensFit {
    /// Pose of the grid in each image for a known lens, whose parameters have no standard deviation.
    pub(crate) fn of_known(lens: &Lens, views: &[Vec<(Vector, Pixel)>]) -> Result<LensFit, LensFitError> {
        let pose = |(i, view): (usize, &Vec<(Vector, Pixel)>)| {
            plane_pose(lens, 0.0, view).map_err(|reason| LensFitError::Pose { image: i + 1, reason })
        };
        let fits = views.iter().enumerate().map(pose).collect::<Result<Vec<_>, _>>()?;
        Ok(LensFit {
            lens: *lens,
            sds: [0.0; PARAMETERS],
            is_shown: [true; PARAMETERS],
            poses: fits.iter().map(|fit| fit.pose).collect(),
            residual_sd_px: fits.iter().map(|fit| fit.residual_sd_px).fold(0.0, f64::max),
        })
    }
}

/// Reason why images do not determine a lens.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LensFitError {
    /// There are no images.
    #[error("expected at least one image of a grid")]
    NoView,
    /// An image shows too few dots of the grid.
    #[error("image {image} shows {found} dots of the grid, expected at least {LEAST_POINTS}")]
    TooFew {
        /// Number of the image, from 1.
        image: usize,
        /// Number of dots found.
        found: usize,
    },
    /// The dots of an image do not determine the grid's pose.
    #[error("image {image}: {reason}")]
    Pose {
        /// Number of the image, from 1.
        image: usize,
        /// Reason why the pose is not determined.
        reason: PlanePoseError,
    },
    /// The fitted parameters are not a valid lens.
    #[error("no lens with Brown-Conrady distortion fits the dots: {0}")]
    Impossible(#[from] ImpossibleLens),
    /// The search found no minimum.
    #[error("no lens with Brown-Conrady distortion fits the dots: check that each image shows one plane grid")]
    NotFound,
}

/// Unknowns of the fit: the lens's parameters, and the pose of the grid in each image.
#[derive(Debug, Clone)]
struct LensAndPoses {
    lens: [f64; PARAMETERS],
    poses: Vec<Pose>,
}

/// Fits the lens, and the pose of a plane grid in each image. `views` contains one list per image, with the position on the grid (mm) and the pixel
/// of each dot. The fit is a least-squares fit of the pixels, with a prior on every parameter of the lens, so that few images do not overfit.
///
/// # Errors
/// [`LensFitError`] for no images, fewer than 12 dots in an image, no pose of the grid, or no lens that fits.
///
/// # Reference
/// Z. Zhang, A flexible new technique for camera calibration, IEEE Trans. PAMI 22 (2000). Zhang's eqs (3) and (4) give the focal length of one
/// starting point, with equal focal lengths and the principal point in the middle of the image.
pub fn fit_lens(size_px: [u32; 2], views: &[Vec<(Vector, Pixel)>]) -> Result<LensFit, LensFitError> {
    if views.is_empty() {
        return Err(LensFitError::NoView);
    }
    for (i, view) in views.iter().enumerate() {
        if view.len() < LEAST_POINTS {
            return Err(LensFitError::TooFew { image: i + 1, found: view.len() });
        }
    }
    let [width, height] = size_px.map(f64::from);
    let middle = [(width - 1.0) / 2.0, (height - 1.0) / 2.0];
    let usual = UsualLens { middle, width, focal: USUAL_FOCUS * width, focal_sd: FOCAL_SD };
    let mut problem = LensProblem { size_px, views, usual, noise_px: FIRST_NOISE_PX };
    // The sum of squares also has minima at focal lengths that are far too long, where distortion imitates the tilt of the plane.
    let starts = STARTS.map(|share| share * width).into_iter().chain(first_focal_px(views, middle));
    let found = starts.map(|focal| problem.nearest_minimum(focal));
    let (mut best, mut failure) = (None::<Fit<LensAndPoses>>, None);
    for found in found {
        match found {
            Ok(fit) if best.as_ref().is_none_or(|best| fit.squares < best.squares) => best = Some(fit),
            Ok(_) => {}
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    let mut fitted = best.ok_or_else(|| failure.unwrap_or(LensFitError::NotFound))?;
    let pixels = 2 * views.iter().map(Vec::len).sum::<usize>();
    // The priors are not counted as additional data, so the noise is overestimated rather than underestimated.
    let freedom = pixels.saturating_sub(fitted.jacobian.ncols()).max(1) as f64;
    for _ in 0..ROUNDS {
        let squares_px2 = fitted.residual.rows(0, pixels).norm_squared() * problem.noise_px * problem.noise_px;
        problem.noise_px = (squares_px2 / freedom).sqrt().max(LEAST_NOISE_PX);
        fitted = problem.fit(fitted.point)?;
    }
    let unknowns = &fitted.point;
    let covariance = fitted.covariance().ok_or(LensFitError::NotFound)?;
    let of_noise: [f64; PARAMETERS] = std::array::from_fn(|i| covariance[(i, i)].sqrt());
    let dots: Vec<usize> = views.iter().map(Vec::len).collect();
    let of_images = leave_one_out::sds(&fitted.jacobian, &fitted.residual, &dots);
    let sds = of_images.map_or(of_noise, |of_images| std::array::from_fn(|i| of_noise[i].max(of_images[i])));
    let prior_sds = problem.usual.sds(&unknowns.lens);
    Ok(LensFit {
        lens: lens_of(size_px, &unknowns.lens)?,
        is_shown: std::array::from_fn(|i| 2.0 * of_noise[i] * of_noise[i] < prior_sds[i] * prior_sds[i]),
        sds,
        poses: unknowns.poses.clone(),
        residual_sd_px: problem.noise_px,
    })
}

fn lens_of(size_px: [u32; 2], p: &[f64; PARAMETERS]) -> Result<Lens, ImpossibleLens> {
    let distortion = Distortion::from_opencv([p[4], p[5], p[6], p[7], p[8]]);
    let lens = Lens::new(size_px, [p[0], p[1]], [p[2], p[3]], distortion)?;
    // The images of a grid fill the frame, so a lens that folds it describes something else than a grid.
    if lens.folds_image() {
        let expected = "coefficients that do not fold the image".to_owned();
        return Err(ImpossibleLens { key: CAMERA.distortion.name, expected });
    }
    Ok(lens)
}

/// The focal length common to all images, px, if the principal point is in the middle. With the focal length f and the homography (h1 h2 h3) of each
/// image, (h11 h12 + h21 h22) / f^2 = -h31 h32 and (h11^2 + h21^2 - h12^2 - h22^2) / f^2 = h32^2 - h31^2. `None` if the planes are not tilted.
fn first_focal_px(views: &[Vec<(Vector, Pixel)>], middle: [f64; 2]) -> Option<f64> {
    let (mut top, mut bottom) = (0.0, 0.0);
    for view in views {
        let positions: Vec<Vector2<f64>> = view.iter().map(|(position, _)| *position).collect();
        let seen: Vec<Vector2<f64>> = view.iter().map(|(_, pixel)| pixel - Vector2::from(middle)).collect();
        let h = homography(&positions, &seen)?;
        let h = h / h.norm();
        let rows = [
            (h[(0, 0)] * h[(0, 1)] + h[(1, 0)] * h[(1, 1)], -h[(2, 0)] * h[(2, 1)]),
            (
                h[(0, 0)].powi(2) + h[(1, 0)].powi(2) - h[(0, 1)].powi(2) - h[(1, 1)].powi(2),
                h[(2, 1)].powi(2) - h[(2, 0)].powi(2),
            ),
        ];
        for (by, value) in rows {
            top += by * by;
            bottom += by * value;
        }
    }
    let focal = (top / bottom).sqrt();
    focal.is_finite().then_some(focal)
}

/// Least-squares problem of the dots in several images; residuals are divided by the noise. The unknowns are the lens's parameters, followed by six
/// coordinates of a motion of the grid in each image.
struct LensProblem<'v> {
    size_px: [u32; 2],
    views: &'v [Vec<(Vector, Pixel)>],
    usual: UsualLens,
    noise_px: f64,
}

impl LensProblem<'_> {
    fn fit(&mut self, start: LensAndPoses) -> Result<Fit<LensAndPoses>, LensFitError> {
        LevenbergMarquardt::default().minimise(self, start).map_err(Refusal::into_error)
    }

    /// Finds a minimum from a starting point with the given focal length (px), the principal point in the middle and no distortion.
    fn nearest_minimum(&mut self, focal: f64) -> Result<Fit<LensAndPoses>, LensFitError> {
        let UsualLens { middle: [cx, cy], .. } = self.usual;
        let start = Lens::new(self.size_px, [focal; 2], [cx, cy], Distortion::default())?;
        let poses = self.views.iter().enumerate().map(|(i, view)| {
            let found = plane_pose(&start, 0.0, view).map_err(|reason| LensFitError::Pose { image: i + 1, reason })?;
            Ok(found.pose)
        });
        let lens = [focal, focal, cx, cy, 0.0, 0.0, 0.0, 0.0, 0.0];
        let start = LensAndPoses { lens, poses: poses.collect::<Result<_, LensFitError>>()? };
        // The distortion is fitted first, with the focal length held. If the focal length were fitted at the same time, rows of dots that the
        // distortion bends would bias it.
        let usual = self.usual;
        self.usual = UsualLens { focal, focal_sd: HELD_FOCAL_SD, ..usual };
        let held = self.fit(start);
        self.usual = usual;
        self.fit(held?.point)
    }

    /// Image index, position on the grid (mm) and pixel of each dot.
    fn dots(&self) -> impl Iterator<Item = (usize, &Vector, &Pixel)> {
        (0..self.views.len()).flat_map(|i| self.views[i].iter().map(move |(position, pixel)| (i, position, pixel)))
    }
}

impl LeastSquaresProblem for LensProblem<'_> {
    type Point = LensAndPoses;
    type Error = LensFitError;

    fn residual(&mut self, at: &LensAndPoses) -> Result<DVector<f64>, Refusal<LensFitError>> {
        let lens = lens_of(self.size_px, &at.lens).map_err(|error| Refusal::Here(error.into()))?;
        let mut residual = DVector::zeros(2 * self.dots().count());
        for (row, (view, position, pixel)) in self.dots().enumerate() {
            let found = lens.project(&at.poses[view].to_camera(&position.push(0.0)));
            let found = found.map_err(|_| Refusal::Here(LensFitError::NotFound))?;
            residual.fixed_rows_mut::<2>(2 * row).copy_from(&((found - pixel) / self.noise_px));
        }
        Ok(residual)
    }

    fn jacobian(&mut self, at: &LensAndPoses, _: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<LensFitError>> {
        let lens = lens_of(self.size_px, &at.lens).map_err(|error| Refusal::Here(error.into()))?;
        let mut jacobian = DMatrix::zeros(2 * self.dots().count(), PARAMETERS + 6 * self.views.len());
        for (row, (view, position, _)) in self.dots().enumerate() {
            let pose = &at.poses[view];
            let by_pose = by_motion(&lens, pose, &position.push(0.0));
            let by_pose = by_pose.map_err(|_| Refusal::Here(LensFitError::NotFound))?;
            jacobian.fixed_view_mut::<2, 6>(2 * row, PARAMETERS + 6 * view).copy_from(&(by_pose / self.noise_px));
            let seen = pose.to_camera(&position.push(0.0));
            for (column, derivative) in by_parameters(&at.lens, &(seen.xy() / seen.z)).iter().enumerate() {
                jacobian.fixed_view_mut::<2, 1>(2 * row, column).copy_from(&(derivative / self.noise_px));
            }
        }
        Ok(jacobian)
    }

    fn moved(&self, at: &LensAndPoses, step: &DVector<f64>) -> LensAndPoses {
        let mut moved = at.clone();
        for (parameter, change) in moved.lens.iter_mut().zip(step.iter()) {
            *parameter += change;
        }
        for (number, pose) in moved.poses.iter_mut().enumerate() {
            *pose = pose.moved(&step.fixed_rows::<6>(PARAMETERS + 6 * number).into_owned());
        }
        moved
    }

    fn priors(&self, at: &LensAndPoses) -> Vec<Prior> {
        self.usual.priors(&at.lens)
    }
}

/// Derivatives of a pixel's coordinates by the lens's parameters, at undistorted coordinates; the formula stands at [`Distortion`].
fn by_parameters(p: &[f64; PARAMETERS], at: &Vector2<f64>) -> [Vector2<f64>; PARAMETERS] {
    let (x, y, q) = (at.x, at.y, at.norm_squared());
    let f = 1.0 + q * (p[4] + q * (p[5] + q * p[8]));
    let bent = Vector2::new(
        x * f + 2.0 * p[6] * x * y + p[7] * (q + 2.0 * x * x),
        y * f + p[6] * (q + 2.0 * y * y) + 2.0 * p[7] * x * y,
    );
    let scaled = |v: Vector2<f64>| Vector2::new(p[0] * v.x, p[1] * v.y);
    [
        Vector2::new(bent.x, 0.0),
        Vector2::new(0.0, bent.y),
        Vector2::x(),
        Vector2::y(),
        scaled(at * q),
        scaled(at * (q * q)),
        scaled(Vector2::new(2.0 * x * y, q + 2.0 * y * y)),
        scaled(Vector2::new(q + 2.0 * x * x, 2.0 * x * y)),
        scaled(at * (q * q * q)),
    ]
}
