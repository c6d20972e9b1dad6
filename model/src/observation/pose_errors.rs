//! Errors of the camera's pose: displacements of the markers that all images share.

use super::{Observation, exists, plate_turns};
use crate::Vector;
use crate::camera::{Camera, Pose};
use crate::measurement::SharedError;
use crate::scene::{Scene, marker_offset};
use nalgebra::{UnitComplex, Vector6};

impl Observation {
    /// What each error of the scene's pose adds to the displacements of the markers, mm. A marker that does not move is unaffected, because
    /// positions of unloaded markers refer to the image of the unloaded finger. With another pose, this image shows markers with other offsets from
    /// their nodes, and these turn with the plates. Empty for displacements that were not located in an image, and for a base that moves, whose pose
    /// follows from its marks.
    pub(super) fn pose_errors(&self, scene: &Scene) -> Vec<SharedError> {
        let Some((camera, pose)) = scene.camera.and_then(|camera| Some((camera, camera.pose?))) else {
            return Vec::new();
        };
        if scene.base.is_some() || self.markers.iter().any(|marker| marker.pixel.is_none()) {
            return Vec::new();
        }
        let (finger, offsets) = (&scene.finger, &scene.marker_offsets[..]);
        let height_mm = scene.markers.map_or(0.0, |markers| markers.height_mm);
        let seen = Camera { lens: camera.lens, pose };
        let on_plane = |pose: Pose, at: Vector| {
            let pixel = seen.project(&at.push(height_mm)).ok()?;
            Camera { lens: camera.lens, pose }.on_plane(&pixel, height_mm).ok()
        };
        let moved: Vec<_> = self
            .markers
            .iter()
            .filter(|marker| exists(finger, marker.node))
            .filter_map(|marker| Some((marker.node, marker.displacement?)))
            .collect();
        let turns = match offsets {
            [] => vec![UnitComplex::identity(); moved.len()],
            _ => {
                let nodes: Vec<_> =
                    moved.iter().map(|(node, moved)| (*node, finger.marker_position(*node) + moved)).collect();
                plate_turns(finger, &[], &nodes)
            }
        };
        let error = |motion: &Vector6<f64>| {
            let mut pattern_mm = vec![Vector::zeros(); finger.key_node_count()];
            for ((node, moved), turn) in moved.iter().zip(&turns) {
                let at_rest = finger.marker_position(*node) + marker_offset(offsets, *node);
                let displaced = |pose| {
                    let rest = on_plane(pose, at_rest)?;
                    let further_offset = rest - at_rest;
                    Some(on_plane(pose, at_rest + moved)? - rest - (turn * further_offset - further_offset))
                };
                let [there, back] = [pose.moved(motion), pose.moved(&-motion)].map(displaced);
                pattern_mm[node.0 - 1] = there.zip(back).map_or(Vector::zeros(), |(there, back)| 0.5 * (there - back));
            }
            SharedError { pattern_mm, plate: Vec::new(), start: 0.0 }
        };
        scene.pose_errors.iter().map(error).collect()
    }
}
