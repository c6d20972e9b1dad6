//! Motion blur: a motion of finger or camera during the exposure makes the blur larger in one direction.
//!
//! The sum of the squared gradients across a blurred edge is proportional to the edge's squared contrast divided by its blur. With isotropic blur, the edges of
//! discs have equal sums in all directions. Only gradients of colour are used, because beams and background have no colour.

use super::disc::Disc;
use crate::RgbRows;
use nalgebra::Matrix2;

/// Ratio of the smaller to the larger sum of squared gradients above which blur counts as isotropic. For discs seen at an angle of 20 degrees, the ratio is
/// 0.94.
const ROUND: f64 = 0.75;
/// Motion blur with a smaller standard deviation than this, px, is not reported. Encoders that halve the resolution of colour only along rows cause up to 0.9
/// px.
const LEAST_PX: f64 = 1.2;
/// Radius of the window about a disc in which gradients are summed, in radii of the disc.
const ROOM: f64 = 1.4;
/// Number of directions over which the gradients of an edge are summed.
const DIRECTIONS: usize = 32;
/// Number of bisection steps for the ratio of the blurs.
const STEPS: usize = 50;
/// Largest standard deviation of motion blur, as a share of a disc's radius. An image with more motion blur is rejected: up to half of the blur would stay
/// undetected, and the errors would exceed the stated standard deviations.
pub(super) const LARGEST_MOTION: f64 = 0.2;
/// Largest ratio of the variance of motion blur to the variance of isotropic blur that is considered.
const MOST: f64 = 1e4;

/// Standard deviation of the motion blur in addition to an isotropic blur, px; `None` for isotropic blur. `blur_px` is the mean standard deviation of the
/// blur, px.
pub(super) fn motion_blur_px<'d>(
    image: &dyn RgbRows,
    discs: impl Iterator<Item = &'d Disc>,
    radius_px: f64,
    blur_px: f64,
) -> Option<f64> {
    let mut buffers = (Vec::new(), Vec::new());
    let all = discs.map(|disc| gradients(image, disc, ROOM * radius_px, &mut buffers)).sum::<Matrix2<f64>>();
    let sums = all.symmetric_eigenvalues();
    let ratio = sums.min() / sums.max();
    if ratio.is_nan() || ratio >= ROUND {
        return None;
    }
    // If the normal of an edge has the angle a to the motion, the variance of the edge's blur is 1 + k cos^2 a times the variance of the isotropic
    // blur. The factor k is the variance of the motion blur divided by the variance of the isotropic blur.
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

/// Sums of products of the colour gradients about a disc: xx, xy and yy as a matrix. The buffers are for pixels of a row and for the colours about the disc.
fn gradients(
    image: &dyn RgbRows,
    disc: &Disc,
    reach: f64,
    (pixels, colours): &mut (Vec<u8>, Vec<[i32; 2]>),
) -> Matrix2<f64> {
    let within = |axis: usize, size: u32| {
        let from = (disc.pixel[axis] - reach).ceil().max(1.0) as usize;
        from..((disc.pixel[axis] + reach).floor().max(0.0) as usize).min(size.saturating_sub(1) as usize)
    };
    let [width, height] = image.size_px();
    let (columns, rows) = (within(0, width), within(1, height));
    let mut sums = Matrix2::zeros();
    if columns.is_empty() || rows.is_empty() {
        return sums;
    }
    // A gradient needs the neighbours of its pixel.
    let across = columns.len() + 2;
    colours.clear();
    for v in rows.start - 1..=rows.end {
        let row = image.row(v, columns.start - 1..columns.end + 1, pixels);
        colours.extend(row.chunks_exact(3).map(|pixel| {
            let [r, g, b] = [pixel[0], pixel[1], pixel[2]].map(i32::from);
            [r - g, g - b]
        }));
    }
    for v in 1..=rows.len() {
        for at in v * across + 1..(v + 1) * across - 1 {
            let (left, right, up, down) =
                (colours[at - 1], colours[at + 1], colours[at - across], colours[at + across]);
            for k in 0..2 {
                let [x, y] = [right[k] - left[k], down[k] - up[k]].map(f64::from);
                sums += Matrix2::new(x * x, x * y, x * y, y * y);
            }
        }
    }
    sums
}
