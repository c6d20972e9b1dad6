//! Reading of the settings of a grasp: the table `[grasp]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::gripper::Gripper;
use crate::keys::GRASP;

/// Support on which an object lies before it is grasped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// Rails in front of and behind the fingers; the fingers pass between the rails.
    Rails,
    /// A table that the fingers must not touch.
    Table,
}

/// Settings of a grasp of a free object by a gripper.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspDescription {
    /// Motor angle at the start, and the motor angle at which closing stops at the latest, degrees.
    pub motor_deg: [f64; 2],
    /// Motor angle between two steps of the simulation, degrees, above zero. In each step, the simulation brings object and fingers to equilibrium.
    pub step_deg: f64,
    /// Sensed force at which the gripper stops closing, N: the mean over both fingers of the total force on each finger. `None` if the gripper closes
    /// until the last motor angle.
    pub until_force_n: Option<f64>,
    /// Whether the motor keeps the sensed force at `until_force_n` along the path.
    pub holds: bool,
    /// Corner points of the gripper's path relative to the gripper's initial position, mm, in the gripper's initial frame.
    pub path_mm: Vec<Vector>,
    /// Number of steps along the path. In each step, the simulation brings object and fingers to equilibrium.
    pub path_steps: usize,
    /// Whether the gripper opens at the end.
    pub opens: bool,
    /// Support on which the object lies at the start; `None` if the object starts in mid-air.
    pub support: Option<Support>,
    /// Acceleration of gravity (vector), m/s^2, in the gripper's frame at the start.
    pub gravity_m_s2: Vector,
    /// Speed of the motor, degrees/s.
    pub motor_deg_per_s: f64,
    /// Frame rate of the camera, 1/s, if the simulation makes one step per camera frame. `None` if motor angles determine the steps.
    pub frames_per_s: Option<f64>,
    /// Delay between an image and the force sensed from it, in frames.
    pub delay_frames: usize,
    /// Whether the scene's camera is fixed to the gripper. The pose of a camera on the gripper refers to the gripper's frame. If the camera is not
    /// fixed to the gripper, the camera's pose refers to the frame of each finger.
    pub camera_on_gripper: bool,
}

pub(super) fn read_grasp(table: &TableReader, gripper: Option<&Gripper>) -> Result<GraspDescription, SceneError> {
    let Some(gripper) = gripper else {
        return Err(table.wrong(GRASP.motor_deg.name, "a table [gripper] that the motor moves", "none"));
    };
    let motor_deg = table.get(&GRASP.motor_deg)?;
    if motor_deg[0] == motor_deg[1] {
        return Err(table.wrong(GRASP.motor_deg.name, "two different motor angles", "the same angle twice"));
    }
    let [least_deg, most_deg] = gripper.reach_deg();
    if let Some(beyond) = motor_deg.iter().find(|angle| gripper.pose(**angle).is_none()) {
        let expected = format!("motor angles within reach of the linkage, {least_deg:.1} to {most_deg:.1} degrees");
        return Err(table.wrong(GRASP.motor_deg.name, &expected, &format!("{beyond:?}")));
    }
    let until_force_n = table.optional(&GRASP.until_force_n)?;
    let holds = table.is_true(&GRASP.hold)?;
    if holds && until_force_n.is_none() {
        return Err(table.wrong(GRASP.hold.name, "until_force_n in the same table", "none"));
    }
    let path_mm = table.optional(&GRASP.path_mm)?.unwrap_or_default();
    let step_deg = table.get(&GRASP.step_deg)?;
    let most_steps = GRASP.path_steps.kind.2;
    if (motor_deg[1] - motor_deg[0]).abs() / step_deg > most_steps as f64 {
        let expected = format!("an angle that divides the range of motor_deg into at most {most_steps} steps");
        return Err(table.wrong(GRASP.step_deg.name, &expected, &format!("{step_deg:?}")));
    }
    let gravity_m_s2 = table.get(&GRASP.gravity_m_s2)?;
    let support = match table.has(&GRASP.support) {
        true => table.word(&GRASP.support, [Some(Support::Rails), None, Some(Support::Table)])?,
        false if gravity_m_s2 == [0.0; 2] => None,
        false => Some(Support::Rails),
    };
    if support.is_some() && gravity_m_s2 == [0.0; 2] {
        return Err(table.wrong(GRASP.support.name, "a gravity_m_s2 that presses the object onto its support", "none"));
    }
    let frames_per_s = table.optional(&GRASP.frames_per_s)?;
    if frames_per_s.is_some() && table.has(&GRASP.step_deg) {
        return Err(table.wrong(GRASP.step_deg.name, "either step_deg or frames_per_s", "both"));
    }
    let delay_frames = table.get(&GRASP.delay_frames)?;
    if delay_frames > 0 && frames_per_s.is_none() {
        return Err(table.wrong(GRASP.delay_frames.name, "frames_per_s in the same table", "none"));
    }
    Ok(GraspDescription {
        motor_deg,
        step_deg,
        until_force_n,
        holds,
        opens: if table.has(&GRASP.open) { table.is_true(&GRASP.open)? } else { !path_mm.is_empty() },
        path_mm: path_mm.into_iter().map(Vector::from).collect(),
        path_steps: table.get(&GRASP.path_steps)?,
        support,
        gravity_m_s2: gravity_m_s2.into(),
        motor_deg_per_s: table.get(&GRASP.motor_deg_per_s)?,
        frames_per_s,
        delay_frames,
        camera_on_gripper: table.is_true(&GRASP.camera_on_gripper)?,
    })
}
