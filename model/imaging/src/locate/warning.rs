//! Warnings of an image: reasons why its displacements may err by more than their standard deviations state.

use super::{OtherRadius, SeenRadii};
use finray_model::measurement::Marker;
use finray_model::observation::{LargestClampedMotion, Observation};
use finray_model::scene::{Base, MarkerLook, Markers};
use finray_model::{Finger, NodeId};
use nalgebra::UnitComplex;
use std::fmt;

/// Largest residual of the pose in the image of the unloaded finger without a warning, px. Image noise and lens errors alone cause a smaller residual.
const SURE_REST_PX: f64 = 0.3;
/// A warning is given if at most this share of the grey markers is found. Occlusion hides few markers; with a wrong radius, many are not found.
const MANY_LOST: f64 = 0.75;
/// An image is probably upside down if its base is rotated by more than this, degrees, relative to the base in at least half of the images.
const TURNED_DEG: f64 = 150.0;

/// Reason to doubt the displacements of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ImageWarning {
    /// Markers are blurred in one direction, by this standard deviation, px.
    MotionBlur(f64),
    /// The references on the base do not determine its pose, which follows from the ribs instead.
    BaseFromRibs,
    /// No marker of a clamped node is found, so the pose cannot be verified.
    PoseNotVerified,
    /// The marker of a clamped node is not where the pose puts it.
    ClampedMarker {
        /// The clamped node.
        node: NodeId,
        /// Distance between the marker and its expected position, mm.
        distance_mm: f64,
    },
    /// Many grey markers are missing, which a wrong radius explains better than occlusion.
    MarkersMissing {
        /// Number of markers found.
        found: usize,
        /// Number of markers of the finger.
        expected: usize,
    },
    /// A radius differs from the radius that the scene states.
    OtherRadius(OtherRadius),
    /// The markers in the image of the unloaded finger are away from their positions on the scene's finger, by this root mean square, px.
    RestResidual(f64),
    /// The base is turned by about half a turn relative to other images.
    Turned,
}

impl ImageWarning {
    /// The warning for the residual of the pose in the image of the unloaded finger, px; `None` for a small residual.
    pub fn of_rest(residual_px: f64) -> Option<ImageWarning> {
        (residual_px > SURE_REST_PX).then_some(ImageWarning::RestResidual(residual_px))
    }

    /// Warnings of one image from the observation, the measured radii and the motion blur, px.
    pub(super) fn of_image(
        finger: &Finger,
        markers: &Markers,
        base: Option<&Base>,
        seen: &Observation,
        radii: &SeenRadii,
        motion_blur_px: Option<f64>,
    ) -> Vec<ImageWarning> {
        let from_ribs = seen.base.is_some_and(|base| !base.is_known).then_some(ImageWarning::BaseFromRibs);
        let (expected, found) = (finger.marked_nodes().len(), seen.markers.len());
        let misses_many =
            matches!(markers.look, MarkerLook::Grey { .. }) && found as f64 <= MANY_LOST * expected as f64;
        let missing = ImageWarning::MarkersMissing { found, expected };
        let radii = OtherRadius::of(markers, base, &[radii]).into_iter().map(ImageWarning::OtherRadius);
        let first = [motion_blur_px.map(ImageWarning::MotionBlur), from_ribs, doubt_of_pose(finger, seen)];
        first.into_iter().flatten().chain(misses_many.then_some(missing)).chain(radii).collect()
    }

    /// Whether each image deserves the warning [`Turned`](ImageWarning::Turned): its base is turned relative to at least half of the images whose
    /// base is known.
    pub fn turned(images: &[&Observation]) -> Vec<bool> {
        let turn = |seen: &Observation| seen.base.filter(|base| base.is_known).map(|base| base.pose.rotation);
        let turns: Vec<Option<UnitComplex<f64>>> = images.iter().map(|seen| turn(seen)).collect();
        let known = turns.iter().flatten().count();
        let is_turned = |own: &UnitComplex<f64>| {
            let away = turns.iter().flatten().filter(|other| own.angle_to(other).to_degrees().abs() > TURNED_DEG);
            2 * away.count() >= known
        };
        turns.iter().map(|own| own.as_ref().is_some_and(is_turned)).collect()
    }
}

/// Contradiction between the markers of clamped nodes and the pose from which displacements are measured. `None` if these markers and the pose agree,
/// if the base is movable, or if no clamped node has a marker.
fn doubt_of_pose(finger: &Finger, seen: &Observation) -> Option<ImageWarning> {
    let mut nodes = finger.clamped_nodes().into_iter().filter(|node| finger.has_marker(*node)).peekable();
    if seen.base.is_some() || nodes.peek().is_none() {
        return None;
    }
    let clamped: Vec<_> = nodes.filter_map(|node| seen.markers.iter().find(|marker| marker.node == node)).collect();
    if clamped.is_empty() {
        return Some(ImageWarning::PoseNotVerified);
    }
    clamped.iter().find_map(|seen| {
        let marker = Marker { node: seen.node, displacement: seen.displacement?, weight: 1.0 };
        LargestClampedMotion::of(Some(seen.sd_mm?), []).check(finger, &marker).err()?;
        Some(ImageWarning::ClampedMarker { node: marker.node, distance_mm: marker.displacement.norm() })
    })
}

/// Remedy for a doubtful pose.
const REMEDY: &str = "for coloured markers, an image of the unloaded finger (rest) determines the pose";

impl fmt::Display for ImageWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ImageWarning::MotionBlur(blur_px) => write!(
                f,
                "markers are blurred in one direction, by {blur_px:.1} px (standard deviation), probably by motion during the exposure; sigma_mm \
                 includes the error that a steady motion causes"
            ),
            ImageWarning::BaseFromRibs => write!(
                f,
                "no two references on the base were found, so the pose of the base is estimated from the ribs: use these displacements only where \
                 the base is estimated together with the forces"
            ),
            ImageWarning::PoseNotVerified => {
                write!(f, "no marker of a clamped node is found, so the pose cannot be verified; {REMEDY}")
            }
            ImageWarning::ClampedMarker { node, distance_mm } => write!(
                f,
                "the marker of clamped node {node} is {distance_mm:.2} mm away from the position that the pose gives for it: displacements err by \
                 at least this distance, and sigma_mm does not include this error; {REMEDY}"
            ),
            ImageWarning::MarkersMissing { found, expected } => write!(
                f,
                "{found} of {expected} markers were found: if nothing hides the others, check markers.radius_mm and inner_radius_mm"
            ),
            ImageWarning::OtherRadius(other) => other.fmt(f),
            ImageWarning::RestResidual(residual_px) => write!(
                f,
                "the markers are {residual_px:.1} px (rms) away from their positions on the scene's unloaded finger. If the finger carries a load \
                 in this image, every sensed force is wrong by that load; if the markers are merely mounted beside their nodes, this causes no error"
            ),
            ImageWarning::Turned => write!(
                f,
                "the base is turned by more than {TURNED_DEG} deg relative to other images: check the EXIF orientation of the image"
            ),
        }
    }
}
