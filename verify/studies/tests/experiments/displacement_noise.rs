//! Noise models of displacements.

use finray_model::Vector;
use finray_model::measurement::DisplacementNoise;
use finray_model::measurement::noise::base_motions;
use finray_studies::experiments::displacement_noise::{DisplacementNoiseStudy, bound_n2};
use finray_tests::{CAMERA_NOISE_MM, paper};
use nalgebra::DMatrix;

/// The bounds follow from the origin of the undeformed positions. Ordinary least squares reaches the bound of independent errors alone.
#[test]
fn floors_follow_from_where_undeformed_positions_come_from() {
    let study = DisplacementNoiseStudy::run(&paper(), CAMERA_NOISE_MM, 1.5);
    assert_eq!(study.rows.len(), 3 * (11 + 4));
    assert!(study.check().passes(), "{:?}", study.check());
    let of = |nodes: &str, noise: &str| {
        study.rows.iter().find(|row| row.nodes == nodes && row.noise == noise).expect("a row of each")
    };
    for row in study.rows.iter().filter(|row| row.noise == "independent") {
        let [images, motor] = ["two images", "motor angle"].map(|noise| of(&row.nodes, noise));
        assert!((images.bound_n / row.bound_n - 2.0_f64.sqrt()).abs() < 1e-12, "{images:?}");
        assert!(motor.bound_n > row.bound_n && motor.ordinary_rms_n > row.ordinary_rms_n, "{motor:?}");
        assert!((row.ordinary_rms_n / row.bound_n - 1.0).abs() < 1e-9, "{row:?}");
        // Averaging 25 frames reduces the errors of the frames, but not the error of the reference image.
        assert!((row.bound_of_25_frames_n / row.bound_n - 0.2).abs() < 1e-12);
        assert!((images.bound_of_25_frames_n / row.bound_n - 1.04_f64.sqrt()).abs() < 1e-12);
    }
    // Unknown translations and rotations are projected out; if they are known, only the error of one image remains.
    let finger = paper();
    let positions: Vec<Vector> = finger.free_nodes().map(|node| finger.position(node)).collect();
    let derivatives = DMatrix::from_fn(2 * positions.len(), 1, |row, _| {
        (0.1 * row as f64).sin() + if row % 2 == 1 { 0.5 } else { 0.0 }
    });
    let kinematic = |translation_sd_mm, rotation_sd_rad| {
        let noise = DisplacementNoise::Kinematic { image_sd_mm: CAMERA_NOISE_MM, translation_sd_mm, rotation_sd_rad };
        bound_n2(&noise, &positions, &derivatives, 1).expect("a force that moves nodes")[(0, 0)].sqrt()
    };
    let base = base_motions(&positions);
    let projected = &derivatives
        - &base * (base.transpose() * &base).try_inverse().expect("three motions") * base.transpose() * &derivatives;
    assert!((kinematic(1e3, 1e2) * projected.norm() / CAMERA_NOISE_MM - 1.0).abs() < 1e-6);
    assert!((kinematic(0.0, 0.0) * derivatives.norm() / CAMERA_NOISE_MM - 1.0).abs() < 1e-12);
}
