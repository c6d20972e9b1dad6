//! Tests of the lens fit on images of a plane grid.

use finray_imaging::grid::{Grid, LensOfGridsError, NoGrid, find_grid, lens_of_grids};
use finray_imaging::lens_fit::LENS_PARAMETERS;
use finray_imaging::render::{Disturbances, GridPlate, render_grid};
use finray_model::Vector;
use finray_model::camera::{Camera, Distortion, Lens, Pose};
use finray_tests::{random_stream, repetitions};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const PLATE: GridPlate = GridPlate { pitch_mm: 10.0, radius_mm: 2.5, counts: [21, 19], greys: [205, 45] };
const DISTURBED: Disturbances = Disturbances { light_falloff: 0.5, blur_px: 0.8, grey_noise: 2.0, clutter: 0, seed: 0 };

fn lens() -> Lens {
    let distortion = Distortion::from_opencv([-0.18, 0.06, 0.0006, -0.0004, 0.0]);
    Lens::new([1600, 1400], [1372.0, 1368.0], [811.0, 688.0], distortion).expect("a lens")
}

/// A camera in front of the grid. The camera is tilted by up to `tilt` rad about two axes, and rotated arbitrarily about the optical axis.
fn before_the_grid(number: u64, tilt: f64) -> Camera {
    let mut chance = random_stream(3, number);
    let tilt = tilt.max(1e-3);
    let slant = Rotation3::from_euler_angles(
        std::f64::consts::PI + chance.random_range(-tilt..tilt),
        chance.random_range(-tilt..tilt),
        0.0,
    );
    let rotation = slant * Rotation3::from_axis_angle(&Vector3::z_axis(), chance.random_range(-3.0..3.0));
    let middle =
        [chance.random_range(-15.0..15.0), chance.random_range(-15.0..15.0), chance.random_range(190.0..240.0)];
    Camera { lens: lens(), pose: Pose { rotation, translation_mm: middle.into() } }
}

fn grid_of(camera: &Camera, plate: &GridPlate, seed: u64) -> Result<Grid, NoGrid> {
    // An object hides one corner of the plate.
    let is_hidden = |at: &Vector| (at - Vector::new(60.0, -50.0)).norm() < 25.0;
    find_grid(&render_grid(camera, plate, is_hidden, Disturbances { seed, ..DISTURBED }))
}

#[test]
fn every_parameter_of_the_lens_is_within_its_standard_deviations() {
    let images = repetitions(5, 8);
    let cameras: Vec<Camera> = (0..images).map(|number| before_the_grid(number, 0.5)).collect();
    let grids: Vec<Grid> =
        cameras.par_iter().enumerate().map(|(i, camera)| grid_of(camera, &PLATE, i as u64).expect("a grid")).collect();
    let dots: usize = grids.iter().map(|grid| grid.dots.len()).sum();
    assert!(dots as u64 > 180 * images, "{dots} dots");
    let (fit, _) = lens_of_grids([1600, 1400], PLATE.pitch_mm, &grids).expect("a lens");
    // The centre of a dot is accurate to 0.02 px.
    assert!(fit.residual_sd_px < 0.05, "{}", fit.residual_sd_px);
    let truth = lens();
    let [fx, fy] = truth.focal_px();
    let [cx, cy] = truth.principal_point_px();
    let [k1, k2, p1, p2, k3] = truth.distortion().coefficients()[..] else { panic!("five coefficients") };
    let of = |lens: &Lens| {
        let ([a, b], [c, d], k) = (lens.focal_px(), lens.principal_point_px(), lens.distortion().coefficients());
        [a, b, c, d, k[0], k[1], k[2], k[3], k[4]]
    };
    for (i, (found, true_value)) in of(&fit.lens).iter().zip([fx, fy, cx, cy, k1, k2, p1, p2, k3]).enumerate() {
        let off = (found - true_value) / fit.sds[i];
        // A limit of four standard deviations allows for sampling error in nine parameters.
        assert!(off.abs() < 4.0, "{}: {found} for {true_value}, {off} sigma", LENS_PARAMETERS[i]);
    }
    assert!((fit.lens.focal_px()[0] / fx - 1.0).abs() < 1e-3);
}

