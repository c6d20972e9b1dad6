//! Obstacles: bodies that the fingers may touch, apart from the grasped object.

use super::{GraspScene, finger_name};
use finray_contact::World;
use finray_model::scene::Support;

/// A contact of a finger with a body other than the object. Such a contact ends the grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Obstacle {
    /// The fingers touch each other, for example if the object is thinner than the smallest gap between the tips.
    #[error("the fingers touch each other")]
    EachOther,
    /// A finger touches the table that supports the object.
    #[error("the {} finger touches the table", finger_name(*finger))]
    Table {
        /// Index of the finger: 0 is the left one.
        finger: usize,
    },
}

impl GraspScene {
    /// Checks that the fingers touch nothing but the object; fails with the first [`Obstacle`] otherwise.
    pub(super) fn require_clear(&self, world: &World) -> Result<(), Obstacle> {
        let table = self.support().filter(|_| self.grasp.support == Some(Support::Table));
        if let Some(plane) = table
            && let Some(finger) = (0..world.placements().len()).find(|finger| world.height_mm(*finger, plane) <= 0.0)
        {
            return Err(Obstacle::Table { finger });
        }
        if world.between_fingers_mm() <= 0.0 { Err(Obstacle::EachOther) } else { Ok(()) }
    }
}
