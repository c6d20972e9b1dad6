//! Images of the finger: rendering ([`render`]), positions of markers in images ([`locate`]), and plane grids for lens calibration ([`grid`]).
//!
//! The crate reads and writes no files: images are in memory, and random numbers come from a given seed. Pixel coordinates are u (to the right) and v
//! (downwards), px; the centre of the top left pixel is (0, 0), as in [`finray_model::camera`].
#![forbid(unsafe_code)]

pub mod grid;
pub mod lens_fit;
pub mod locate;
pub mod plane_pose;
pub mod render;

use image::{ImageBuffer, Rgb};
use std::ops::{Deref, Range};

/// An image whose pixels are borrowed: rows from top to bottom without gaps; red, green and blue of each pixel, 8 bits each.
pub type RgbView<'a> = ImageBuffer<Rgb<u8>, &'a [u8]>;

/// An image whose pixels are read in parts of rows: red, green and blue of each pixel, 8 bits each.
///
/// A locator that tracks markers reads only the pixels about them. An image in another form, such as a frame of a video, converts only the pixels
/// that are read.
pub trait RgbRows {
    /// Width and height, px.
    fn size_px(&self) -> [u32; 2];

    /// Pixels of a row in the given columns, from left to right. `buffer` provides the memory for pixels that must be converted; its old content is
    /// lost.
    ///
    /// # Panics
    /// Panics if row or columns are outside the image.
    fn row<'p>(&'p self, row: usize, columns: Range<usize>, buffer: &'p mut Vec<u8>) -> &'p [u8];
}

impl<C: Deref<Target = [u8]>> RgbRows for ImageBuffer<Rgb<u8>, C> {
    fn size_px(&self) -> [u32; 2] {
        self.dimensions().into()
    }

    fn row<'p>(&'p self, row: usize, columns: Range<usize>, _: &'p mut Vec<u8>) -> &'p [u8] {
        let start = row * self.width() as usize;
        &self.as_raw()[3 * (start + columns.start)..3 * (start + columns.end)]
    }
}

/// Grey level at a position between pixels, by bilinear interpolation; `None` outside the image.
fn light(grey: &image::GrayImage, at: &finray_model::camera::Pixel) -> Option<f64> {
    let (u, v) = (at.x.floor(), at.y.floor());
    let (width, height) = grey.dimensions();
    if !(u >= 0.0 && v >= 0.0 && u + 1.0 < f64::from(width) && v + 1.0 < f64::from(height)) {
        return None;
    }
    let (x, y) = (at.x - u, at.y - v);
    let light = |i: u32, j: u32| f64::from(grey.get_pixel(u as u32 + i, v as u32 + j).0[0]);
    Some((light(0, 0) * (1.0 - x) + light(1, 0) * x) * (1.0 - y) + (light(0, 1) * (1.0 - x) + light(1, 1) * x) * y)
}