/// One image without slant determines the distortion but not the focal length; `is_shown` marks the parameters that are determined. Light dots are
/// found as well as dark dots.
#[test]
fn one_image_gives_what_it_shows() {
    let plate = GridPlate { greys: [60, 220], counts: [20, 18], ..PLATE };
    let camera = before_the_grid(1, 0.0);
    let grid = grid_of(&camera, &plate, 1).expect("a grid");
    let (fit, _) = lens_of_grids([1600, 1400], plate.pitch_mm, std::slice::from_ref(&grid)).expect("a lens");
    assert!(fit.residual_sd_px < 0.05, "{}", fit.residual_sd_px);
    let shown =
        |name: &str| fit.is_shown[LENS_PARAMETERS.iter().position(|other| *other == name).expect("a parameter")];
    assert!(!shown("fx") && shown("k1"), "{:?} {:?}", fit.is_shown, fit.lens);
    // The fitted camera nevertheless maps each dot to its correct position in the plane: column and row of the dot, times the pitch.
    let found = Camera { lens: fit.lens, pose: fit.poses[0] };
    for dot in &grid.dots {
        let position = Vector::new(f64::from(dot.index[0]), f64::from(dot.index[1])) * plate.pitch_mm;
        let seen = found.on_plane(&dot.pixel, 0.0).expect("the plane");
        assert!((seen - position).norm() < 0.05, "{position} {seen}");
    }
}

/// Randomly scattered discs contain small lattices, but no lens maps a plane grid to these lattices.
#[test]
fn strewn_discs_are_no_grid() {
    const SIZE_PX: [u32; 2] = [1600, 1400];
    let (images, mut refused) = (repetitions(4, 8), 0);
    for seed in 0..images {
        let mut chance = random_stream(31, seed);
        let mut centres: Vec<Vector> = Vec::new();
        for _ in 0..6000 {
            let centre = Vector::new(chance.random_range(15.0..1585.0), chance.random_range(15.0..1385.0));
            if centres.iter().all(|other| (other - centre).norm() > 30.0) {
                centres.push(centre);
            }
        }
        let mut image = image::RgbImage::from_pixel(SIZE_PX[0], SIZE_PX[1], image::Rgb([210; 3]));
        for centre in &centres {
            let around = |middle: f64| (middle as u32 - 12)..=(middle as u32 + 12);
            for (u, v) in around(centre.y).flat_map(|v| around(centre.x).map(move |u| (u, v))) {
                if (Vector::new(f64::from(u), f64::from(v)) - centre).norm() < 11.0 {
                    image.put_pixel(u, v, image::Rgb([50; 3]));
                }
            }
        }
        let Ok(grid) = find_grid(&image) else { continue };
        let lens = lens_of_grids(SIZE_PX, 5.0, &[grid]);
        assert!(matches!(lens, Err(LensOfGridsError::Uneven { image: 1, .. })), "seed {seed}: {lens:?}");
        refused += 1;
    }
    assert!(8 * refused >= 3 * images, "only {refused} of {images} images hold something like a grid");
}

#[test]
fn images_without_a_grid_are_refused() {
    let black = image::RgbImage::new(640, 480);
    assert_eq!(find_grid(&black), Err(NoGrid { found: 0 }));
    let mut chance = ChaCha8Rng::seed_from_u64(4);
    let noise = image::RgbImage::from_fn(640, 480, |_, _| image::Rgb([chance.random_range(0.0..256.0) as u8; 3]));
    assert!(find_grid(&noise).is_err());
    let few = GridPlate { counts: [3, 3], ..PLATE };
    assert!(matches!(grid_of(&before_the_grid(1, 0.2), &few, 1), Err(NoGrid { found: 1..=9 })));
    assert!(find_grid(&image::RgbImage::new(1, 1)).is_err());
}
