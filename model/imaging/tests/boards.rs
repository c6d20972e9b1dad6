//! Tests of the lens fit on chessboards, asymmetric grids and dots of any size. The tests draw the boards pixel by pixel.

use crate::kit::rms;
use finray_imaging::grid::{Grid, GridKind, find_grid, lens_of_grids};
use finray_imaging::lens_fit::{LENS_PARAMETERS, LensFit};
use finray_model::Vector;
use finray_model::camera::{Camera, Distortion, Lens, Pixel, Pose};
use finray_tests::{random_stream, repetitions};
use image::{ImageBuffer, Luma, RgbImage};
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Pattern of a board; lengths are in pitches, and positions are relative to the middle of the board.
#[derive(Debug, Clone, Copy)]
enum Board {
    /// Numbers of squares along x and y.
    Chess([u32; 2]),
    /// Radius of a dot, and numbers of dots along x and y.
    Dots(f64, [u32; 2]),
    /// Same as `Dots`, but the dots of a row are two pitches apart, and every other row is displaced by one pitch.
    Asymmetric(f64, [u32; 2]),
}

impl Board {
    fn is_dark(self, at: Vector) -> bool {
        match self {
            Board::Chess(counts) => {
                let [i, k] = [0, 1].map(|axis| (at[axis] + f64::from(counts[axis]) / 2.0).floor());
                let is_on = |index: f64, count: u32| (0.0..f64::from(count)).contains(&index);
                is_on(i, counts[0]) && is_on(k, counts[1]) && (i + k).rem_euclid(2.0) == 0.0
            }
            Board::Dots(radius, counts) => {
                let [i, k] = [0, 1].map(|axis| {
                    let last = f64::from(counts[axis]) - 1.0;
                    (at[axis] + last / 2.0).round().clamp(0.0, last) - last / 2.0
                });
                (at - Vector::new(i, k)).norm() < radius
            }
            Board::Asymmetric(radius, counts) => {
                let [columns, rows] = counts.map(|count| f64::from(count) - 1.0);
                let row = (at.y + rows / 2.0).round().clamp(0.0, rows);
                let (y, own) = (row - rows / 2.0, row.rem_euclid(2.0) - columns - 0.5);
                let x = ((at.x - own) / 2.0).round().clamp(0.0, columns) * 2.0 + own;
                (at - Vector::new(x, y)).norm() < radius
            }
        }
    }

    /// Half the longer side of the board, in pitches.
    fn half(self) -> f64 {
        match self {
            Board::Chess([a, b]) | Board::Dots(_, [a, b]) => f64::from(a.max(b)) / 2.0,
            Board::Asymmetric(_, [a, b]) => f64::from((2 * a).max(b)) / 2.0,
        }
    }
}

/// Draws the image of a board. `pitch_mm` is the pitch, mm. Each pixel is the mean of 64 points in its area; blur and noise are applied afterwards.
fn draw(board: Board, pitch_mm: f64, camera: &Camera, chance: &mut ChaCha8Rng) -> RgbImage {
    const POINTS: u32 = 8;
    const BLUR_PX: f32 = 0.7;
    const NOISE: f64 = 1.5;
    const LIGHTS: [f64; 2] = [215.0, 35.0];
    let [width, height] = camera.lens.size_px();
    let mut canvas: ImageBuffer<Luma<f32>, Vec<f32>> = ImageBuffer::new(width, height);
    for (u, v, pixel) in canvas.enumerate_pixels_mut() {
        let seen = camera.on_plane_with_derivatives(&Pixel::new(f64::from(u), f64::from(v)), 0.0);
        let Ok((middle, slope)) = seen else { continue };
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        let is_dark = |point: Pixel| board.is_dark((middle + slope * point) / pitch_mm);
        let seen = corners.map(|corner| is_dark(corner.into()));
        if seen == [seen[0]; 4] {
            pixel.0[0] = LIGHTS[usize::from(seen[0])] as f32;
            continue;
        }
        let step = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS) - 0.5;
        let points = (0..POINTS).flat_map(|i| (0..POINTS).map(move |k| Pixel::new(step(i), step(k))));
        let dark = points.filter(|point| is_dark(*point)).count();
        let share = dark as f64 / f64::from(POINTS * POINTS);
        pixel.0[0] = (LIGHTS[0] + share * (LIGHTS[1] - LIGHTS[0])) as f32;
    }
    canvas = imageproc::filter::gaussian_blur_f32(&canvas, BLUR_PX);
    let mut grey = |u: u32, v: u32| {
        let noise = NOISE * Distribution::<f64>::sample(&StandardNormal, chance);
        (f64::from(canvas.get_pixel(u, v).0[0]) + noise + 0.5) as u8
    };
    let mut image = RgbImage::new(width, height);
    for v in 0..height {
        for u in 0..width {
            image.put_pixel(u, v, image::Rgb([grey(u, v); 3]));
        }
    }
    image
}

