//! Candidates for chessboard corners, from the light on a ring about each pixel of an image; the image may be reduced.

use finray_model::camera::Pixel;
use image::GrayImage;

/// Offsets of the ring's pixels from its centre, px: along u, then along v.
const RING: [[i32; 16]; 2] =
    [[5, 5, 3, 2, 0, -2, -3, -5, -5, -5, -3, -2, 0, 2, 3, 5], [0, 2, 3, 5, 5, 5, 3, 2, 0, -2, -3, -5, -5, -5, -3, -2]];
const REACH: u32 = 5;
/// A pixel is a corner only if the light on the ring about it has at least this contrast, grey levels.
pub(super) const LEAST_CONTRAST: f32 = 20.0;
/// A pixel is a corner only if the ratio of the corner detector's response to the contrast is at least this. For a sharp corner, the ratio is about 7.
const LEAST_RESPONSE: f32 = 3.0;
/// Corners are at least this far apart, px.
const APART: u32 = 4;
/// At most this number of corners is considered, in raster order. An image with more corners shows something other than a calibration grid.
const MOST_CORNERS: usize = 6000;

/// A corner: its pixel, and the unit directions of its two edges.
pub(super) struct Corner {
    /// Pixel of the corner.
    pub pixel: Pixel,
    /// Unit direction of each of the two edges, in pixel coordinates.
    pub edges: [Pixel; 2],
}

/// An image that is reduced by an integer factor.
pub(super) struct Shrunk {
    /// Factor by which the image is reduced.
    factor: u32,
    /// Width of the reduced image, px.
    width: u32,
    /// Height of the reduced image, px.
    height: u32,
    /// Light of each pixel of the reduced image, row by row, grey levels.
    light: Vec<f32>,
}

impl Shrunk {
    pub fn new(grey: &GrayImage, factor: u32) -> Shrunk {
        let (width, height) = (grey.width() / factor, grey.height() / factor);
        let mut light = vec![0.0; (width * height) as usize];
        let share = 1.0 / (factor * factor) as f32;
        for (v, row) in grey.rows().take((height * factor) as usize).enumerate() {
            let start = (v as u32 / factor * width) as usize;
            for (u, pixel) in row.take((width * factor) as usize).enumerate() {
                light[start + u / factor as usize] += share * f32::from(pixel.0[0]);
            }
        }
        Shrunk { factor, width, height, light }
    }

    fn ring(&self, at: usize) -> [f32; 16] {
        let offset = |i: usize| i64::from(RING[1][i]) * i64::from(self.width) + i64::from(RING[0][i]);
        std::array::from_fn(|i| self.light[(at as i64 + offset(i)) as usize])
    }

    /// Response of the corner detector at a pixel: the changes of light around the ring, minus the differences between opposite pixels and between ring and
    /// centre.
    fn response(&self, at: usize) -> f32 {
        let ring = self.ring(at);
        let turns: f32 = (0..4).map(|i| (ring[i] + ring[i + 8] - ring[i + 4] - ring[i + 12]).abs()).sum();
        let across: f32 = (0..8).map(|i| (ring[i] - ring[i + 8]).abs()).sum();
        let width = self.width as usize;
        let middle = [at, at - 1, at + 1, at - width, at + width].map(|at| self.light[at]).iter().sum::<f32>() / 5.0;
        turns - across - (16.0 * middle - ring.iter().sum::<f32>()).abs()
    }

    /// The corners of the image, in pixels of the full image, accurate to one pixel of the reduced image.
    pub fn corners(&self) -> Vec<Corner> {
        let (width, height) = (self.width, self.height);
        if width <= 2 * REACH || height <= 2 * REACH {
            return Vec::new();
        }
        let mut response = vec![0.0_f32; self.light.len()];
        let inner = |v: u32| (REACH..width - REACH).map(move |u| (v * width + u) as usize);
        for at in (REACH..height - REACH).flat_map(inner) {
            response[at] = self.response(at);
        }
        let is_peak = |at: &usize| {
            let value = response[*at];
            let (u, v) = (*at as u32 % width, *at as u32 / width);
            value > LEAST_RESPONSE * LEAST_CONTRAST
                && (v.saturating_sub(APART)..=(v + APART).min(height - 1)).all(|row| {
                    let start = row * width;
                    let columns = start + u.saturating_sub(APART)..=start + (u + APART).min(width - 1);
                    columns
                        .map(|other| other as usize)
                        .all(|other| response[other] < value || (response[other] == value && other >= *at))
                })
        };
        let peaks = (REACH..height - REACH).flat_map(inner).filter(is_peak);
        peaks.filter_map(|at| self.corner(at, response[at])).take(MOST_CORNERS).collect()
    }

    /// The corner at a pixel. `None` unless the light changes four times around the pixel.
    fn corner(&self, at: usize, response: f32) -> Option<Corner> {
        let ring = self.ring(at);
        let (least, most) = ring.iter().fold((f32::MAX, f32::MIN), |(a, b), light| (a.min(*light), b.max(*light)));
        if most - least < LEAST_CONTRAST || response < LEAST_RESPONSE * (most - least) {
            return None;
        }
        let above = ring.map(|light| f64::from(light - (least + most) / 2.0));
        let point = |i: usize| Pixel::from(RING.map(|offsets| f64::from(offsets[i])));
        let change = |i: usize| {
            let (from, to) = (above[i], above[(i + 1) % 16]);
            ((from > 0.0) != (to > 0.0)).then(|| (point(i) * to - point((i + 1) % 16) * from) / (to - from))
        };
        let changes: Vec<Pixel> = (0..16).filter_map(change).collect();
        let [a, b, c, d] = changes[..] else { return None };
        let of_pixel = |index: u32| (f64::from(index) + 0.5) * f64::from(self.factor) - 0.5;
        let pixel = Pixel::new(of_pixel(at as u32 % self.width), of_pixel(at as u32 / self.width));
        Some(Corner { pixel, edges: [(a - c).normalize(), (b - d).normalize()] })
    }
}
