//! Estimation of a lens from images of plane grids.

use super::{Grid, GridDot};
use crate::lens_fit::{LensFit, LensFitError, fit_lens};
use finray_model::Vector;
use finray_model::camera::{Camera, Lens, Pixel, Pose};

/// Residuals larger than this multiple of the median residual are outliers.
const OUTLIER: f64 = 6.0;
/// A grid is rejected as not plane if its root mean square residual exceeds this share of the distance between neighbours.
const LARGEST_RESIDUAL: f64 = 0.1;
/// Number of rounds that correct the centres of the dots' images for perspective; each round fits the lens again.
const ROUNDS: usize = 3;
/// Number of points on the projected outline of a dot.
const OUTLINE: usize = 48;

/// Reason why grids do not determine a lens.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LensOfGridsError {
    /// No lens fits the dots.
    #[error(transparent)]
    Fit(#[from] LensFitError),
    /// No lens explains the dots of one image as a plane grid.
    #[error(
        "image {image}: expected a plane grid, found dots that deviate from a plane grid by {residual_px:.1} px (root mean square); neighbouring \
         dots are {pitch_px:.0} px apart"
    )]
    Uneven {
        /// Number of the image, counted from 1.
        image: usize,
        /// Root mean square distance of the dots from their projected positions, px.
        residual_px: f64,
        /// Distance between neighbouring dots, px.
        pitch_px: f64,
    },
    /// Some images show a chessboard, others a grid of dots.
    #[error("expected images of one board, found images of a chessboard and images of a board of dots")]
    Kinds,
}

/// Fits a lens to grids in images of one size; `pitch_mm` is the pitch of [`GridKind`](super::GridKind). The centre of a slanted disc's image differs from
/// the image of the disc's centre; the fit corrects this difference. Returns the fit and the number of dots that were dropped as outliers.
///
/// # Errors
/// [`LensOfGridsError`] if the grids are of different kinds, if dots do not lie on a plane grid, or if no lens fits.
pub fn lens_of_grids(size_px: [u32; 2], pitch_mm: f64, grids: &[Grid]) -> Result<(LensFit, usize), LensOfGridsError> {
    fitted(pitch_mm, grids, |views| fit_lens(size_px, views))
}

/// Poses of grids relative to a camera whose lens is known, one per image, and the number of dots that were dropped as outliers. Corrects the centres
/// of discs as [`lens_of_grids`] does.
///
/// # Errors
/// [`LensOfGridsError`] if the grids are of different kinds, or if dots do not lie on a plane grid for this lens.
pub fn poses_of_grids(lens: &Lens, pitch_mm: f64, grids: &[Grid]) -> Result<(Vec<Pose>, usize), LensOfGridsError> {
    let (fit, left_out) = fitted(pitch_mm, grids, |views| LensFit::of_known(lens, views))?;
    Ok((fit.poses, left_out))
}

/// Alternates between a fit of the views and the correction of the centres of discs.
fn fitted(
    pitch_mm: f64,
    grids: &[Grid],
    fit: impl Fn(&[Vec<(Vector, Pixel)>]) -> Result<LensFit, LensFitError>,
) -> Result<(LensFit, usize), LensOfGridsError> {
    let kind = Grid::common_kind(grids).ok_or(LensOfGridsError::Kinds)?;
    let position = |dot: &GridDot| kind.position(dot.index) * pitch_mm;
    let mut grids: Vec<Vec<GridDot>> = grids.iter().map(|grid| grid.dots.clone()).collect();
    let mut shifts: Vec<Vec<Pixel>> = grids.iter().map(|grid| vec![Pixel::zeros(); grid.len()]).collect();
    let mut left_out = 0;
    let mut found: Option<LensFit> = None;
    for round in 0..ROUNDS {
        let views: Vec<Vec<(Vector, Pixel)>> = grids
            .iter()
            .zip(&shifts)
            .map(|(grid, shifts)| {
                grid.iter().zip(shifts).map(|(dot, shift)| (position(dot), dot.pixel - shift)).collect()
            })
            .collect();
        let fit = fit(&views)?;
        if round == 0 {
            for ((grid, pose), shifts) in grids.iter_mut().zip(&fit.poses).zip(&mut shifts) {
                left_out += drop_outliers(grid, &fit.lens, pose, position);
                *shifts = vec![Pixel::zeros(); grid.len()];
            }
        }
        for ((grid, pose), shifts) in grids.iter().zip(&fit.poses).zip(&mut shifts) {
            for (dot, shift) in grid.iter().zip(shifts.iter_mut()) {
                *shift = shift_of_middle(&fit.lens, pose, &position(dot), dot.radius_px).unwrap_or_default();
            }
        }
        found = Some(fit);
    }
    let fit = found.ok_or(LensFitError::NotFound)?;
    for (image, (grid, pose)) in grids.iter().zip(&fit.poses).enumerate() {
        let camera = Camera { lens: fit.lens, pose: *pose };
        let squares: f64 = grid.iter().map(|dot| residual_px(&camera, dot, position(dot)).powi(2)).sum();
        let residual_px = (squares / grid.len() as f64).sqrt();
        let pitch_px = pitch_px(grid);
        if residual_px > LARGEST_RESIDUAL * pitch_px {
            return Err(LensOfGridsError::Uneven { image: image + 1, residual_px, pitch_px });
        }
    }
    Ok((fit, left_out))
}

