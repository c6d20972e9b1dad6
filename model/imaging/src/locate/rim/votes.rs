//! Candidates for round rims of one size: every edge pixel votes for the centre of the circle to which it may belong.
//!
//! Across the rim of a bright disc, the light decreases outwards. From each edge pixel, the centre of a bright disc lies one radius along the
//! gradient of the light; the centre of a dark disc lies one radius against it. Only circles of the expected radius collect votes along their whole
//! rim, whatever their inside and surroundings look like.
//!
//! Reference: Loy, Zelinsky, Fast radial symmetry for detecting points of interest (IEEE PAMI 2003).

use finray_model::camera::Pixel;
use finray_model::scene::Shade;
use image::{GrayImage, ImageBuffer, Luma};

/// Least slope of the light at a pixel that votes, grey levels/px.
const LEAST_SLOPE: f32 = 5.0;
/// Ratio of the result of Sobel's filter to the slope of the light.
const SOBEL: f32 = 8.0;
/// Range of radii for which edge pixels vote, relative to the expected radius. The range allows for a finger at another distance or slant, and for
/// rims whose sharpest edge lies beside the rim.
const RADII: [f64; 2] = [0.85, 1.18];
/// Least number of votes for a rim, as a share of the rim's circumference in px.
const LEAST_SHARE: f32 = 0.5;
/// Smallest distance between two centres, in radii. If two centres are closer, only the centre with more votes is kept.
const APART: f64 = 0.5;
/// At most this number of centres is considered, those with the most votes first.
const MOST: usize = 200;

type Votes = ImageBuffer<Luma<f32>, Vec<f32>>;

/// Results of the Sobel filter along u and v for the pixels of an image, row by row: eight times the slope of the light in grey levels/px.
///
/// The general filters of imageproc are slower: with them, slopes and sums of votes took half of the time for an image.
pub(super) struct Slopes {
    /// Width of the image, px.
    width: usize,
    /// Eight times the slope of the light at each pixel, along u and along v, grey levels/px; row by row.
    along: Vec<[i16; 2]>,
}

impl Slopes {
    /// Computes the slopes. Outside the image, the border pixels are repeated.
    pub fn of(grey: &GrayImage) -> Slopes {
        let [width, height] = [grey.width() as usize, grey.height() as usize];
        let row = |v: usize| &grey.as_raw()[v * width..(v + 1) * width];
        let mut along = Vec::with_capacity(width * height);
        // For each column: the light smoothed along v, and the change of the light along v. One extra column on each side repeats the border.
        let (mut smoothed, mut changes) = (vec![0_i16; width + 2], vec![0_i16; width + 2]);
        for v in 0..height {
            let rows = row(v.saturating_sub(1)).iter().zip(row(v)).zip(row((v + 1).min(height - 1)));
            for (u, ((above, here), below)) in rows.enumerate() {
                let [above, here, below] = [above, here, below].map(|light| i16::from(*light));
                smoothed[u + 1] = above + 2 * here + below;
                changes[u + 1] = below - above;
            }
            for column in [&mut smoothed, &mut changes] {
                (column[0], column[width + 1]) = (column[1], column[width]);
            }
            let around = smoothed.windows(3).zip(changes.windows(3));
            along.extend(around.map(|(light, change)| [light[2] - light[0], change[0] + 2 * change[1] + change[2]]));
        }
        Slopes { width, along }
    }

    fn height(&self) -> usize {
        self.along.len() / self.width.max(1)
    }
}

/// Centres of rims with a radius of about `radius_px`; those with the most votes come first.
pub(super) fn centres(slopes: &Slopes, radius_px: f64, shade: Shade) -> Vec<Pixel> {
    let votes = summed(&cast(slopes, radius_px, shade));
    let (width, height) = votes.dimensions();
    let least = LEAST_SHARE * (std::f64::consts::TAU * radius_px) as f32;
    let at = |u: u32, v: u32| votes.get_pixel(u, v).0[0];
    let mut peaks: Vec<(f32, Pixel)> = Vec::new();
    for v in 1..height.saturating_sub(1) {
        for u in 1..width.saturating_sub(1) {
            let here = at(u, v);
            // Among neighbours with equal votes, the last pixel counts as the peak.
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

/// Number of votes for each pixel.
fn cast(slopes: &Slopes, radius_px: f64, shade: Shade) -> Votes {
    let [width, height] = [slopes.width, slopes.height()];
    let mut votes = Votes::new(width as u32, height as u32);
    let towards = match shade {
        Shade::Bright => 1.0,
        Shade::Dark => -1.0,
    };
    let radii = (RADII[0] * radius_px).round() as u32..=(RADII[1] * radius_px).round() as u32;
    for (v, row) in slopes.along.chunks(width.max(1)).enumerate() {
        for (u, slope) in row.iter().enumerate() {
            let slope = slope.map(f32::from);
            if slope[0] * slope[0] + slope[1] * slope[1] < (LEAST_SLOPE * SOBEL).powi(2) {
                continue;
            }
            let size = slope[0].hypot(slope[1]);
            for radius in radii.clone() {
                let step = towards * radius as f32 / size;
                let to = [u as f32 + step * slope[0], v as f32 + step * slope[1]].map(f32::round);
                if to[0] >= 0.0 && to[1] >= 0.0 && to[0] < width as f32 && to[1] < height as f32 {
                    votes.get_pixel_mut(to[0] as u32, to[1] as u32).0[0] += 1.0;
                }
            }
        }
    }
    votes
}

/// For each pixel, the sum of the votes for the pixel and its eight neighbours. The sums at the image border are zero, because no rim is assumed to
/// have its centre there.
fn summed(votes: &Votes) -> Votes {
    let [width, height] = [votes.width().max(1) as usize, votes.height() as usize];
    let mut sums = Votes::new(votes.width(), votes.height());
    let mut columns = vec![0.0; width];
    let rows = votes.as_raw().windows(3 * width).step_by(width);
    for (three, sums) in rows.zip(sums.chunks_mut(width).skip(1)).take(height.saturating_sub(2)) {
        for (u, column) in columns.iter_mut().enumerate() {
            *column = three[u] + three[width + u] + three[2 * width + u];
        }
        for (sum, around) in sums[1..].iter_mut().zip(columns.windows(3)) {
            *sum = around.iter().sum();
        }
    }
    sums
}
