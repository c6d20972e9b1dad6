//! The finger at rest: its pose before the camera, and where each marker is without load.

use super::blobs::{blobs, commonest_radius};
use super::colour::Colours;
use super::error::require_own_junctions;
use super::pattern::at_rest;
use super::{LocateError, Located, Locator, LocatorError, require_size};
use finray_model::Finger;
use finray_model::camera::{Camera, Lens, PlanePoseError, Pose, plane_pose};
use finray_model::scene::{MarkerLook, Markers};
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
    /// No two rows of markers that meet at a tip, and no pose to start from.
    #[error(
        "no unloaded finger is seen: expected two rows of markers as the scene has them, with at least six of ten in sight"
    )]
    NoPattern,
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
    /// Finds the pose without a guess, or else from about where the scene has it.
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
        require_own_junctions(finger)?;
        require_size(lens, image)?;
        // Where markers are named by their pattern, a pose that the scene states adds nothing, and may be off.
        let pose = pose_of_pattern(finger, lens, markers, image)?.or(pose).ok_or(RestError::NoPattern)?;
        let mut camera = Camera { lens: *lens, pose };
        let mut located = Locator::new(finger, &camera, markers)?.locate_about(image, false)?;
        let mut residual_sd_px = f64::INFINITY;
        for _ in 0..ROUNDS {
            let points: Vec<_> =
                located.iter().map(|marker| (finger.marker_position(marker.node), marker.pixel)).collect();
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

/// The pose from the pattern of the unloaded finger's markers; `None` if it is not seen.
fn pose_of_pattern(
    finger: &Finger,
    lens: &Lens,
    markers: &Markers,
    image: &RgbImage,
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
