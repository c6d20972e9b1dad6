//! Errors of the camera's pose: displacements of the markers that all images share.

use super::Observation;
use crate::Vector;
use crate::camera::{Camera, Pose};
use crate::measurement::SharedError;
use crate::scene::{Scene, marker_offset};

impl Observation {
    /// What each error of the scene's pose adds to the displacements of the markers, mm. A marker that does not move is unaffected, because
    /// positions of unloaded markers refer to the image of the unloaded finger. Empty for displacements that were not located in an image, and for a
    /// base that moves, whose pose follows from its marks.
    pub(super) fn pose_errors(&self, scene: &Scene) -> Vec<SharedError> {
        let Some((camera, pose)) = scene.camera.and_then(|camera| Some((camera, camera.pose?))) else {
            return Vec::new();
        };
        if scene.base.is_some() || self.markers.iter().any(|marker| marker.pixel.is_none()) {
            return Vec::new();
        }
        let height_mm = scene.markers.map_or(0.0, |markers| markers.height_mm);
        let seen = Camera { lens: camera.lens, pose };
        let on_plane = |pose: Pose, at: Vector| {
            let pixel = seen.project(&at.push(height_mm)).ok()?;
            Camera { lens: camera.lens, pose }.on_plane(&pixel, height_mm).ok()
        };
        let error = |motion| {
            let mut pattern_mm = vec![Vector::zeros(); scene.finger.key_node_count()];
            for marker in &self.markers {
                let Some(pattern_mm) = marker.node.0.checked_sub(1).and_then(|index| pattern_mm.get_mut(index)) else {
                    continue;
                };
                let at_rest =
                    scene.finger.marker_position(marker.node) + marker_offset(&scene.marker_offsets, marker.node);
                let displaced = |pose| {
                    let moved = marker.displacement?;
                    Some(on_plane(pose, at_rest + moved)? - on_plane(pose, at_rest)?)
                };
                let [there, back] = [pose.moved(motion), pose.moved(&-motion)].map(displaced);
                *pattern_mm = there.zip(back).map_or(Vector::zeros(), |(there, back)| 0.5 * (there - back));
            }
            SharedError { pattern_mm, plate: Vec::new(), start: 0.0 }
        };
        scene.pose_errors.iter().map(error).collect()
    }
}
