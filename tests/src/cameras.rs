//! Random cameras.

use finray_model::camera::{Camera, Distortion, Lens, Pose};
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

fn lens() -> impl Strategy<Value = Lens> {
    let distortion = (-0.25..0.25, -0.1..0.1, -0.005..0.005, -0.005..0.005, -0.05..0.05);
    ((1000.0..3000.0, 0.9..1.1), (700.0..900.0, 600.0..800.0), distortion).prop_filter_map(
        "a lens that folds",
        |((focal, aspect), (u, v), (k1, k2, p1, p2, k3))| {
            let distortion = Distortion::from_opencv([k1, k2, p1, p2, k3]);
            let lens = Lens::new([1600, 1400], [focal, focal * aspect], [u, v], distortion).expect("a lens");
            (!lens.folds_image()).then_some(lens)
        },
    )
}

/// A pose in which the camera faces the finger's plane. The plane is tilted by up to half a radian and rotated arbitrarily about its normal. The
/// plane's point (75, 0) mm is 150 to 400 mm from the camera along the optical axis, and within 10 mm of that axis in each coordinate.
fn pose() -> impl Strategy<Value = Pose> {
    let tilt = (-0.35..0.35, -0.35..0.35, -3.0..3.0);
    (tilt, -10.0..10.0, -10.0..10.0, 150.0..400.0).prop_map(|((a, b, turn), x, y, z)| {
        let rotation = Rotation3::from_euler_angles(std::f64::consts::PI + a, b, 0.0)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
        let middle = Vector3::new(75.0, 0.0, 0.0);
        Pose { rotation, translation_mm: Vector3::new(x, y, z) - rotation * middle }
    })
}

/// A camera with a distorting lens that faces the finger's plane.
pub fn camera() -> impl Strategy<Value = Camera> {
    (lens(), pose()).prop_map(|(lens, pose)| Camera { lens, pose })
}
