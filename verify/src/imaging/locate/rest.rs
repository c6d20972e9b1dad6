//! The finger at rest: its pose before the camera, and where each marker is without load.

use super::{LocateError, Located, Locator, LocatorError};
use finray_model::Finger;
use finray_model::camera::{Camera, Lens, PlanePoseError, Pose, plane_pose};
use finray_model::scene::Markers;
use image::RgbImage;

/// Largest residual of the pose's fit, px: a finger that is bent, or not this one, leaves more.
const LARGEST_RESIDUAL_PX: f64 = 2.0;
/// Rounds of locating and fitting the pose: the markers are measured as circles of the plane, whose pose is found from them.
const ROUNDS: usize = 3;

/// What an image of the unloaded finger shows.
#[derive(Debug, Clone)]
pub struct Rest {
    /// The camera with the pose that the image shows.
    pub camera: Camera,
    /// Markers in it, seen with this pose.
    pub located: Vec<Located>,
    /// Residual standard deviation of the pose's fit, px.
    pub residual_sd_px: f64,
}

/// Why an image shows no finger at rest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RestError {
    /// The markers are not found.
    #[error(transparent)]
    Locate(#[from] LocateError),
    /// No locator for this camera.
    #[error(transparent)]
    Locator(#[from] LocatorError),
    /// They have no pose.
    #[error(transparent)]
    Pose(#[from] PlanePoseError),
    /// No pose to start from.
    #[error("the scene has no pose to start from")]
    NoPose,
    /// They are not where an unloaded finger has them.
    #[error(
        "the markers are {residual_px:.1} px rms from those of the scene's unloaded finger, at most {LARGEST_RESIDUAL_PX} px are expected: is \
         the finger loaded, or the lens or the finger another one?"
    )]
    NotAtRest {
        /// Root mean square of the residuals, px.
        residual_px: f64,
    },
}

impl Rest {
    /// Finds the pose, from about where the scene has it or without a guess.
    ///
    /// # Errors
    /// [`RestError`] if the image does not show the unloaded finger.
    pub fn of(
        finger: &Finger,
        lens: &Lens,
        pose: Option<Pose>,
        markers: &Markers,
        image: &RgbImage,
    ) -> Result<Rest, RestError> {
        let Some(pose) = pose else { return Err(RestError::NoPose) };
        let mut camera = Camera { lens: *lens, pose };
        let mut located = Locator::new(finger, &camera, markers)?.locate(image)?;
        let mut residual_sd_px = f64::INFINITY;
        for _ in 0..ROUNDS {
            let points: Vec<_> = located.iter().map(|marker| (finger.position(marker.node), marker.pixel)).collect();
            let fit = plane_pose(lens, markers.height_mm, &points)?;
            residual_sd_px = fit.residual_sd_px;
            if residual_sd_px > LARGEST_RESIDUAL_PX {
                return Err(RestError::NotAtRest { residual_px: residual_sd_px });
            }
            camera.pose = fit.pose;
            located = Locator::new(finger, &camera, markers)?.locate(image)?;
        }
        Ok(Rest { camera, located, residual_sd_px })
    }
}