/// Distance of a dot from the projection of its position in the plane, px; infinite if the position has no projection.
fn residual_px(camera: &Camera, dot: &GridDot, position: Vector) -> f64 {
    camera.project(&position.push(0.0)).map_or(f64::INFINITY, |pixel| (pixel - dot.pixel).norm())
}

/// Mean distance between neighbours along the rows, px; infinite if no dot has a neighbour.
fn pitch_px(grid: &[GridDot]) -> f64 {
    let at: std::collections::HashMap<[i32; 2], Pixel> = grid.iter().map(|dot| (dot.index, dot.pixel)).collect();
    let next = |dot: &GridDot| Some((at.get(&[dot.index[0] + 1, dot.index[1]])? - dot.pixel).norm());
    let distances: Vec<f64> = grid.iter().filter_map(next).collect();
    if distances.is_empty() { f64::INFINITY } else { distances.iter().sum::<f64>() / distances.len() as f64 }
}

fn drop_outliers(grid: &mut Vec<GridDot>, lens: &Lens, pose: &Pose, position: impl Fn(&GridDot) -> Vector) -> usize {
    let camera = Camera { lens: *lens, pose: *pose };
    let residual = |dot: &GridDot| residual_px(&camera, dot, position(dot));
    let mut residuals: Vec<f64> = grid.iter().map(residual).collect();
    let middle = residuals.len() / 2;
    let median = *residuals.select_nth_unstable_by(middle, f64::total_cmp).1;
    let before = grid.len();
    grid.retain(|dot| residual(dot) <= OUTLIER * median.max(1e-3));
    before - grid.len()
}

/// Offset from the image of a disc's centre to the centre of the disc's image, px. `None` for a corner, which has no extent.
fn shift_of_middle(lens: &Lens, pose: &Pose, centre: &Vector, radius_px: f64) -> Option<Pixel> {
    if radius_px == 0.0 {
        return None;
    }
    let camera = Camera { lens: *lens, pose: *pose };
    let (at, by_point) = camera.project_with_derivatives(&centre.push(0.0)).ok()?;
    let in_plane = by_point.fixed_columns::<2>(0).into_owned();
    let radius_mm = radius_px / in_plane.determinant().abs().sqrt();
    let corner = |k: usize| {
        let (sine, cosine) = (std::f64::consts::TAU * k as f64 / OUTLINE as f64).sin_cos();
        camera.project(&(centre + Vector::new(cosine, sine) * radius_mm).push(0.0)).ok().map(|pixel| pixel - at)
    };
    let corners = (0..OUTLINE).map(corner).collect::<Option<Vec<Pixel>>>()?;
    let (mut area, mut moment) = (0.0, Pixel::zeros());
    for (k, from) in corners.iter().enumerate() {
        let to = corners[(k + 1) % OUTLINE];
        let cross = from.perp(&to);
        area += cross / 2.0;
        moment += (from + to) * (cross / 6.0);
    }
    Some(moment / area)
}
