//! Checks the closed forms of the gripper's linkage over its whole reach against the equations that they solve.
//!
//! Source: Xu et al. (IEEE T-RO 2021), eqs (6) to (9). The lengths of the links are assumed values, stated in the shipped scenes.

use super::ProblemError;
use crate::prelude::*;
use finray_model::gripper::{Gripper, LinkagePose};
use nalgebra::{Matrix3, Vector3};

/// Number of equal intervals between the motor angles that sample the reach.
const ANGLES: usize = 200;
/// Share of the reach omitted at each end, because the derivative of the opening is infinite there.
const END: f64 = 0.01;
/// Tolerance of lengths, relative to the sum of the lengths of rocker and link: rounding error.
pub const TOLERANCE: f64 = 1e-12;
/// Tolerance of the opening at the motor angle that the inverse returns, relative to the sum of the lengths of rocker and link. At the ends of the
/// reach the inverse loses half of its digits, because it contains an arccosine.
pub const INVERSE_TOLERANCE: f64 = 1e-9;
/// Step of the finite differences, degrees of the motor angle.
const STEP_DEG: f64 = 0.1;
/// Tolerance of the derivative against finite differences, relative to the screw's pitch. The derivative grows without bound towards the ends of the
/// reach.
pub const SLOPE_TOLERANCE: f64 = 1e-6;

pub(super) fn shipped() -> Result<Gripper, ProblemError> {
    let reference = |what: String| ProblemError::Reference(what);
    let scene = Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE).map_err(|error| reference(error.to_string()))?;
    scene.gripper.ok_or_else(|| reference("the scene has no gripper".to_owned()))
}

/// Motor angles over the reach of a gripper, degrees, ascending.
pub(super) fn over_reach(gripper: &Gripper) -> Vec<f64> {
    let [from_deg, to_deg] = gripper.reach_deg();
    let angle = |i: usize| from_deg + (END + (1.0 - 2.0 * END) * i as f64 / ANGLES as f64) * (to_deg - from_deg);
    (0..=ANGLES).map(angle).collect()
}

/// Checks of the linkage's equations, the frames of both fingers, the opening's derivative, and the inverse of the opening.
pub fn checks(finger: &Finger, gripper: &Gripper) -> Vec<Check> {
    let angles = over_reach(gripper);
    let pose = |motor_deg: &f64| gripper.pose(*motor_deg);
    let opening = |motor_deg: f64| gripper.pose(motor_deg).map_or(f64::NAN, |pose| gripper.opening_mm(finger, &pose));
    let [rocker_mm, link_mm] = gripper.description().link_mm;
    let size_mm = rocker_mm + link_mm;
    let of_equations = angles.iter().map(|motor_deg| residual_mm(gripper, *motor_deg) / size_mm);
    let of_frames =
        angles.iter().map(|angle| pose(angle).map_or(f64::NAN, |pose| frames_mm(finger, gripper, &pose) / size_mm));
    let of_slope = angles.iter().map(|motor_deg| {
        let over =
            |step_deg: f64| (opening(motor_deg + step_deg) - opening(motor_deg - step_deg)) / (2.0 * step_deg) * 360.0;
        // Errors of second order cancel (Richardson extrapolation).
        let differences = (4.0 * over(0.5 * STEP_DEG) - over(STEP_DEG)) / 3.0;
        let slope = pose(motor_deg).and_then(|pose| gripper.opening_per_turn_mm(finger, &pose)).unwrap_or(f64::NAN);
        (slope - differences).abs() / gripper.description().screw_pitch_mm
    });
    let of_inverse = angles.iter().map(|motor_deg| {
        let there = gripper.motor_deg_for_opening(finger, opening(*motor_deg)).unwrap_or(f64::NAN);
        (opening(there) - opening(*motor_deg)).abs() / size_mm
    });
    let rows = [
        ("rocker and link close", "eqs (6) to (8)", "residual / (rocker + link)", worst(of_equations), TOLERANCE),
        ("key nodes of both fingers", "eq. (9)", "difference / (rocker + link)", worst(of_frames), TOLERANCE),
        (
            "opening by the motor's angle",
            "differences",
            "difference of the slopes / pitch",
            worst(of_slope),
            SLOPE_TOLERANCE,
        ),
        (
            "motor angle for an opening",
            "its inverse",
            "difference of openings / (rocker + link)",
            worst(of_inverse),
            INVERSE_TOLERANCE,
        ),
    ];
    let check = |(what, source, quantity, ours, tolerance): (&str, &str, &str, f64, f64)| {
        let problem = format!("gripper linkage over its reach: {what}");
        // The inverse and the differences compare the linkage with itself.
        let kind = if source.starts_with("eq") { Kind::Analytical } else { Kind::Internal };
        kind.on(problem, source).vanishes(format!("largest {quantity}"), ours, tolerance)
    };
    rows.map(check).into()
}

/// Residual of eqs (6) to (8) at a motor angle (degrees), mm.
fn residual_mm(gripper: &Gripper, motor_deg: f64) -> f64 {
    let description = gripper.description();
    let [l1, l2] = description.link_mm;
    let Some(LinkagePose { phi1_rad, phi2_rad, .. }) = gripper.pose(motor_deg) else { return f64::NAN };
    let l3 = description.slider_mm + motor_deg / 360.0 * description.screw_pitch_mm;
    let of_7 = l2 * phi2_rad.cos() - l1 * phi1_rad.cos() - description.fixed_joint_mm;
    let of_8 = l1 * phi1_rad.sin() + l2 * phi2_rad.sin() - l3;
    of_7.hypot(of_8)
}

/// Largest distance, mm, of a key node from its position by eq. (9) for the left finger, or by the mirror image of eq. (9) for the right finger. The
/// paper's finger frame has x and y exchanged compared with the finger frame of the model.
fn frames_mm(finger: &Finger, gripper: &Gripper, pose: &LinkagePose) -> f64 {
    let ([l1, _], l4) = (gripper.description().link_mm, gripper.description().fixed_joint_mm);
    let (sin, cos) = pose.phi2_rad.sin_cos();
    let (sin1, cos1) = pose.phi1_rad.sin_cos();
    let matrix = Matrix3::new(cos, -sin, -l1 * cos1, sin, cos, l1 * sin1, 0.0, 0.0, 1.0);
    let [left, right] = gripper.fingers(pose);
    let of_node = |node: usize| {
        let at = finger.position(finray_model::NodeId(node));
        let there = matrix * Vector3::new(at.y, at.x, 1.0);
        let in_gripper = Vector::new(there.x - l4, there.y);
        let mirrored = Vector::new(-in_gripper.x, in_gripper.y);
        (left.outwards(at) - in_gripper).norm().max((right.outwards(at) - mirrored).norm())
    };
    worst((1..=finger.key_node_count()).map(of_node))
}
