//! Where round rims of one size may be: every edge votes for the centre of the circle that it would belong to.
//!
//! Across the rim of a bright disc the light falls outwards, so from each pixel of an edge the centre lies one radius away along the light's
//! gradient (of a dark disc against it). Only circles of that radius gather the votes of a whole rim, whatever is inside or around them.
//!
//! Reference: Loy, Zelinsky, Fast radial symmetry for detecting points of interest (IEEE PAMI 2003).

use finray_model::camera::Pixel;
use finray_model::scene::Shade;
use image::{GrayImage, ImageBuffer, Luma};
use imageproc::gradients::{horizontal_sobel, vertical_sobel};

/// Smallest slope of an edge, grey levels a pixel; Sobel's filter gives eight times the slope.
const LEAST_SLOPE: f32 = 5.0;
const SOBEL: f32 = 8.0;
/// Radii for which edges vote, against the expected one: other distances, slants, and rims whose sharpest edge lies beside them.
const RADII: [f64; 2] = [0.85, 1.18];
/// Votes that a rim must gather, as a share of its length in pixels.
const LEAST_SHARE: f32 = 0.5;
/// Centres that are nearer to each other than this, in radii, are one.
const APART: f64 = 0.5;
/// Centres beyond this many, those with most votes first, are left.
const MOST: usize = 200;

type Votes = ImageBuffer<Luma<f32>, Vec<f32>>;

/// What Sobel's filter gives of an image's light along u and along v: eight times its slope, grey levels a pixel.
pub(super) struct Slopes([Slope; 2]);

type Slope = ImageBuffer<Luma<i16>, Vec<i16>>;

impl Slopes {
    pub fn of(grey: &GrayImage) -> Slopes {
        Slopes([horizontal_sobel(grey), vertical_sobel(grey)])
    }
}

/// Centres of rims of about a radius (px), those with most votes first.
pub(super) fn centres(slopes: &Slopes, radius_px: f64, shade: Shade) -> Vec<Pixel> {
    let votes = summed(&cast(slopes, radius_px, shade));
    let (width, height) = votes.dimensions();
    let least = LEAST_SHARE * (std::f64::consts::TAU * radius_px) as f32;
    let at = |u: u32, v: u32| votes.get_pixel(u, v).0[0];
    let mut peaks: Vec<(f32, Pixel)> = Vec::new();
    for v in 1..height.saturating_sub(1) {
        for u in 1..width.saturating_sub(1) {
            let here = at(u, v);
            // Of equal neighbours the last one.
            let is_peak = || {
                let around = (0..9).filter(|k| *k != 4).map(|k| (k, at(u + k % 3 - 1, v + k / 3 - 1)));
                around.into_iter().all(|(k, other)| if k < 4 { here >= other } else { here > other })
            };
            if here >= least && is_peak() {
                peaks.push((here, Pixel::new(f64::from(u), f64::from(v))));
            }
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut centres: Vec<Pixel> = Vec::new();
    for (_, peak) in peaks {
        if centres.len() < MOST && centres.iter().all(|other| (other - peak).norm() > APART * radius_px) {
            centres.push(peak);
        }
    }
    centres
}

/// Votes by pixel.
fn cast(Slopes([along_u, along_v]): &Slopes, radius_px: f64, shade: Shade) -> Votes {
    let (width, height) = along_u.dimensions();
    let mut votes = Votes::new(width, height);
    let towards = match shade {
        Shade::Bright => 1.0,
        Shade::Dark => -1.0,
    };
    let radii = (RADII[0] * radius_px).round() as u32..=(RADII[1] * radius_px).round() as u32;
    for (u, v, slope) in along_u.enumerate_pixels() {
        let slope = [f32::from(slope.0[0]), f32::from(along_v.get_pixel(u, v).0[0])];
        let size = slope[0].hypot(slope[1]);
        if size < LEAST_SLOPE * SOBEL {
            continue;
        }
        for radius in radii.clone() {
            let step = towards * radius as f32 / size;
            let to = [u as f32 + step * slope[0], v as f32 + step * slope[1]].map(f32::round);
            if to[0] >= 0.0 && to[1] >= 0.0 && to[0] < width as f32 && to[1] < height as f32 {
                votes.get_pixel_mut(to[0] as u32, to[1] as u32).0[0] += 1.0;
            }
        }
    }
    votes
}

/// Votes of each pixel with those of its neighbours.
fn summed(votes: &Votes) -> Votes {
    imageproc::filter::separable_filter(votes, &[1.0, 1.0, 1.0], &[1.0, 1.0, 1.0])
}
