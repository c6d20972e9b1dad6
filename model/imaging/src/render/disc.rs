//! Painting of discs in planes parallel to the finger's plane. At the edge of a disc, each pixel is blended in proportion to the area that the disc covers.

use super::mix;
use finray_model::Vector;
use finray_model::camera::{Camera, Pixel};
use image::Rgb32FImage;

/// Number of subpixels along each side of a pixel. With this number, the painted centre of a disc of 12 px radius (75 edge pixels) is accurate to 0.001 px.
const SUBPIXELS: u32 = 32;

/// Paints a disc. The disc's centre is a point of the finger frame (mm), at a height above the finger's plane (mm). Parts of the disc that the camera
/// does not see are omitted.
pub(super) fn paint_disc(
    canvas: &mut Rgb32FImage,
    camera: &Camera,
    (centre, height_mm): (Vector, f64),
    radius_mm: f64,
    colour: [f32; 3],
) {
    let Ok((pixel, by_point)) = camera.project_with_derivatives(&centre.push(height_mm)) else { return };
    // Perspective enlarges the half of the disc that is nearer to the camera. A factor of 1.5 on the disc's radius in px suffices if the radius is at
    // most a third of the disc's distance from the camera.
    let px_a_mm = by_point.fixed_columns::<2>(0).singular_values().max();
    let reach = 1.5 * radius_mm * px_a_mm + 2.0;
    let (width, height) = canvas.dimensions();
    let Some((columns, rows)) = window(&pixel, reach, [width, height]) else { return };
    for v in rows {
        for u in columns.clone() {
            let at = Pixel::new(f64::from(u), f64::from(v));
            let Ok((point, by_pixel)) = camera.on_plane_with_derivatives(&at, height_mm) else { continue };
            let from_centre = point - centre;
            // Upper bound of the length of half a pixel's diagonal in the plane, mm.
            let half = by_pixel.norm();
            let share = match from_centre.norm() {
                far if far >= radius_mm + half => continue,
                near if near <= radius_mm - half => 1.0,
                _ => {
                    let step = |k: u32| (f64::from(k) + 0.5) / f64::from(SUBPIXELS) - 0.5;
                    let inside = (0..SUBPIXELS).flat_map(|i| (0..SUBPIXELS).map(move |j| Pixel::new(step(i), step(j))));
                    let inside = inside.filter(|part| (from_centre + by_pixel * part).norm() <= radius_mm).count();
                    inside as f32 / (SUBPIXELS * SUBPIXELS) as f32
                }
            };
            mix(&mut canvas.get_pixel_mut(u, v).0, colour, share);
        }
    }
}

/// Columns and rows of the image within `reach` px of a pixel; `None` if there are no such columns or no such rows.
fn window(
    pixel: &Pixel,
    reach: f64,
    size: [u32; 2],
) -> Option<(std::ops::RangeInclusive<u32>, std::ops::RangeInclusive<u32>)> {
    let side = |axis: usize| {
        let (from, to) =
            ((pixel[axis] - reach).ceil().max(0.0), (pixel[axis] + reach).floor().min(f64::from(size[axis]) - 1.0));
        (from <= to).then_some(from as u32..=to as u32)
    };
    Some((side(0)?, side(1)?))
}

#[cfg(test)]
#[path = "../../tests/units/disc.rs"]
mod tests;
