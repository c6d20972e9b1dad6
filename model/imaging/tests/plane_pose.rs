//! Tests of the pose fit: pixels of a known pose with and without noise, and points that determine no pose.

use finray_imaging::plane_pose::{PlanePoseError, plane_pose};
use finray_model::Vector;
use finray_model::camera::{Camera, Distortion, Lens, Pixel, Pose};
use finray_tests::{camera, cases};
use nalgebra::Vector3;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const NOISE_PX: f64 = 0.05;

proptest! {
    #![proptest_config(cases(256))]

    /// The fit recovers the known pose from noise-free pixels. With noise, its stated standard deviations explain the errors.
    #[test]
    fn points_give_the_pose_back(camera in camera(), height_mm in -5.0..20.0, seed in 0..u64::MAX) {
        let positions: Vec<Vector> = (0..25).map(|i| Vector::new(30.0 * f64::from(i % 5), 15.0 * f64::from(i / 5) - 30.0)).collect();
        let noise: Vec<f64> = StandardNormal.sample_iter(ChaCha8Rng::seed_from_u64(seed)).take(50).collect();
        let seen = |noise_px: f64| -> Vec<(Vector, Pixel)> {
            let at = |(i, position): (usize, &Vector)| {
                let error = Pixel::new(noise[2 * i], noise[2 * i + 1]) * noise_px;
                camera.project(&position.push(height_mm)).ok().map(|pixel| (*position, pixel + error))
            };
            positions.iter().enumerate().filter_map(at).collect()
        };
        let points = seen(0.0);
        prop_assume!(points.len() == positions.len() && points.iter().all(|(_, pixel)| camera.lens.contains(pixel)));
        let found = plane_pose(&camera.lens, height_mm, &points).expect("25 points of a plane");
        prop_assert!(found.residual_sd_px < 1e-7, "{}", found.residual_sd_px);
        prop_assert!((found.pose.translation_mm - camera.pose.translation_mm).norm() < 1e-5);
        prop_assert!((found.pose.rotation.matrix() - camera.pose.rotation.matrix()).norm() < 1e-7);
        // The residual standard deviation of 44 degrees of freedom scatters by 11 %; the tolerance is five times this scatter.
        let noisy = seen(NOISE_PX);
        prop_assume!(noisy.iter().all(|(_, pixel)| camera.lens.contains(pixel)));
        let found = plane_pose(&camera.lens, height_mm, &noisy).expect("25 points of a plane");
        prop_assert!((found.residual_sd_px / NOISE_PX - 1.0).abs() < 0.55, "{}", found.residual_sd_px);
        let sd = found.unit_covariance.diagonal().map(f64::sqrt) * NOISE_PX;
        let turn = (camera.pose.rotation * found.pose.rotation.inverse()).scaled_axis();
        let shift = camera.pose.translation_mm - found.pose.translation_mm;
        for axis in 0..3 {
            // The tolerance is six standard deviations. The tilt is known to within a degree, so nonlinear effects of the tilt are far below one
            // standard deviation.
            prop_assert!(turn[axis].abs() < 6.0 * sd[axis] && shift[axis].abs() < 6.0 * sd[axis + 3], "{turn} {shift} {sd}");
        }
    }
}

/// A camera 170 mm in front of the finger, with 8 px/mm.
fn camera_above_the_plane() -> Camera {
    let lens = Lens::new([1600, 1400], [1360.0, 1360.0], [799.5, 699.5], Distortion::default());
    Camera { lens: lens.expect("a lens"), pose: Pose::new([std::f64::consts::PI, 0.0, 0.0], [-75.0, 0.0, 170.0]) }
}

#[test]
fn points_of_a_line_have_no_pose() {
    let camera = camera_above_the_plane();
    let seen = |positions: &[[f64; 2]]| -> Vec<(Vector, Pixel)> {
        let at = |&[x, y]: &[f64; 2]| (Vector::new(x, y), camera.project(&Vector3::new(x, y, 0.0)).expect("seen"));
        positions.iter().map(at).collect()
    };
    let three = seen(&[[0.0, 0.0], [100.0, 0.0], [0.0, 30.0]]);
    assert_eq!(plane_pose(&camera.lens, 0.0, &three), Err(PlanePoseError::TooFew { found: 3 }));
    let line = seen(&[[0.0, 0.0], [50.0, 10.0], [100.0, 20.0], [125.0, 25.0], [150.0, 30.0]]);
    assert_eq!(plane_pose(&camera.lens, 0.0, &line), Err(PlanePoseError::OnALine));
    // Three of the four points lie on one line, so the pose is not unique.
    let nearly = seen(&[[0.0, 0.0], [50.0, 10.0], [100.0, 20.0], [125.0, 45.0]]);
    let found = plane_pose(&camera.lens, 0.0, &nearly);
    assert_eq!(found, Err(PlanePoseError::OnALine), "{found:?}");
}
