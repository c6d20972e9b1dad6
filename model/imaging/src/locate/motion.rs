//! Blur that is wider in one direction: of a finger or a camera that moved while the shutter was open.
//!
//! The squared gradients of a blurred edge sum up to its contrast squared over its blur, along its normal: where blur is round, the edges of discs
//! have as much of them in each direction. Those of colour are taken, which beams and background do not have.

use super::disc::Disc;
use image::RgbImage;
use nalgebra::Matrix2;

/// Ratio of the gradients' sums along and across from which on blur counts as round: discs seen at 20 degrees have 0.94.
const ROUND: f64 = 0.75;
/// Smallest blur that counts as a motion's, px: encoders that store every other pixel's colour along rows alone blur it by up to 0.9 px.
const LEAST_PX: f64 = 1.2;
/// Room about a disc, as a share of its radius.
const ROOM: f64 = 1.4;
/// Directions of the edge over which its gradients are summed, and steps in which the ratio is solved for.
const DIRECTIONS: usize = 32;
const STEPS: usize = 50;
/// Largest blur of a motion, as a share of a disc's radius: of a larger one up to half is not seen, which no stated standard deviation holds.
pub(super) const LARGEST_MOTION: f64 = 0.2;
/// Largest variance of the motion over that of the round blur.
const MOST: f64 = 1e4;

/// Standard deviation of the blur of a motion, px, beside a round one; `None` where blur is round. `blur_px` is the mean one.
pub(super) fn motion_blur_px<'d>(
    image: &RgbImage,
    discs: impl Iterator<Item = &'d Disc>,
    radius_px: f64,
    blur_px: f64,
) -> Option<f64> {
    let all = discs.map(|disc| gradients(image, disc, ROOM * radius_px)).sum::<Matrix2<f64>>();
    let sums = all.symmetric_eigenvalues();
    let ratio = sums.min() / sums.max();
    if ratio.is_nan() || ratio >= ROUND {
        return None;
    }
    // The edge at an angle to the motion is blurred by 1 + k cos^2, in variances of the round blur.
    let ratio_of = |k: f64| {
        let (along, across) = (0..DIRECTIONS).fold((0.0, 0.0), |(along, across), i| {
            let cosine = (std::f64::consts::TAU * i as f64 / DIRECTIONS as f64).cos().powi(2);
            let sharpness = 1.0 / (1.0 + k * cosine).sqrt();
            (along + cosine * sharpness, across + (1.0 - cosine) * sharpness)
        });
        along / across
    };
    let (mut below, mut above) = (0.0, MOST);
    for _ in 0..STEPS {
        let middle = 0.5 * (below + above);
        if ratio_of(middle) > ratio { below = middle } else { above = middle }
    }
    Some(blur_px * (below / (1.0 + 0.5 * below)).sqrt()).filter(|motion_px| *motion_px > LEAST_PX)
}

/// Sums of products of the gradients of colour about a disc.
fn gradients(image: &RgbImage, disc: &Disc, reach: f64) -> Matrix2<f64> {
    let mut sums = Matrix2::zeros();
    let within = |axis: usize, size: u32| {
        let from = (disc.pixel[axis] - reach).ceil().max(1.0) as u32;
        from..((disc.pixel[axis] + reach).floor().max(0.0) as u32).min(size.saturating_sub(1))
    };
    let colour = |u: u32, v: u32| {
        let [r, g, b] = image.get_pixel(u, v).0.map(i32::from);
        [r - g, g - b]
    };
    for v in within(1, image.height()) {
        for u in within(0, image.width()) {
            let (left, right, up, down) = (colour(u - 1, v), colour(u + 1, v), colour(u, v - 1), colour(u, v + 1));
            for k in 0..2 {
                let [x, y] = [right[k] - left[k], down[k] - up[k]].map(f64::from);
                sums += Matrix2::new(x * x, x * y, x * y, y * y);
            }
        }
    }
    sums
}
