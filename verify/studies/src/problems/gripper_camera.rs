//! The camera on the gripper: positions of the undeformed fingers in the camera's images while the gripper closes. Measured displacements are
//! relative to the positions of the undeformed finger.
//!
//! Source: Xu et al. (IEEE T-RO 2021), eq. (10); Newton's method gives the position of the joint of rocker and link. Lens, pose and lengths are
//! assumed.

use super::ProblemError;
use super::linkage::{TOLERANCE, over_reach};
use crate::prelude::*;
use finray_model::camera::{Camera, Distortion, Lens, Pixel, Pose};
use finray_model::gripper::{Gripper, LinkagePose};
use nalgebra::{Matrix2, Matrix3, Matrix3x4, Matrix4, Point2, Vector3, Vector4};

/// w_cam, h_cam and l_cam of eq. (10), mm: position of the camera across the screw and along the screw, both from the left rocker's fixed joint, and
/// distance from the plane of the nodes.
const CAMERA_MM: [f64; 3] = [30.0, 95.0, 200.0];
/// Orientation of a camera that views the gripper obliquely: Rodrigues vector of R, rad.
const ASKEW_RAD: [f64; 3] = [2.9, 0.2, -0.1];
/// Focal length, px.
const FOCAL_PX: f64 = 1360.0;
/// Size of the image, px; the optical axis meets its middle.
const SIZE_PX: [u32; 2] = [1600, 1400];
/// Height of the markers above the plane of the beams, towards the camera, mm.
const HEIGHT_MM: f64 = 2.0;
/// Largest number of Newton steps; the method converges quadratically.
const MOST_STEPS: usize = 20;

/// Checks of the finger frames in the camera's frame, and of undeformed nodes in its images.
///
/// # Errors
/// [`ProblemError`] if the camera's lens is invalid.
pub fn checks(finger: &Finger, gripper: &Gripper) -> Result<Vec<Check>, ProblemError> {
    let angles = over_reach(gripper);
    let size_mm: f64 = gripper.description().link_mm.iter().sum();
    let of_frames = angles
        .iter()
        .map(|motor_deg| gripper.pose(*motor_deg).map_or(f64::NAN, |pose| frames_mm(finger, gripper, &pose)) / size_mm);
    let middle_px = SIZE_PX.map(|side| 0.5 * (f64::from(side) - 1.0));
    let lens = Lens::new(SIZE_PX, [FOCAL_PX; 2], middle_px, Distortion::default())
        .map_err(|error| ProblemError::Reference(error.to_string()))?;
    let [_, along_mm, away_mm] = CAMERA_MM;
    let camera = Camera { lens, pose: Pose::new(ASKEW_RAD, [3.0, along_mm, away_mm]) };
    let joints = joints(gripper, &angles);
    let of_images = angles.iter().zip(&joints).map(|(motor_deg, joint)| {
        let pose = gripper.pose(*motor_deg);
        pose.map_or(f64::NAN, |pose| images_mm(finger, gripper, &pose, joint, &camera)) / size_mm
    });
    let rows = [
        ("key nodes of both fingers in the camera's frame", "eq. (10)", "difference", worst(of_frames)),
        (
            "undeformed nodes in images of both fingers",
            "Newton's method on the loop, pinhole matrix",
            "displacement seen",
            worst(of_images),
        ),
    ];
    let check = |(what, source, quantity, ours): (&str, &str, &str, f64)| {
        let problem = format!("camera on the gripper, over the gripper's range of motion: {what}");
        let kind = if source.starts_with("eq") { Kind::Analytical } else { Kind::Internal };
        kind.on(problem, source).vanishes(format!("largest {quantity} / (rocker + link)"), ours, TOLERANCE)
    };
    Ok(rows.map(check).into())
}

/// Largest distance, mm, of a marker in the camera's frame from its position by eq. (10) for the left finger, or by the mirror image of eq. (10) for
/// the right finger.
fn frames_mm(finger: &Finger, gripper: &Gripper, pose: &LinkagePose) -> f64 {
    let ([l1, _], l4) = (gripper.description().link_mm, gripper.description().fixed_joint_mm);
    let [w, h, l] = CAMERA_MM;
    let (sin, cos) = pose.phi2_rad.sin_cos();
    let (sin1, cos1) = pose.phi1_rad.sin_cos();
    #[rustfmt::skip]
    let matrix = Matrix4::new(
        cos, -sin, 0.0, -l1 * cos1 - w,
        sin, cos, 0.0, l1 * sin1 - h,
        0.0, 0.0, 1.0, l,
        0.0, 0.0, 0.0, 1.0,
    );
    // The origin of the gripper's frame is on the screw's axis.
    let camera = Pose::new([0.0; 3], [l4 - w, -h, l]);
    let [left, right] = gripper.fingers(pose).map(|finger| camera.of_placed_finger(&finger));
    let of_node = |at: Vector| {
        // The first axis of the paper's finger frame is along the finger's base, the second points towards the tip.
        let there = matrix * Vector4::new(at.y, at.x, HEIGHT_MM, 1.0);
        let mirrored = Vector3::new(2.0 * (l4 - w) - there.x, there.y, there.z);
        // The third axis of the left finger's frame is opposite to the third axis of the paper's frame.
        let of_left = (left.to_camera(&at.push(-HEIGHT_MM)) - there.xyz()).norm();
        of_left.max((right.to_camera(&at.push(HEIGHT_MM)) - mirrored).norm())
    };
    worst(key_nodes(finger).map(of_node))
}