/// Cameras with one lens and different poses, which show a board at a slant. `half_mm` is half the longer side of the board, mm.
fn cameras(number: u64, half_mm: f64, count: usize) -> Vec<Camera> {
    let mut chance = random_stream(71, number);
    let size_px = [[640, 480], [800, 600], [960, 720]][number as usize % 3];
    let [width, height] = size_px.map(f64::from);
    let focal = width * chance.random_range(0.8..1.5);
    let distortion = Distortion::from_opencv([chance.random_range(-0.25..0.05), 0.03, 0.0004, -0.0005, 0.0]);
    let middle = [width / 2.0 + chance.random_range(-9.0..9.0), height / 2.0 + chance.random_range(-9.0..9.0)];
    let lens = Lens::new(size_px, [focal, focal * 1.002], middle, distortion).expect("a lens");
    let camera = |_| {
        let mut tilt = || chance.random_range(-0.5..0.5);
        let rotation = Rotation3::from_euler_angles(std::f64::consts::PI + tilt(), tilt(), 4.0 * tilt());
        let far_mm = half_mm * focal / (0.5 * width) * chance.random_range(1.0..1.2);
        let off = |chance: &mut ChaCha8Rng| 0.1 * half_mm * chance.random_range(-1.0..1.0);
        let translation_mm = Vector3::new(off(&mut chance), off(&mut chance), far_mm);
        Camera { lens, pose: Pose { rotation, translation_mm } }
    };
    (0..count).map(camera).collect()
}

/// Cameras drawn for a case number, and the grids that are found in the cameras' images of a board.
fn grids(board: Board, pitch_mm: f64, number: u64) -> (Vec<Camera>, Vec<Grid>) {
    const IMAGES: usize = 6;
    let cameras = cameras(number, board.half() * pitch_mm, IMAGES);
    let grid = |(i, camera): (usize, &Camera)| {
        let mut chance = random_stream(72, 100 * number + i as u64);
        find_grid(&draw(board, pitch_mm, camera, &mut chance)).expect("a grid")
    };
    let grids = cameras.par_iter().enumerate().map(grid).collect();
    (cameras, grids)
}

/// Errors of the lens's parameters in standard deviations.
fn sigmas(fit: &LensFit, truth: &Lens) -> Vec<f64> {
    let of = |lens: &Lens| {
        [&lens.focal_px()[..], &lens.principal_point_px()[..], &lens.distortion().coefficients()[..]].concat()
    };
    of(&fit.lens).iter().zip(of(truth)).zip(fit.sds).map(|((found, truth), sd)| (found - truth) / sd).collect()
}

/// Checks three results from images of this board: the grid kind, the lens, and the distance of the board. Lens parameters are checked to four
/// standard deviations.
fn assert_lens(board: Board, kind: GridKind) {
    const PITCH_MM: f64 = 12.0;
    for number in 0..repetitions(1, 6) {
        let (cameras, grids) = grids(board, PITCH_MM, number);
        assert_eq!(Grid::common_kind(&grids), Some(kind), "{board:?}");
        let (fit, _) = lens_of_grids(cameras[0].lens.size_px(), PITCH_MM, &grids).expect("a lens");
        let off = sigmas(&fit, &cameras[0].lens);
        let far = off.iter().zip(LENS_PARAMETERS).find(|(off, _)| off.abs() > 4.0);
        assert!(far.is_none() && rms(&off) < 2.0, "{board:?} {number}: {off:?}");
        // Standard deviations that are too large would cover any error, so they are limited as well.
        assert!(fit.sds[0] < 1e-3 * fit.lens.focal_px()[0] && fit.residual_sd_px < 0.03, "{board:?}: {fit:?}");
        for (found, camera) in fit.poses.iter().zip(&cameras) {
            let [found, truth] = [found, &camera.pose].map(|pose| {
                let normal = pose.rotation * Vector3::z();
                normal.dot(&pose.translation_mm).abs()
            });
            assert!((found / truth - 1.0).abs() < 2e-3, "{board:?} {number}: {found} for {truth} mm");
        }
    }
}

/// The sampled surroundings of a dot once included the rims of its neighbours. For dots with a radius of 0.3 pitches, the focal length was then
/// 600.397 +- 0.057 px instead of 600 px.
#[test]
fn rims_of_big_dots_pull_each_other() {
    for radius in [0.3, 0.4] {
        assert_lens(Board::Dots(radius, [19, 15]), GridKind::Dots);
    }
}

/// Dark squares were once detected as dots, and their diagonal was used as the pitch.
#[test]
fn a_chessboard_is_taken_for_dots() {
    for squares in [[10, 7], [18, 13]] {
        assert_lens(Board::Chess(squares), GridKind::Chessboard);
    }
}

/// Neighbours in an asymmetric grid are diagonal. The distance between diagonal neighbours was once used as the distance between rows.
#[test]
fn an_asymmetric_grid_is_taken_for_a_square_one() {
    for (radius, counts) in [(0.35, [4, 11]), (0.5, [6, 9])] {
        assert_lens(Board::Asymmetric(radius, counts), GridKind::AsymmetricDots);
    }
}
