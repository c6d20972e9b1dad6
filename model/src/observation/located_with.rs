//! The scene with which the markers of an image were located, and observations that were located with another scene.

use super::{Observation, ObservedMarker, exists, nodes_of_markers};
use crate::camera::{Camera, Lens, Pose, ViewError};
use crate::finger::{Finger, NodeId};
use crate::scene::Scene;
use nalgebra::Vector2;
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Lengths and angles count as equal up to this step, mm or rad. Rounding of a computed position is far smaller, and no image shows such a difference.
const STEP: f64 = 1e-6;
/// Word in the text form for a pose that was fitted to an image of the unloaded finger, and for displacements from this image.
const REST: &str = "rest";

/// Finger, pose and lens with which the markers of an image were located, as digests.
///
/// The text form is `NODES.FINGER-POSE-LENS`, with the number of key nodes and three digests of eight hexadecimal digits. `POSE` is `rest` if the pose was
/// fitted to an image of the unloaded finger. If displacements are from such an image, `-rest` follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LocatedWith {
    nodes: usize,
    /// Digest of the positions of the unloaded finger's markers.
    finger: u32,
    /// Digest of the camera's pose, the reference marks of the base, and the offsets of the markers from their nodes. `None` if the pose was fitted to
    /// an image of the unloaded finger.
    pose: Option<u32>,
    /// Digest of the lens and the height of the markers.
    lens: u32,
    is_from_rest: bool,
}

/// What differs between a scene and the scene with which markers were located.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneChange {
    /// The finger's geometry.
    pub finger: bool,
    /// The camera's pose, the reference marks of the base, or the offsets of the markers from their nodes.
    pub pose: bool,
    /// The lens, or the height of the markers.
    pub lens: bool,
}

impl fmt::Display for SceneChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [(self.finger, "finger"), (self.pose, "pose of the camera"), (self.lens, "lens")];
        let changed: Vec<&str> =
            parts.into_iter().filter(|(is_changed, _)| *is_changed).map(|(_, name)| name).collect();
        f.write_str(&changed.join(" and another "))
    }
}

/// Reason for which markers that were located with another scene cannot be located again from their pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the markers were located with another {change} than the scene's, and {cause}: locate the images again with this scene"
)]
pub struct StaleError {
    /// What has changed.
    pub change: SceneChange,
    /// Why the pixels do not suffice.
    pub cause: StaleCause,
}

/// Why the pixels of markers do not suffice to locate these markers with another scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StaleCause {
    /// The numbers of the nodes differ.
    #[error("its nodes have other numbers")]
    Nodes,
    /// The pixels of the unloaded finger are unknown.
    #[error("their displacements are from an image of the unloaded finger")]
    FromRest,
    /// The pixels of the base are unknown.
    #[error("the base moves with reference marks")]
    Base,
    /// Not every marker has a pixel or a position.
    #[error("their pixels are not known")]
    NoPixels,
    /// The scene states no pose.
    #[error("the scene states no pose of the camera")]
    NoPose,
    /// The camera does not see a marker's pixel in the finger's plane.
    #[error("a marker {0}")]
    View(ViewError),
}

