//! Meshes of one finger, from coarse to fine.

use super::{Line, Mesh};
use crate::finger::Finger;
use crate::frame::FrameMotion;
use nalgebra::Rotation2;
use std::sync::{Arc, OnceLock};

/// Meshes with 1, 2, 4, ... 64 elements per member.
const LEVELS: usize = 7;

/// Meshes of a finger with 1, 2, 4, ... 64 elements per member. Each mesh is built when it is first needed. Clones share the
/// meshes.
#[derive(Debug, Clone)]
pub struct MeshLevels {
    finger: Arc<Finger>,
    meshes: Arc<[OnceLock<Arc<Mesh>>; LEVELS]>,
}

impl MeshLevels {
    /// The meshes of a finger; none is built yet.
    pub fn new(finger: &Finger) -> MeshLevels {
        MeshLevels { finger: Arc::new(finger.clone()), meshes: Arc::default() }
    }

    /// The finger.
    pub fn finger(&self) -> &Finger {
        &self.finger
    }

    /// The coarsest mesh with at least `elements` elements per member, or the finest mesh.
    pub fn with_elements(&self, elements: usize) -> &Arc<Mesh> {
        let level = (elements.max(1).next_power_of_two().ilog2() as usize).min(LEVELS - 1);
        self.meshes[level].get_or_init(|| Arc::new(Mesh::with_elements_per_member(&self.finger, 1 << level)))
    }
}

impl Mesh {
    /// Shape of this mesh that interpolates the shape of a mesh with half as many elements per member. Between the ends of each coarse element, the
    /// axis of the beam is a cubic curve.
    pub fn interpolate(&self, coarse: &Mesh, shape: &FrameMotion) -> FrameMotion {
        let mut fine = FrameMotion::at_rest(&self.frame);
        // Key nodes and joints have the same numbers in both meshes.
        let inner = |lines: &[Line]| lines.iter().map(|line| line.nodes[1..line.nodes.len() - 1].len()).sum::<usize>();
        for node in 0..shape.displacements.len() - inner(&coarse.lines) {
            fine.displacements[node] = shape.displacements[node];
            fine.rotations[self.frame.rotation_of(node)] = shape.rotations[coarse.frame.rotation_of(node)];
        }
        for (line, of) in self.lines.iter().zip(&coarse.lines) {
            for (whole, half) in of.members.clone().zip(line.members.clone().step_by(2)) {
                let ends = coarse.frame.members()[whole].ends;
                let [first, second] = [half, half + 1].map(|member| self.frame.members()[member].ends);
                for (end, to) in ends.iter().zip([first[0], second[1]]) {
                    fine.displacements[to.node] = shape.displacements[end.node];
                    fine.rotations[to.rotation] = shape.rotations[end.rotation];
                }
                let at_rest = ends.map(|end| coarse.frame.position(end.node) + end.arm);
                let turns = ends.map(|end| shape.rotations[end.rotation]);
                let bent = [0, 1].map(|i| {
                    let arm = Rotation2::new(turns[i]) * ends[i].arm;
                    coarse.frame.position(ends[i].node) + shape.displacements[ends[i].node] + arm
                });
                // Cubic Hermite interpolation with the tangents of the ends, in a frame that turns with the mean rotation.
                let along = at_rest[1] - at_rest[0];
                let mean = 0.5 * (turns[0] + turns[1]);
                let tangents = turns.map(|turn| Rotation2::new(turn) * along);
                let middle = 0.5 * (bent[0] + bent[1]) + (tangents[0] - tangents[1]) / 8.0;
                let tangent = 1.5 * (bent[1] - bent[0]) - 0.25 * (tangents[0] + tangents[1]);
                let turned = Rotation2::new(-mean) * tangent;
                let to = first[1];
                fine.displacements[to.node] = middle - self.frame.position(to.node);
                fine.rotations[to.rotation] = mean + along.perp(&turned).atan2(along.dot(&turned));
            }
        }
        fine
    }
}

#[cfg(test)]
#[path = "../../tests/units/levels.rs"]
mod tests;
