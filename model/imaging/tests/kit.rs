//! Scene, cameras and disturbances that several tests share: the paper's finger in front of a camera.

use finray_fixtures::CAMERA_SCENE;
use finray_imaging::render::Disturbances;
use finray_model::Scene;
use finray_model::camera::{Camera, Distortion, Lens, Pose};
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Disturbances of an ordinary image: uneven light, blur, noise and clutter.
pub const DISTURBED: Disturbances =
    Disturbances { light_falloff: 0.3, blur_px: 0.8, grey_noise: 2.0, clutter: 20, seed: 0 };

pub fn scene() -> Scene {
    Scene::from_toml(CAMERA_SCENE).expect("the fixture")
}

pub fn camera_of(scene: &Scene) -> Camera {
    let described = scene.camera.expect("the fixture has a camera");
    Camera { lens: described.lens, pose: described.pose.expect("with a pose") }
}

/// A camera that is tilted by up to 15 degrees and has barrel distortion up to k1 = -0.2. The camera is far enough away to see the whole finger.
pub fn tilted(chance: &mut ChaCha8Rng) -> Camera {
    let [k1, k2] = [chance.random_range(-0.2..0.05), chance.random_range(-0.02..0.02)];
    let distortion = Distortion::from_opencv([k1, k2, 0.0005, -0.0005, 0.0]);
    let lens = Lens::new([1600, 1400], [1360.0, 1365.0], [799.5, 699.5], distortion).expect("a lens");
    let mut small = || chance.random_range(-0.25..0.25);
    let rotation = Rotation3::from_euler_angles(std::f64::consts::PI + small(), small(), small() * 0.4);
    let middle =
        Vector3::new(chance.random_range(-3.0..3.0), chance.random_range(-3.0..3.0), chance.random_range(178.0..195.0));
    Camera { lens, pose: Pose { rotation, translation_mm: middle - rotation * Vector3::new(75.0, 0.0, 0.0) } }
}

pub fn rms(numbers: &[f64]) -> f64 {
    (numbers.iter().map(|x| x * x).sum::<f64>() / numbers.len() as f64).sqrt()
}