/// 32-bit digest of lengths and angles.
///
/// # Reference
/// Fowler, Noll and Vo: hash FNV-1a (RFC 9923).
fn digest(numbers: impl IntoIterator<Item = f64>) -> u32 {
    let bytes = numbers.into_iter().flat_map(|number| ((number / STEP).round() as i64).to_le_bytes());
    bytes.fold(0x811c_9dc5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

fn digest_of_finger(finger: &Finger) -> u32 {
    let positions = (1..=finger.key_node_count()).map(|node| finger.marker_position(NodeId(node)));
    digest(positions.flat_map(|position| [position.x, position.y]))
}

fn digest_of_pose(pose: &Pose, scene: &Scene) -> u32 {
    let offsets = scene.marker_offsets.iter().flat_map(|offset| [offset.x, offset.y]);
    let references = scene.base.iter().flat_map(|base| &base.references);
    let references = references.flat_map(|it| [it.at.x, it.at.y, it.markers.height_mm]);
    let translation = <[f64; 3]>::from(pose.translation_mm);
    digest(pose.rotation_vector_rad().into_iter().chain(translation).chain(references).chain(offsets))
}

fn digest_of_lens(lens: &Lens, height_mm: f64) -> u32 {
    let [size, kind] =
        [lens.size_px().map(f64::from).to_vec(), vec![f64::from(u8::from(lens.distortion().is_fisheye()))]];
    let [focal, principal] = [lens.focal_px(), lens.principal_point_px()];
    let numbers = [size, kind, focal.to_vec(), principal.to_vec(), lens.distortion().coefficients(), vec![height_mm]];
    digest(numbers.into_iter().flatten())
}

impl LocatedWith {
    /// The scene's finger, pose and lens. `None` if the scene lacks camera or markers. Without a pose in the scene, the pose is that of an image of the
    /// unloaded finger.
    pub fn scene(scene: &Scene) -> Option<LocatedWith> {
        let (camera, markers) = (scene.camera?, scene.markers?);
        Some(LocatedWith {
            nodes: scene.finger.key_node_count(),
            finger: digest_of_finger(&scene.finger),
            pose: camera.pose.map(|pose| digest_of_pose(&pose, scene)),
            lens: digest_of_lens(&camera.lens, markers.height_mm),
            is_from_rest: camera.pose.is_none(),
        })
    }

    /// The same for displacements from an image of the unloaded finger. `pose_is_fitted` states whether the pose was fitted to this image.
    pub fn from_rest(self, pose_is_fitted: bool) -> LocatedWith {
        LocatedWith { pose: self.pose.filter(|_| !pose_is_fitted), is_from_rest: true, ..self }
    }

    /// What differs in a scene; `None` if nothing does. A scene without camera is compared by its finger.
    fn change(&self, scene: &Scene) -> Option<SceneChange> {
        let own = LocatedWith::scene(scene);
        let nodes = scene.finger.key_node_count();
        let change = SceneChange {
            finger: (nodes, own.map_or_else(|| digest_of_finger(&scene.finger), |own| own.finger))
                != (self.nodes, self.finger),
            pose: own.and_then(|own| own.pose).zip(self.pose).is_some_and(|(own, with)| own != with),
            lens: own.is_some_and(|own| own.lens != self.lens),
        };
        (change.finger || change.pose || change.lens).then_some(change)
    }
}

impl fmt::Display for LocatedWith {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:08x}-", self.nodes, self.finger)?;
        match self.pose {
            Some(pose) => write!(f, "{pose:08x}")?,
            None => f.write_str(REST)?,
        }
        write!(f, "-{:08x}{}", self.lens, if self.is_from_rest { "-rest" } else { "" })
    }
}

/// A text that is not the text form of [`LocatedWith`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected the text that `finray locate` writes, NODES.FINGER-POSE-LENS")]
pub struct LocatedWithError;

impl FromStr for LocatedWith {
    type Err = LocatedWithError;

    fn from_str(text: &str) -> Result<LocatedWith, LocatedWithError> {
        let parts: Vec<&str> = text.split('-').collect();
        let ([finger, pose, lens], is_from_rest) = match parts[..] {
            [finger, pose, lens] => ([finger, pose, lens], false),
            [finger, pose, lens, REST] => ([finger, pose, lens], true),
            _ => return Err(LocatedWithError),
        };
        let digest = |text: &str| u32::from_str_radix(text, 16).map_err(|_| LocatedWithError);
        let (nodes, finger) = finger.split_once('.').ok_or(LocatedWithError)?;
        Ok(LocatedWith {
            nodes: nodes.parse().map_err(|_| LocatedWithError)?,
            finger: digest(finger)?,
            pose: if pose == REST { None } else { Some(digest(pose)?) },
            lens: digest(lens)?,
            is_from_rest,
        })
    }
}

