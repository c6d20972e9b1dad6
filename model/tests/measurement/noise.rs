//! Samples of the noise of measured displacements have the stated covariance.

use finray_model::measurement::{DisplacementNoise, Marker, Measurement};
use finray_model::{NodeId, Vector};
use finray_tests::paper;
use nalgebra::{DMatrix, DVector};

const POSITIONS: [Vector; 3] = [Vector::new(10.0, 29.0), Vector::new(150.0, 0.0), Vector::new(80.0, -12.0)];
const MODELS: [DisplacementNoise; 3] = [
    DisplacementNoise::Independent { sd_mm: 0.067 },
    DisplacementNoise::TwoImages { image_sd_mm: 0.067 },
    DisplacementNoise::Kinematic { image_sd_mm: 0.067, translation_sd_mm: 0.05, rotation_sd_rad: 0.002 },
];

/// A generator of random numbers, so that the test needs no other crate. The generator returns sums of twelve uniform numbers, shifted to mean 0,
/// with variance 1 (Irwin and Hall). The uniform numbers come from a linear congruence.
fn normals() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// Noise samples, averaged over frames, have the stated covariance. Samples and covariance are computed independently.
#[test]
fn samples_have_the_stated_covariance() {
    const FRAMES: usize = 4;
    const SAMPLES: usize = 20_000;
    let marker = |i| Marker { node: NodeId(i), displacement: Vector::zeros(), weight: 1.0 };
    let still = Measurement::new(&paper(), (2..5).map(marker)).expect("free nodes");
    for noise in MODELS {
        let mut normal = normals();
        let mut found = DMatrix::<f64>::zeros(6, 6);
        for _ in 0..SAMPLES {
            let shared = noise.shared_errors_mm(&POSITIONS, &mut normal);
            let mut mean = DVector::<f64>::zeros(6);
            for _ in 0..FRAMES {
                let mut seen = still.clone();
                noise.add_to(&mut seen, &shared, &mut normal);
                let coordinates = seen.markers().iter().flat_map(|m| [m.displacement.x, m.displacement.y]);
                mean += DVector::from_iterator(6, coordinates) / FRAMES as f64;
            }
            found += &mean * mean.transpose() / SAMPLES as f64;
        }
        let stated = noise.covariance_mm2(&POSITIONS, FRAMES);
        for i in 0..6 {
            for j in 0..6 {
                // The standard error of a sampled covariance is sqrt((s_ii s_jj + s_ij^2) / samples). The tolerance is five standard errors, because
                // 63 values are compared.
                let scatter = ((stated[(i, i)] * stated[(j, j)] + stated[(i, j)].powi(2)) / SAMPLES as f64).sqrt();
                assert!((found[(i, j)] - stated[(i, j)]).abs() < 5.0 * scatter, "{noise:?} {i} {j}: {found}");
            }
        }
    }
}

/// Averaging over frames removes the errors of single frames, but not the error of the reference.
#[test]
fn frames_do_not_average_the_reference_away() {
    let variance = |noise: &DisplacementNoise, frames| noise.covariance_mm2(&POSITIONS, frames)[(0, 0)];
    let [independent, images, kinematic] = &MODELS;
    let image = 0.067_f64.powi(2);
    let many = 1_000_000;
    assert!(variance(independent, many) < 1e-5 * image);
    assert!((variance(images, 1) / image - 2.0).abs() < 1e-12);
    assert!((variance(images, many) / image - 1.0).abs() < 1e-5);
    // A marker at (10, 29) mm moves by 29 mm in x per radian of rotation.
    let base = 0.05_f64.powi(2) + (29.0_f64 * 0.002).powi(2);
    assert!(((variance(kinematic, many) - 1e-6 * image) / base - 1.0).abs() < 1e-12);
}

#[test]
fn whitened_errors_are_independent() {
    for noise in MODELS {
        let factor = noise.factored(&POSITIONS, 1).expect("noise");
        let whitened = |columns: &DMatrix<f64>| factor.l().solve_lower_triangular(columns).expect("noise");
        let whole = whitened(&whitened(&noise.covariance_mm2(&POSITIONS, 1)).transpose());
        assert!((whole - DMatrix::<f64>::identity(6, 6)).amax() < 1e-10);
    }
    assert!(DisplacementNoise::Independent { sd_mm: 0.0 }.factored(&POSITIONS, 1).is_none());
}
