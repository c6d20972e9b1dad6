//! Effect of errors in the linkage on the undeformed positions of the nodes. Displacements are measured from these positions.

use super::{Gripper, GripperDescription};
use crate::{Finger, NodeId};

/// Uncertainty of the linkage: standard deviations of angle and lengths, and the backlash of the screw.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LinkageErrors {
    /// Standard deviation of the motor's angle, degrees.
    pub motor_deg: f64,
    /// Backlash of the nut on the screw, mm. The nut's position within the backlash is assumed to be uniformly distributed. For this uniform
    /// distribution, the standard deviation of the nut's position is backlash / sqrt(12).
    pub backlash_mm: f64,
    /// Standard deviation of each of three lengths, mm: rocker, link, and distance of the fixed joint from the screw's axis.
    pub length_mm: f64,
}

/// Largest position error among the undeformed key nodes, one value per cause: standard deviations in mm. The causes are independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeErrors {
    /// Error from the motor's angle, mm.
    pub motor_mm: f64,
    /// Error from the backlash of the screw, mm.
    pub backlash_mm: f64,
    /// Error from the rocker's length, mm.
    pub rocker_mm: f64,
    /// Error from the link's length, mm.
    pub link_mm: f64,
    /// Error from the uncertain distance between the fixed joint and the screw's axis, mm.
    pub fixed_joint_mm: f64,
}

/// Step of the finite differences, as a share of the link's length.
const STEP: f64 = 1e-6;

impl Gripper {
    /// First-order errors of the undeformed key nodes at a motor angle in degrees. `None` if the linkage cannot reach that angle.
    pub fn node_errors(&self, finger: &Finger, motor_deg: f64, errors: &LinkageErrors) -> Option<NodeErrors> {
        let step = STEP * self.description.link_mm[1];
        // Largest displacement of a node per change of a length, mm per mm.
        let largest = |change: &dyn Fn(&mut GripperDescription, f64)| -> Option<f64> {
            let [back, ahead] = [-step, step].map(|by| {
                let mut description = self.description;
                change(&mut description, by);
                let gripper = Gripper::new(description).ok()?;
                let [left, _] = gripper.fingers(&gripper.pose(motor_deg)?);
                Some((1..=finger.key_node_count()).map(move |node| left.outwards(finger.position(NodeId(node)))))
            });
            let moved = back?.zip(ahead?).map(|(back, ahead)| (ahead - back).norm() / (2.0 * step));
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