impl Observation {
    /// What differs between a scene and the scene with which the markers were located. `None` if nothing does, or if the scene of the markers is unknown.
    /// The finger does not matter to displacements from an image of the unloaded finger.
    pub fn change(&self, scene: &Scene) -> Option<SceneChange> {
        let with = self.located_with?;
        let is_other = |change: &SceneChange| {
            let is_of_images = with.is_from_rest && with.nodes == scene.finger.key_node_count();
            change.pose || change.lens || !is_of_images
        };
        with.change(scene).filter(is_other)
    }

    /// This observation, with markers that were located with another scene located again from their pixels. If only the finger has changed, the positions
    /// stay, and displacements are from the scene's finger.
    ///
    /// # Errors
    /// [`StaleError`] if the pixels do not suffice.
    pub fn renewed(&self, scene: &Scene) -> Result<Cow<'_, Observation>, StaleError> {
        let Some(change) = self.change(scene) else { return Ok(Cow::Borrowed(self)) };
        let stale = |cause| StaleError { change, cause };
        let finger = &scene.finger;
        if self.located_with.is_some_and(|with| with.nodes != finger.key_node_count()) {
            return Err(stale(StaleCause::Nodes));
        }
        let mut renewed = self.clone();
        if change.pose || change.lens {
            if self.located_with.is_some_and(|with| with.is_from_rest) {
                return Err(stale(StaleCause::FromRest));
            }
            if self.base.is_some() {
                return Err(stale(StaleCause::Base));
            }
            let (lens, pose) =
                scene.camera.and_then(|camera| Some((camera.lens, camera.pose?))).ok_or(stale(StaleCause::NoPose))?;
            let height_mm = scene.markers.map_or(0.0, |markers| markers.height_mm);
            let camera = Camera { lens, pose };
            for marker in &mut renewed.markers {
                let pixel = marker.pixel.ok_or(stale(StaleCause::NoPixels))?;
                let position = camera.on_plane(&pixel, height_mm);
                marker.position = Some(position.map_err(|error| stale(StaleCause::View(error)))?);
            }
            // A standard deviation is that of a pixel, so it changes with the scale of the image.
            let scale = spread(&renewed.markers) / spread(&self.markers);
            let scaled = |sd_mm: &mut f64| *sd_mm *= if scale.is_finite() { scale } else { 1.0 };
            for marker in &mut renewed.markers {
                marker.sd_mm.as_mut().into_iter().chain(&mut marker.own_sd_mm).for_each(scaled);
            }
            renewed.noise.iter_mut().map(|noise| &mut noise.shared_sd_mm).for_each(scaled);
            let located: Vec<_> = renewed.markers.iter().filter_map(|it| Some((it.node, it.position?))).collect();
            let nodes = nodes_of_markers(finger, &scene.marker_offsets, &located);
            for (marker, (position, sd_mm)) in renewed.markers.iter_mut().zip(nodes) {
                marker.position = Some(position);
                let sds = marker.sd_mm.as_mut().into_iter().chain(&mut marker.own_sd_mm);
                sds.for_each(|marker_sd_mm| *marker_sd_mm = marker_sd_mm.hypot(sd_mm));
            }
        }
        for marker in renewed.markers.iter_mut().filter(|marker| exists(finger, marker.node)) {
            let position = marker.position.ok_or(stale(StaleCause::NoPixels))?;
            marker.displacement = Some(position - finger.marker_position(marker.node));
        }
        renewed.located_with = LocatedWith::scene(scene);
        Ok(Cow::Owned(renewed))
    }
}

/// Root mean square of the distances of markers from their centre, mm.
fn spread(markers: &[ObservedMarker]) -> f64 {
    let positions = || markers.iter().filter_map(|marker| marker.position);
    let count = positions().count() as f64;
    let centre = positions().sum::<Vector2<f64>>() / count;
    (positions().map(|position| (position - centre).norm_squared()).sum::<f64>() / count).sqrt()
}
