//! Painted discs cover as much of each pixel as exact discs.

use super::*;
use finray_model::camera::{Distortion, Lens, Pose};

/// Share of a unit pixel that a disc covers, summed over strips of the pixel. The covered length of each strip is exact.
fn covered(pixel: [f64; 2], centre: &Pixel, radius: f64) -> f64 {
    const STRIPS: u32 = 400;
    let strip = |k: u32| {
        let u = pixel[0] - 0.5 + (f64::from(k) + 0.5) / f64::from(STRIPS) - centre.x;
        let half = (radius * radius - u * u).max(0.0).sqrt();
        let (from, to) = ((pixel[1] - 0.5).max(centre.y - half), (pixel[1] + 0.5).min(centre.y + half));
        (to - from).max(0.0)
    };
    (0..STRIPS).map(strip).sum::<f64>() / f64::from(STRIPS)
}

/// Checks that the light of each pixel equals the share of the pixel that the disc covers, for ten subpixel positions of the disc. Checks that
/// the errors of the pixels' light shift the disc's centre by less than 1e-3 px.
#[test]
fn light_is_that_of_the_disc() {
    let lens = Lens::new([80, 60], [400.0, 400.0], [39.5, 29.5], Distortion::default()).expect("a lens");
    let pose = Pose::new([std::f64::consts::PI, 0.0, 0.0], [0.0, 0.0, 50.0]);
    let camera = Camera { lens, pose };
    for step in 0..10 {
        let centre = Vector::new(0.0123 * f64::from(step), -0.0271 * f64::from(step));
        let mut canvas = Rgb32FImage::new(80, 60);
        paint_disc(&mut canvas, &camera, (centre, 0.0), 1.5, [1.0, 1.0, 1.0]);
        let seen = camera.project(&centre.push(0.0)).expect("seen");
        let (mut area, mut shift) = (0.0, Pixel::zeros());
        for (u, v, pixel) in canvas.enumerate_pixels() {
            let at = [f64::from(u), f64::from(v)];
            let share = f64::from(pixel.0[0]);
            // The scale is 8 px/mm.
            let lacking = share - covered(at, &seen, 12.0);
            assert!(lacking.abs() < 0.02, "{at:?} {share} {lacking}");
            area += share;
            shift += (Pixel::from(at) - seen) * lacking;
        }
        assert!((area / (std::f64::consts::PI * 144.0) - 1.0).abs() < 1e-3, "{area}");
        assert!((shift / area).norm() < 1e-3, "{shift}");
    }
}
