//! Forces and motion of a grasp as table rows.

use super::{GraspScene, GraspStep, finger_name};
use crate::prelude::*;

/// Row for one contact of a finger, or for the finger's total force, in one step of a grasp.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceRow {
    /// Number of the step, from 1. In a stream of images, frame `step - 1` shows this step.
    pub step: usize,
    /// Motor angle, degrees.
    pub motor_deg: f64,
    /// Phase of the grasp.
    pub phase: super::Phase,
    /// Name of the finger: `left` or `right`.
    pub finger: &'static str,
    /// Name of the contact: a node, `at` for a position between nodes, `clamp` if the force does not deform the finger, or `total`.
    pub contact: String,
    /// Position along the front plate, mm from the base of the plate; `None` for the total.
    pub s_mm: Option<f64>,
    /// Direction of the contact normal, degrees from the undeformed inward normal, positive towards the tip; `None` for the total.
    pub angle_deg: Option<f64>,
    /// True force along the normal, N. For the total, the force across the gripper.
    pub force_n: f64,
    /// True force across the normal, N, positive towards the tip. For the total, the force along the gripper.
    pub friction_n: f64,
    /// Sensed force, N; `None` if no force was sensed.
    pub sensed_n: Option<f64>,
    /// Stated standard deviation of the sensed force, N.
    pub sigma_n: Option<f64>,
}

/// Row of the object in a step of a grasp.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectRow {
    /// Number of the step, from 1.
    pub step: usize,
    /// Motor angle, degrees.
    pub motor_deg: f64,
    /// Phase of the grasp.
    pub phase: super::Phase,
    /// Position x of the object's reference point in the gripper's initial frame, mm.
    pub x_mm: f64,
    /// Position y of the object's reference point in the gripper's initial frame, mm.
    pub y_mm: f64,
    /// Angle of the object, rad.
    pub rotation_rad: f64,
    /// Component x of both fingers' force on the object, N.
    pub force_x_n: f64,
    /// Component y of both fingers' force on the object, N.
    pub force_y_n: f64,
    /// Component x of the support's force on the object, N.
    pub support_x_n: f64,
    /// Component y of the support's force on the object, N.
    pub support_y_n: f64,
}

/// Rows of a step: for each finger its contacts from base to tip, then its total.
pub fn force_rows(scene: &GraspScene, step: &GraspStep) -> Vec<ForceRow> {
    let mut rows = Vec::new();
    for (number, finger) in step.fingers.iter().enumerate() {
        let row = |contact: String| ForceRow {
            step: step.step,
            motor_deg: step.motor_deg,
            phase: step.phase,
            finger: finger_name(number),
            contact,
            s_mm: None,
            angle_deg: None,
            force_n: 0.0,
            friction_n: 0.0,
            sensed_n: None,
            sigma_n: None,
        };
        rows.extend(finger.contacts_sensed().map(|(seen, sensed)| ForceRow {
            s_mm: seen.contact.position_mm(scene.finger()),
            angle_deg: Some(seen.contact.angle_deg),
            force_n: seen.normal_n,
            friction_n: seen.friction_n,
            sensed_n: sensed.map(|sensed| sensed.force.sensed_n),
            sigma_n: sensed.map(|sensed| sensed.force.sigma_n),
            ..row(seen.name())
        }));
        let sensed = finger.sensed.as_ref().ok();
        let total = sensed.and_then(Option::as_ref).map(|sensed| sensed.total);
        // Without contact the sensed force is 0.
        let nothing = sensed.filter(|sensed| sensed.is_none()).map(|_| 0.0);
        rows.push(ForceRow {
            force_n: finger.total_n,
            friction_n: -finger.on_object.y,
            sensed_n: total.map(|total| total.sensed_n).or(nothing),
            sigma_n: total.map(|total| total.sigma_n).or(nothing),
            ..row("total".to_owned())
        });
    }
    rows
}

/// Row of the object in a step.
pub fn object_row(step: &GraspStep) -> ObjectRow {
    let force = step.force_on_object();
    ObjectRow {
        step: step.step,
        motor_deg: step.motor_deg,
        phase: step.phase,
        x_mm: step.object[0],
        y_mm: step.object[1],
        rotation_rad: step.object[2],
        force_x_n: force.x,
        force_y_n: force.y,
        support_x_n: step.support_force.x,
        support_y_n: step.support_force.y,
    }
}
