//! The command `finray gripper`.

use super::parse::{MotorAngles, motor_angles};
use crate::commands::prelude::*;
use finray_model::gripper::{Gripper, LinkageErrors, NodeErrors};
use finray_model::keys::{GRIPPER, SceneTable};

/// Step of the motor angle in the paper's experiments, degrees (sec. V-C).
const STEP_DEG: f64 = 22.5;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray gripper fixtures/scenes/gripper.toml --motor-deg -1800:1800:360
  finray gripper fixtures/scenes/gripper.toml --opening-mm 60
  finray gripper fixtures/scenes/gripper.toml --motor-deg 0 --errors 1,0.05,0.05

Guide: finray guide press-and-grasp";

/// Compute the poses of a gripper's two fingers from its motor angle or its opening.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML) with a gripper; - for standard input
    scene: PathBuf,
    /// Motor angle, or range FROM:TO:STEP, degrees [default: the whole range of the linkage in steps of 22.5]
    #[arg(long, value_name = "FROM:TO:STEP", allow_hyphen_values = true, value_parser = motor_angles, conflicts_with = "opening_mm")]
    motor_deg: Option<MotorAngles>,
    /// Distance between the tips, mm, instead of a motor angle; if several motor angles fit, the angle nearest to 0 is used
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    opening_mm: Option<f64>,
    /// Standard deviation of the motor angle, backlash of the screw, and standard deviation of each length of the linkage
    #[arg(long, value_name = "DEG,MM,MM", value_parser = linkage_errors)]
    errors: Option<LinkageErrors>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

fn linkage_errors(text: &str) -> Result<LinkageErrors, String> {
    let numbers: Vec<f64> = text.split(',').map(not_negative).collect::<Result<_, _>>()?;
    match numbers[..] {
        [motor_deg, backlash_mm, length_mm] => Ok(LinkageErrors { motor_deg, backlash_mm, length_mm }),
        _ => Err(format!("expected three numbers, DEG,MM,MM, found {}", numbers.len())),
    }
}

/// Columns that `--errors` adds: for each cause, the position error of the key node that is affected most, mm.
#[derive(Serialize)]
struct ErrorColumns {
    motor_error_mm: Option<f64>,
    backlash_error_mm: Option<f64>,
    rocker_error_mm: Option<f64>,
    link_error_mm: Option<f64>,
    fixed_joint_error_mm: Option<f64>,
}

impl From<Option<NodeErrors>> for ErrorColumns {
    fn from(errors: Option<NodeErrors>) -> ErrorColumns {
        ErrorColumns {
            motor_error_mm: errors.map(|errors| errors.motor_mm),
            backlash_error_mm: errors.map(|errors| errors.backlash_mm),
            rocker_error_mm: errors.map(|errors| errors.rocker_mm),
            link_error_mm: errors.map(|errors| errors.link_mm),
            fixed_joint_error_mm: errors.map(|errors| errors.fixed_joint_mm),
        }
    }
}

#[derive(Serialize)]
struct Row {
    motor_deg: f64,
    slider_mm: f64,
    phi1_rad: Option<f64>,
    phi2_rad: Option<f64>,
    base_x_mm: Option<f64>,
    base_y_mm: Option<f64>,
    angle_rad: Option<f64>,
    opening_mm: Option<f64>,
    opening_per_turn_mm: Option<f64>,
    state: &'static str,
}

fn row(gripper: &Gripper, finger: &Finger, motor_deg: f64) -> Row {
    let pose = gripper.pose(motor_deg);
    let of_pose = pose.as_ref();
    Row {
        motor_deg,
        slider_mm: gripper.slider_mm(motor_deg),
        phi1_rad: of_pose.map(|pose| pose.phi1_rad),
        phi2_rad: of_pose.map(|pose| pose.phi2_rad),
        base_x_mm: of_pose.map(|pose| pose.base.x),
        base_y_mm: of_pose.map(|pose| pose.base.y),
        // The finger is fixed to the link, so both rotate by the same angle (eq. (9) of the paper).
        angle_rad: of_pose.map(|pose| pose.phi2_rad),
        opening_mm: of_pose.map(|pose| gripper.opening_mm(finger, pose)),
        opening_per_turn_mm: of_pose.and_then(|pose| gripper.opening_per_turn_mm(finger, pose)),
        state: match of_pose {
            None => "out of reach",
            Some(pose) if pose.is_singular() => "singular",
            Some(_) => "regular",
        },
    }
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let Scene { finger, gripper, .. } = load_scene(&arguments.scene)?;
    let Some(gripper) = gripper else {
        return Err(bad_input(format!(
            "{}: line 1: gripper is missing: expected a table {}",
            name_of(&arguments.scene),
            GRIPPER.outline()
        )));
    };
    let [from_deg, to_deg] = gripper.reach_deg();
    let motor_deg = match (&arguments.motor_deg, arguments.opening_mm) {
        (Some(angles), _) => angles.0.clone(),
        (None, Some(opening_mm)) => {
            let motor_deg = gripper.motor_deg_for_opening(&finger, opening_mm).ok_or_else(|| {
                bad_input(format!(
                    "--opening-mm: no motor angle in reach ({from_deg:.1} to {to_deg:.1} degrees) sets the tips {opening_mm} mm apart"
                ))
            })?;
            vec![motor_deg]
        }
        // Motor angles: the multiples of `STEP_DEG` within the range of the linkage.
        (None, None) => {
            let [first, last] = [(from_deg / STEP_DEG).ceil() as i64, (to_deg / STEP_DEG).floor() as i64];
            (first..=last).map(|step| step as f64 * STEP_DEG).collect()
        }
    };
    let rows = motor_deg.iter().map(|motor_deg| row(&gripper, &finger, *motor_deg));
    let text = match arguments.errors {
        Some(errors) => csv_text(rows.map(|row| {
            let errors = gripper.node_errors(&finger, row.motor_deg, &errors);
            (row, ErrorColumns::from(errors))
        }))?,
        None => csv_text(rows)?,
    };
    write_file(&arguments.out, &text)?;
    Ok(summary(format!("fingertips at {}", count(motor_deg.len(), "motor angle")), [&arguments.out]))
}
