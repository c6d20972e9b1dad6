//! How a gripper grasps: `[grasp]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::gripper::Gripper;

/// All keys of `[grasp]`.
pub(super) const KEYS: [&str; 13] = [
    "motor_deg",
    "step_deg",
    "until_force_n",
    "hold",
    "path_mm",
    "path_steps",
    "open",
    "support",
    "gravity_m_s2",
    "motor_deg_per_s",
    "frames_per_s",
    "delay_frames",
    "camera_on_gripper",
];

/// Motor angle between two settled steps, degrees (Xu et al. 2021, sec. V-C).
const STEP_DEG: f64 = 22.5;
/// Speed of the motor, degrees a second (the same, sec. V-D).
const MOTOR_DEG_PER_S: f64 = 30.0;
/// Gravity on the ground, m/s^2, towards the fingertips of a gripper that points down.
const GRAVITY_M_S2: [f64; 2] = [0.0, 9.81];
/// Steps of a path where the scene does not say.
const PATH_STEPS: usize = 10;
/// Most steps that are of use.
const MOST_STEPS: usize = 10_000;
/// Largest length of a path, in mm, and largest gravity, force and rate, in their units.
const LARGEST: f64 = 1e4;

/// What an object lies on before it is grasped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// Rails before and behind the fingers, which pass between them.
    Rails,
    /// A table, which fingers must not touch.
    Table,
}

/// What a gripper does to a free object.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspDescription {
    /// Motor angles, degrees: where it starts, and where it stops at the latest.
    pub motor_deg: [f64; 2],
    /// Motor angle between two settled steps, degrees, above zero.
    pub step_deg: f64,
    /// Sensed total of a finger, N, at which it stops closing.
    pub until_force_n: Option<f64>,
    /// Whether the motor goes on to hold that total on the way.
    pub holds: bool,
    /// Corners of the way of the gripper from where it starts, mm; the frame is that of the gripper where it starts.
    pub path_mm: Vec<Vector>,
    /// Settled steps on that way.
    pub path_steps: usize,
    /// Whether it opens at the end.
    pub opens: bool,
    /// What the object lies on at first; nothing for one in mid-air.
    pub support: Option<Support>,
    /// Gravity, m/s^2, in the frame of the gripper where it starts.
    pub gravity_m_s2: Vector,
    /// Speed of the motor, degrees a second.
    pub motor_deg_per_s: f64,
    /// Frames of the camera a second, where steps follow the camera instead of the motor angle.
    pub frames_per_s: Option<f64>,
    /// By how many frames sensing is late.
    pub delay_frames: usize,
    /// Whether the scene's camera stands on the gripper and sees its frame, instead of standing before each finger.
    pub camera_on_gripper: bool,
}

