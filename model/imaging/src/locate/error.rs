//! Errors of locating a finger in images.

use super::blobs::LEAST_RADIUS_PX;
use super::disc::LARGEST_BLUR;
use super::motion::LARGEST_MOTION;
use super::{FingerPlacement, GreyMarker, NamingError};
use finray_model::Finger;
use finray_model::camera::ViewError;

/// Reason why no finger was located in an image.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LocateError {
    /// The image differs in size from the camera's.
    #[error("expected an image of {} x {} px as the scene's camera takes, found {} x {} px{}",
        expected[0], expected[1], found[0], found[1], turned(*expected, *found))]
    Size {
        /// Width and height of the scene's camera, px.
        expected: [u32; 2],
        /// Width and height of the image, px.
        found: [u32; 2],
    },
    /// The markers are too small in the image.
    #[error(
        "the scene's markers have a radius of {radius_px:.1} px in the image, expected at least {LEAST_RADIUS_PX} px: use larger markers or a closer \
         camera"
    )]
    TooSmall {
        /// Radius of the markers in the image, px.
        radius_px: f64,
    },
    /// The middle of the finger has no pixel.
    #[error("the camera does not see the finger: its middle {0}")]
    View(#[from] ViewError),
    /// The finger lies outside the image.
    #[error(
        "the camera does not see the finger: its middle is outside the image; check the pose in the table camera of the scene"
    )]
    Outside,
    /// The blur covers the whole marker, so that no pixel shows its undisturbed light.
    #[error(
        "markers are out of focus: their edge is blurred by {blur_px:.1} px (standard deviation), expected at most {LARGEST_BLUR} of their radius of \
         {radius_px:.1} px"
    )]
    Blurred {
        /// Standard deviation of the blur, px.
        blur_px: f64,
        /// Radius of the markers, px.
        radius_px: f64,
    },
    /// The finger or the camera moved while the shutter was open.
    #[error(
        "markers are blurred by a motion: by {blur_px:.1} px (standard deviation), expected at most {LARGEST_MOTION} of their radius of \
         {radius_px:.1} px; use a shorter exposure"
    )]
    Moved {
        /// Standard deviation of the blur along the motion, px.
        blur_px: f64,
        /// Radius of the markers, px.
        radius_px: f64,
    },
    /// The image is flipped; holds the kind of flip, in words.
    #[error("the image shows the finger {0}: correct the image (EXIF orientation), or the camera's pose in the scene")]
    Flipped(&'static str),
    /// The finger is not at the pose of the scene's camera; holds its placement.
    #[error(
        "the finger is not where the scene's camera has it: {0}; check whether the image is turned, mirrored or resized, or find the pose with \
         --rest, an image of the unloaded finger"
    )]
    Elsewhere(FingerPlacement),
    /// The references on the base contradict the base of the finger that the markers show.
    #[error(
        "the marks that look like the references on the base are {away_mm:.0} mm from the base that the ribs show: check base.reference.radius_mm, \
         inner_radius_mm and at_mm"
    )]
    OtherReferences {
        /// Distance between the two positions of the base, mm.
        away_mm: f64,
    },
    /// The image shows markers, but no marks at the distances of the references on the base.
    #[error(
        "the references on the base were not found: {} marks look like them (in their order), but no pair has their distance, and {like_markers} \
         look like markers; check base.reference.radius_mm, inner_radius_mm, shade and at_mm, lens and pose",
        counts(like_references)
    )]
    NoReferences {
        /// Number of marks that look like each reference.
        like_references: Vec<usize>,
        /// Number of rims that look like markers.
        like_markers: usize,
    },
    /// Patches of the markers' colours have a radius that differs from that of the camera's markers.
    #[error(
        "expected markers with a radius of {expected_px:.1} px, found patches of their colours with {found_px:.1} px: check markers.radius_mm, the \
         camera's pose, and whether the image is resized"
    )]
    OtherSize {
        /// Radius from the scene, px.
        expected_px: f64,
        /// Commonest radius of the patches, px.
        found_px: f64,
    },
    /// The markers could not be assigned to nodes.
    #[error("no finger is recognised: {0}")]
    Naming(#[from] NamingError),
}

/// Reason why no locator can be created.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LocatorError {
    /// A locator of coloured markers was given grey ones.
    #[error("markers: expected front_rgb and back_rgb, found shade")]
    NotColoured,
    /// A locator of grey markers was given coloured ones.
    #[error("markers: expected shade, found front_rgb and back_rgb")]
    NotGrey,
    /// Ribs share a junction; naming needs ribs with separate ends.
    #[error(
        "finger.ribs.positions_mm: expected ribs that share no junction and do not end in a corner of the base, because markers are named by their \
         ribs"
    )]
    SharedJunctions,
    /// A marker's colour is too close to grey.
    #[error(transparent)]
    Colour(#[from] GreyMarker),
    /// The camera does not see the finger, or its markers are too small.
    #[error(transparent)]
    Camera(#[from] LocateError),
}

/// Checks that ribs identify the markers.
///
/// # Errors
/// [`LocatorError::SharedJunctions`] if ribs share a junction or end in a corner of the base.
pub(super) fn require_own_junctions(finger: &Finger) -> Result<(), LocatorError> {
    if finger.has_shared_junctions() { Err(LocatorError::SharedJunctions) } else { Ok(()) }
}

fn counts(counts: &[usize]) -> String {
    counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" and ")
}

/// A hint for an image with exchanged width and height.
fn turned([width, height]: [u32; 2], found: [u32; 2]) -> &'static str {
    if width != height && found == [height, width] { ": is it turned by 90 degrees (EXIF orientation)?" } else { "" }
}
