//! A plane grid of dots for lens calibration with `finray lens`.

use super::disc::paint_disc;
use super::{Disturbances, developed};
use finray_model::Vector;
use finray_model::camera::Camera;
use image::{ImageBuffer, Rgb32FImage, RgbImage};

/// A grid of dots in the plane z = 0 of the finger frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridPlate {
    /// Distance between neighbouring dots, mm.
    pub pitch_mm: f64,
    /// Radius of each dot, mm.
    pub radius_mm: f64,
    /// Number of dots along x and along y. The grid is centred at the origin.
    pub counts: [u16; 2],
    /// Grey level of the plate and grey level of the dots, 0 to 255 each.
    pub greys: [u8; 2],
}

/// Renders a grid. `is_hidden` returns whether to omit the dot at a given position (mm).
pub fn render_grid(
    camera: &Camera,
    plate: &GridPlate,
    is_hidden: impl Fn(&Vector) -> bool,
    disturbances: Disturbances,
) -> RgbImage {
    let [width, height] = camera.lens.size_px();
    let [ground, dot] = plate.greys.map(f32::from);
    let mut canvas: Rgb32FImage = ImageBuffer::from_pixel(width, height, [ground; 3].into());
    let along = |i: u16, count: u16| (f64::from(i) - f64::from(count - 1) / 2.0) * plate.pitch_mm;
    for i in 0..plate.counts[0] {
        for j in 0..plate.counts[1] {
            let centre = Vector::new(along(i, plate.counts[0]), along(j, plate.counts[1]));
            if !is_hidden(&centre) {
                paint_disc(&mut canvas, camera, (centre, 0.0), plate.radius_mm, [dot; 3]);
            }
        }
    }
    developed(canvas, &disturbances)
}
