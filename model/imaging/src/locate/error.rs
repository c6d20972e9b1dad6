//! Errors of locating a finger in an image.

use super::blobs::LEAST_RADIUS_PX;
use super::disc::LARGEST_BLUR;
use super::motion::LARGEST_MOTION;
use super::{FingerPlacement, GreyMarker, NamingError};
use finray_model::camera::ViewError;
use finray_model::{Finger, NodeId};

/// Reason why no finger was located in an image.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LocateError {
    /// The size of the image differs from the size of the camera's images.
    #[error("expected an image of {} x {} px, the size of the scene's camera, found {} x {} px{}",
        expected[0], expected[1], found[0], found[1], turned(*expected, *found))]
    Size {
        /// Width and height of the images of the scene's camera, px.
        expected: [u32; 2],
        /// Width and height of the image, px.
        found: [u32; 2],
    },
    /// The markers are too small in the image to be measured.
    #[error(
        "the scene's markers have a radius of {radius_px:.1} px in the image, expected at least {LEAST_RADIUS_PX} px: use larger markers or a closer \
         camera"
    )]
    TooSmall {
        /// Radius of the markers in the image, px.
        radius_px: f64,
    },
    /// No pixel of the camera corresponds to the middle of the finger.
    #[error("the camera does not see the finger: the middle of the finger {0}")]
    View(#[from] ViewError),
    /// The distortion of the lens folds the image at a marker of the unloaded finger.
    #[error(
        "camera.distortion: the marker of node {node} lies beyond the radius at which these coefficients fold the image, so that its pixel is \
         ambiguous: calibrate the lens up to the border of the image"
    )]
    Folded {
        /// Key node of the marker.
        node: NodeId,
    },
    /// The finger lies outside the image.
    #[error(
        "the camera does not see the finger: the middle of the finger is outside the image; check the pose in \
            [camera] of the scene"
    )]
    Outside,
    /// The image is out of focus: the blur covers whole markers, so that no pixel shows their undisturbed light.
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
        "markers are blurred by motion: {blur_px:.1} px (standard deviation), expected at most {LARGEST_MOTION} of their radius of \
         {radius_px:.1} px; use a shorter exposure"
    )]
    Moved {
        /// Standard deviation of the motion blur in addition to the isotropic blur, px.
        blur_px: f64,
        /// Radius of the markers, px.
        radius_px: f64,
    },
    /// The image is flipped. The field describes in words how the image is flipped.
    #[error("the image shows the finger {0}: correct the image (EXIF orientation), or the camera's pose in the scene")]
    Flipped(&'static str),
    /// The finger is not where the scene's camera pose puts it. The field contains the finger's placement.
    #[error(
        "the finger is not at the pose of the scene's camera: {0}; check whether the image is turned, mirrored or resized, or, for coloured markers, find the pose with \
         --rest, an image of the unloaded finger"
    )]
    Elsewhere(FingerPlacement),
    /// The reference marks and the finger's markers show contradictory positions of the base.
    #[error(
        "the base position shown by the marks that look like references is {away_mm:.0} mm from the base position \
            shown by the ribs; check base.reference.radius_mm, inner_radius_mm and at_mm"
    )]
    OtherReferences {
        /// Distance between the two positions of the base, mm.
        away_mm: f64,
    },
    /// The image shows markers, but no pair of marks with the distance between two references on the base.
    #[error(
        "the references on the base were not found: {} marks look like the references (one number for each \
            reference), but no two of these marks are as far apart as two references; {like_markers} rims look like \
            markers; check base.reference.radius_mm, inner_radius_mm, shade and at_mm, lens and pose",
        counts(like_references)
    )]
    NoReferences {
        /// Number of marks that look like each reference, one number per reference.
        like_references: Vec<usize>,
        /// Number of rims that look like markers.
        like_markers: usize,
    },
    /// Patches of the markers' colours differ in radius from the markers that the camera should see.
    #[error(
        "expected markers with a radius of {expected_px:.1} px, found patches of the marker colours with a radius of {found_px:.1} px: check \
         markers.radius_mm, the camera's pose, and whether the image is resized"
    )]
    OtherSize {
        /// Radius of a marker according to the scene, px.
        expected_px: f64,
        /// Most common radius of the patches, px.
        found_px: f64,
    },
    /// The markers could not be assigned to nodes.
    #[error("no finger is recognised: {0}")]
    Naming(#[from] NamingError),
}

/// Reason why a locator cannot be created.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LocatorError {
    /// A locator for coloured markers was created for grey markers.
    #[error("markers: expected front_rgb and back_rgb, found shade")]
    NotColoured,
    /// A locator for grey markers was created for coloured markers.
    #[error("markers: expected shade, found front_rgb and back_rgb")]
    NotGrey,
    /// Ribs share a junction or end in a corner of the base, so that markers cannot be assigned to nodes by their ribs.
    #[error(
        "finger.ribs.positions_mm: expected ribs that share no junction and do not end in a corner of the base, \
            because the locator uses the ribs to assign markers to nodes"
    )]
    SharedJunctions,
    /// The colour of a marker is too close to grey.
    #[error(transparent)]
    Colour(#[from] GreyMarker),
    /// The camera does not see the finger, or its markers are too small.
    #[error(transparent)]
    Camera(#[from] LocateError),
}

/// Rejects a finger whose ribs share a junction or end in a corner of the base.
pub(super) fn require_own_junctions(finger: &Finger) -> Result<(), LocatorError> {
    if finger.has_shared_junctions() { Err(LocatorError::SharedJunctions) } else { Ok(()) }
}

fn counts(counts: &[usize]) -> String {
    counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" and ")
}

/// A hint for an image whose width and height are exchanged; empty for other images.
fn turned([width, height]: [u32; 2], found: [u32; 2]) -> &'static str {
    if width != height && found == [height, width] {
        ": is the image turned by 90 degrees (EXIF orientation)?"
    } else {
        ""
    }
}