pub(super) fn read_grasp(table: &TableReader, gripper: Option<&Gripper>) -> Result<GraspDescription, SceneError> {
    let positive = |key: &str, what: &str| match table.optional_number(key, what)? {
        Some(value) if !(value.is_normal() && 0.0 < value && value <= LARGEST) => {
            Err(table.wrong(key, &format!("a {what} above zero, up to {LARGEST}"), &format!("{value:?}")))
        }
        value => Ok(value),
    };
    let Some(gripper) = gripper else {
        return Err(table.at("motor_deg", "motor_deg: expected a table [gripper] that the motor moves, found none"));
    };
    let motor_deg: [f64; 2] = table.numbers("motor_deg", "motor angles in degrees, from and to")?;
    if motor_deg[0] == motor_deg[1] {
        return Err(table.wrong("motor_deg", "two different motor angles", "the same twice"));
    }
    let [least_deg, most_deg] = gripper.reach_deg();
    if let Some(beyond) = motor_deg.iter().find(|angle| gripper.pose(**angle).is_none()) {
        let expected = format!("motor angles in reach, {least_deg:.1} to {most_deg:.1} degrees");
        return Err(table.wrong("motor_deg", &expected, &format!("{beyond:?}")));
    }
    let until_force_n = positive("until_force_n", "force in N")?;
    let needs_force = |key: &str, is_wanted: bool| match is_wanted && until_force_n.is_none() {
        true => Err(table.wrong(key, "it together with until_force_n", "it alone")),
        false => Ok(is_wanted),
    };
    let path_mm = table.optional_pairs("path_mm", "[x, y], points in mm from where the gripper starts")?;
    let path_mm: Vec<Vector> = path_mm.unwrap_or_default().into_iter().map(Vector::from).collect();
    if let Some(far) = path_mm.iter().find(|point| point.norm().is_nan() || point.norm() > LARGEST) {
        let found = format!("[{:?}, {:?}]", far.x, far.y);
        return Err(table.wrong("path_mm", &format!("points within {LARGEST} mm"), &found));
    }
    let path_steps = table.optional_count("path_steps")?.unwrap_or(PATH_STEPS);
    if !(1..=MOST_STEPS).contains(&path_steps) {
        return Err(table.wrong("path_steps", &format!("a whole number, 1 to {MOST_STEPS}"), &path_steps.to_string()));
    }
    let step_deg = positive("step_deg", "motor angle in degrees")?.unwrap_or(STEP_DEG);
    let steps = (motor_deg[1] - motor_deg[0]).abs() / step_deg;
    if steps > MOST_STEPS as f64 {
        let expected = format!("a motor angle that makes at most {MOST_STEPS} steps of motor_deg");
        return Err(table.wrong("step_deg", &expected, &format!("{step_deg:?}")));
    }
    let gravity_m_s2 = table.optional_numbers("gravity_m_s2", "gravity in m/s^2")?.unwrap_or(GRAVITY_M_S2);
    if gravity_m_s2.iter().any(|g| g.abs() > LARGEST) {
        return Err(table.wrong(
            "gravity_m_s2",
            &format!("up to {LARGEST} m/s^2 either way"),
            &format!("{gravity_m_s2:?}"),
        ));
    }
    let kinds = [("true", Some(Support::Rails)), ("false", None), ("\"table\"", Some(Support::Table))];
    let by_gravity = if gravity_m_s2 == [0.0; 2] { None } else { Some(Support::Rails) };
    let support = table.optional_value("support", &kinds)?.unwrap_or(by_gravity);
    if support.is_some() && gravity_m_s2 == [0.0; 2] {
        return Err(table.wrong("support", "a gravity that puts the object on its support", "none"));
    }
    let frames_per_s = positive("frames_per_s", "rate in frames a second")?;
    if frames_per_s.is_some() && table.has("step_deg") {
        return Err(table.wrong("step_deg", "either it or frames_per_s", "both"));
    }
    let delay_frames = table.optional_count("delay_frames")?.unwrap_or(0);
    if delay_frames > 0 && frames_per_s.is_none() {
        return Err(table.wrong("delay_frames", "it together with frames_per_s", "it alone"));
    }
    if delay_frames > MOST_STEPS {
        return Err(table.wrong("delay_frames", &format!("up to {MOST_STEPS}"), &delay_frames.to_string()));
    }
    Ok(GraspDescription {
        motor_deg,
        step_deg,
        until_force_n,
        holds: needs_force("hold", table.optional_switch("hold")?.unwrap_or(false))?,
        opens: table.optional_switch("open")?.unwrap_or(!path_mm.is_empty()),
        path_mm,
        path_steps,
        support,
        gravity_m_s2: gravity_m_s2.into(),
        motor_deg_per_s: positive("motor_deg_per_s", "speed in degrees a second")?.unwrap_or(MOTOR_DEG_PER_S),
        frames_per_s,
        delay_frames,
        camera_on_gripper: table.optional_switch("camera_on_gripper")?.unwrap_or(false),
    })
}
