//! The unloaded finger in an image: its pose relative to the camera, and the position of each marker without load.

use super::blobs::{blobs, commonest_radius};
use super::colour::Colours;
use super::error::require_own_junctions;
use super::pattern::at_rest;
use super::{LocateError, Located, Locator, LocatorError, require_size};
use crate::RgbRows;
use crate::plane_pose::{PlanePoseError, plane_pose};
use finray_model::camera::{Camera, Lens, Pose};
use finray_model::observation::EstimatedNoise;
use finray_model::scene::{MarkerLook, Markers, marker_offset};
use finray_model::{Finger, Vector};
use image::RgbImage;
use nalgebra::{Matrix6, Vector6};

/// An image is rejected if the residual standard deviation of the fitted pose exceeds this, px, and this share of the markers' radius. A larger
/// residual means that the finger is bent, or is not the scene's finger; dots placed by hand are within a quarter of their radius from their nodes.
const LARGEST_RESIDUAL_PX: f64 = 2.0;
const LARGEST_RESIDUAL: f64 = 0.25;
/// Number of rounds, each of which fits the pose and then locates the markers again. Several rounds are needed, because markers are measured as circles in the
/// finger's plane, and this plane depends on the pose.
const ROUNDS: usize = 3;

/// Results from an image of the unloaded finger.
#[derive(Debug, Clone)]
pub struct Rest {
    /// The camera with the fitted pose of the finger.
    pub camera: Camera,
    /// The markers as located with the fitted pose.
    pub located: Vec<Located>,
    /// Noise of the image, as in [`Locator::noise`].
    pub noise: Option<EstimatedNoise>,
    /// Residual standard deviation of one pixel coordinate in the fit of the pose, px.
    pub residual_sd_px: f64,
    /// Covariance of the pose, from that residual: of a small rotation about each axis of the camera, rad, and of the translation, mm.
    pub pose_covariance: Matrix6<f64>,
    /// Median radius of the markers, mm.
    pub radius_mm: f64,
    /// Standard deviation of the blur of the markers' edges, px.
    pub blur_px: f64,
}

/// Reason why the unloaded finger was not found in an image.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RestError {
    /// The markers could not be located.
    #[error(transparent)]
    Locate(#[from] LocateError),
    /// A locator for these markers and this camera cannot be created.
    #[error(transparent)]
    Locator(#[from] LocatorError),
    /// The markers do not determine a pose.
    #[error(transparent)]
    Pose(#[from] PlanePoseError),
    /// The image shows no two rows of markers that meet at a tip, and the scene states no pose from which the fit could start.
    #[error(
        "no unloaded finger is recognised: expected two rows of markers as in the scene, with at least 60 % of the markers visible"
    )]
    NoPattern,
    /// The markers do not fit the unloaded finger of the scene.
    #[error(
        "the markers are {residual_px:.1} px rms from their positions on the scene's unloaded finger, expected at most {largest_px:.1} px: \
         unload the finger, or correct lens or finger in the scene"
    )]
    NotAtRest {
        /// Residual standard deviation of one pixel coordinate, px.
        residual_px: f64,
        /// Largest accepted residual, px.
        largest_px: f64,
    },
}

impl Rest {
    /// Fits the pose of the unloaded finger, whose markers have `offsets` as in [`Scene::marker_offsets`](finray_model::Scene::marker_offsets). The fit
    /// starts from the pattern of markers or, if none is found, from the stated pose.
    ///
    /// # Errors
    /// [`RestError`] if the image does not show the unloaded finger.
    pub fn of(
        (finger, offsets): (&Finger, &[Vector]),
        lens: &Lens,
        pose: Option<Pose>,
        markers: &Markers,
        image: &RgbImage,
    ) -> Result<Rest, RestError> {
        require_own_junctions(finger)?;
        require_size(lens, image)?;
        // The pose from the pattern of markers takes precedence, because the stated pose may be inaccurate.
        let pose = pose_of_pattern(finger, lens, markers, image)?.or(pose).ok_or(RestError::NoPattern)?;
        let mut camera = Camera { lens: *lens, pose };
        let mut located = Locator::new(finger, &camera, markers)?.locate_about(image, false)?;
        let (mut residual_sd_px, mut pose_covariance) = (f64::INFINITY, Matrix6::zeros());
        let (mut outline, mut noise) = (None, None);
        for _ in 0..ROUNDS {
            let at = |node| finger.marker_position(node) + marker_offset(offsets, node);
            let points: Vec<_> = located.iter().map(|marker| (at(marker.node), marker.pixel)).collect();
            let fit = plane_pose(lens, markers.height_mm, &points)?;
            residual_sd_px = fit.residual_sd_px;
            let mm_a_px = Camera { pose: fit.pose, ..camera }.position_sd_mm(&points[0].1, markers.height_mm, 1.0);
            let of_radius_px = mm_a_px.map_or(0.0, |mm| LARGEST_RESIDUAL * markers.radius_mm / mm);
            let largest_px = LARGEST_RESIDUAL_PX.max(of_radius_px);
            if residual_sd_px > largest_px {
                return Err(RestError::NotAtRest { residual_px: residual_sd_px, largest_px });
            }
            pose_covariance = residual_sd_px.powi(2) * fit.unit_covariance;
            camera.pose = fit.pose;
            let mut locator = Locator::new(finger, &camera, markers)?;
            located = locator.locate(image)?;
            (outline, noise) = (locator.common.map(|common| common.outline), locator.noise());
        }
        let [radius_mm, blur_px] = outline.map_or([f64::NAN; 2], |outline| [outline.radius_mm, outline.blurs_px[0]]);
        Ok(Rest { camera, located, noise, residual_sd_px, pose_covariance, radius_mm, blur_px })
    }

    /// Standard deviations of the pose, in the order and units of [`Rest::pose_covariance`].
    pub fn pose_sds(&self) -> [f64; 6] {
        std::array::from_fn(|i| self.pose_covariance[(i, i)].sqrt())
    }

    /// Independent errors of the pose, one standard deviation each. Empty for an exact pose.
    pub fn pose_errors(&self) -> Vec<[f64; 6]> {
        // In units of the standard deviations, because rad and mm differ by orders of magnitude.
        let sds = Vector6::from(self.pose_sds());
        let correlation = self.pose_covariance.component_div(&(sds * sds.transpose()));
        let factor = correlation.cholesky().map(|factor| factor.l());
        let error = |column: Vector6<f64>| <[f64; 6]>::from(column.component_mul(&sds));
        factor.iter().flat_map(|factor| (0..6).map(|i| error(factor.column(i).into_owned()))).collect()
    }
}

/// Pose from the pattern of the unloaded finger's markers; `None` if the image does not show this pattern.
fn pose_of_pattern(
    finger: &Finger,
    lens: &Lens,
    markers: &Markers,
    image: &dyn RgbRows,
) -> Result<Option<Pose>, RestError> {
    let MarkerLook::Coloured { front_rgb, back_rgb } = markers.look else {
        return Err(LocatorError::NotColoured.into());
    };
    let colours = Colours::new([front_rgb, back_rgb]).map_err(LocatorError::from)?;
    let Some((radius_px, _)) = commonest_radius(image, &colours) else { return Ok(None) };
    let blobs = blobs(image, &colours, radius_px);
    let Some(named) = at_rest(finger, lens, &blobs, (radius_px, colours.are_alike())) else { return Ok(None) };
    let points: Vec<_> = named.iter().map(|(node, pixel)| (finger.marker_position(*node), *pixel)).collect();
    Ok(plane_pose(lens, markers.height_mm, &points).ok().map(|fit| fit.pose))
}
