//! What errors of the linkage do to the undeformed nodes, which displacements are counted from.

use super::{Gripper, GripperDescription, ImpossibleLinkage};
use crate::{Finger, NodeId, Vector};

/// How well the linkage is known: standard deviations, and the play of the screw.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LinkageErrors {
    /// Of the motor's angle, degrees.
    pub motor_deg: f64,
    /// Play of the nut on the screw, mm. The nut is anywhere in it with equal probability: a standard deviation of the play over the root of 12.
    pub backlash_mm: f64,
    /// Of each length: rocker, link, and the fixed joint's distance from the screw's axis, mm.
    pub length_mm: f64,
}

/// The largest error of an undeformed key node by each cause, a standard deviation in mm; they are independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeErrors {
    /// Of the motor's angle.
    pub motor_mm: f64,
    /// Of the play of the screw.
    pub backlash_mm: f64,
    /// Of the rocker's length.
    pub rocker_mm: f64,
    /// Of the link's length.
    pub link_mm: f64,
    /// Of the fixed joint's place.
    pub fixed_joint_mm: f64,
}

/// Step of the differences, as a share of the link's length.
const STEP: f64 = 1e-6;

impl Gripper {
    /// Errors of the undeformed key nodes at a motor angle (deg), to first order, shared by a finger; `None` out of reach.
    pub fn node_errors(&self, finger: &Finger, motor_deg: f64, errors: &LinkageErrors) -> Option<NodeErrors> {
        let step = STEP * self.description.link_mm[1];
        // The largest movement of a node by a length, mm a mm.
        let largest = |change: &dyn Fn(&mut GripperDescription, f64)| -> Option<f64> {
            let [back, ahead] = [-step, step].map(|by| {
                let mut description = self.description;
                change(&mut description, by);
                description_nodes(description, finger, motor_deg).ok().flatten()
            });
            let moved = back?.into_iter().zip(ahead?).map(|(back, ahead)| (ahead - back).norm() / (2.0 * step));
            Some(moved.fold(0.0, f64::max))
        };
        let by_nut = largest(&|description, by| description.slider_mm += by)?;
        let [rocker, link] = [0, 1].map(|i| largest(&move |description, by| description.link_mm[i] += by));
        let fixed_joint = largest(&|description, by| description.fixed_joint_mm += by)?;
        Some(NodeErrors {
            motor_mm: errors.motor_deg / 360.0 * self.description.screw_pitch_mm * by_nut,
            backlash_mm: errors.backlash_mm / 12.0_f64.sqrt() * by_nut,
            rocker_mm: errors.length_mm * rocker?,
            link_mm: errors.length_mm * link?,
            fixed_joint_mm: errors.length_mm * fixed_joint,
        })
    }
}

/// Undeformed key nodes of the left finger in the gripper's frame; none out of reach.
fn description_nodes(
    description: GripperDescription,
    finger: &Finger,
    motor_deg: f64,
) -> Result<Option<Vec<Vector>>, ImpossibleLinkage> {
    let gripper = Gripper::new(description)?;
    Ok(gripper.pose(motor_deg).map(|pose| {
        let [left, _] = gripper.fingers(&pose);
        (1..=finger.key_node_count()).map(|node| left.outwards(finger.position(NodeId(node)))).collect()
    }))
}
