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
use std::ops::Deref;

/// An image whose pixels are borrowed: rows from top to bottom without gaps; red, green and blue of each pixel, 8 bits each.
pub type RgbView<'a> = ImageBuffer<Rgb<u8>, &'a [u8]>;

/// A view of the pixels of an image.
fn view_of<C: Deref<Target = [u8]>>(image: &ImageBuffer<Rgb<u8>, C>) -> RgbView<'_> {
    let pixels = image.as_raw().deref();
    RgbView::from_raw(image.width(), image.height(), pixels).expect("the pixels of an image fill its size")
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