/// Largest apparent displacement of an undeformed node, mm. The link runs from `joint` to the nut. Nodes are projected by the pinhole matrix, and the
/// pixels are mapped back to the frame of the finger.
fn images_mm(finger: &Finger, gripper: &Gripper, pose: &LinkagePose, joint: &Vector, camera: &Camera) -> f64 {
    let [_, link_mm] = gripper.description().link_mm;
    let nut = Vector::new(gripper.description().fixed_joint_mm, pose.slider_mm);
    let along = (nut - joint) / link_mm;
    let upwards = Vector::new(-along.y, along.x);
    let [u, v] = SIZE_PX.map(|side| 0.5 * (f64::from(side) - 1.0));
    let intrinsic = Matrix3::new(FOCAL_PX, 0.0, u, 0.0, FOCAL_PX, v, 0.0, 0.0, 1.0);
    let mut extrinsic = Matrix3x4::zeros();
    extrinsic.fixed_columns_mut::<3>(0).copy_from(camera.pose.rotation.matrix());
    extrinsic.set_column(3, &camera.pose.translation_mm);
    let pinhole = intrinsic * extrinsic;
    let of_node = |at: Vector| {
        // Positions in the gripper's frame; the left finger is on the negative side.
        let left = joint + along * at.y + upwards * at.x - Vector::new(nut.x, 0.0);
        let right = Vector::new(-left.x, left.y);
        let seen = gripper.fingers(pose).into_iter().zip([left, right]).map(|(placement, there)| {
            let pixel = pinhole * Vector4::new(there.x, there.y, HEIGHT_MM, 1.0);
            let pixel: Pixel = Point2::from_homogeneous(pixel).unwrap_or(Point2::new(f64::NAN, f64::NAN)).coords;
            let before = Camera { pose: camera.pose.of_placed_finger(&placement), ..*camera };
            let height_mm = if placement.mirrored { -HEIGHT_MM } else { HEIGHT_MM };
            before.on_plane(&pixel, height_mm).map_or(f64::NAN, |found| (found - at).norm())
        });
        worst(seen)
    };
    worst(key_nodes(finger).map(of_node))
}

fn key_nodes(finger: &Finger) -> impl Iterator<Item = Vector> + '_ {
    (1..=finger.key_node_count()).map(|node| finger.position(finray_model::NodeId(node)))
}

/// Position of the joint of rocker and link in the mechanism frame, mm, for each motor angle (degrees). The search starts at the smallest angle that
/// is not negative, with the rocker pointing outwards. It continues from there to the smallest and the largest angle.
fn joints(gripper: &Gripper, angles: &[f64]) -> Vec<Vector> {
    let begin = angles.iter().position(|motor_deg| *motor_deg >= 0.0).unwrap_or(angles.len() - 1);
    let outwards = Vector::new(-gripper.description().link_mm[0], 0.0);
    let mut joints = vec![joint(gripper, angles[begin], outwards); angles.len()];
    for i in begin + 1..angles.len() {
        joints[i] = joint(gripper, angles[i], joints[i - 1]);
    }
    for i in (0..begin).rev() {
        joints[i] = joint(gripper, angles[i], joints[i + 1]);
    }
    joints
}

/// Position of the joint of rocker and link, mm: at the rocker's length from the fixed joint, and at the link's length from the nut. Newton's method
/// starts at `near`.
fn joint(gripper: &Gripper, motor_deg: f64, near: Vector) -> Vector {
    let description = gripper.description();
    let [rocker_mm, link_mm] = description.link_mm;
    let nut_mm = description.slider_mm + motor_deg / 360.0 * description.screw_pitch_mm;
    let nut = Vector::new(description.fixed_joint_mm, nut_mm);
    let mut joint = near;
    for _ in 0..MOST_STEPS {
        let to_nut = joint - nut;
        let off = Vector::new(joint.norm_squared() - rocker_mm.powi(2), to_nut.norm_squared() - link_mm.powi(2)) * 0.5;
        let slopes = Matrix2::from_rows(&[joint.transpose(), to_nut.transpose()]);
        joint -= slopes.lu().solve(&off).unwrap_or(Vector::new(f64::NAN, f64::NAN));
    }
    joint
}
