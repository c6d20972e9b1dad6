//! What fingers may meet beside the object.

use super::{GraspScene, finger_name};
use finray_lattice::grasp::World;
use finray_model::scene::Support;

/// What a finger touches that takes no part in the equilibrium: a grasp ends there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Obstacle {
    /// Both fingers, as on an object that is thinner than their tips come together.
    #[error("the fingers touch each other")]
    EachOther,
    /// The table that the object lies on.
    #[error("the {} finger touches the table", finger_name(*finger))]
    Table {
        /// Its number: 0 is the left one.
        finger: usize,
    },
}

impl GraspScene {
    /// Nothing, where the fingers touch the object alone.
    ///
    /// # Errors
    /// The first [`Obstacle`].
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
