//! Clutter in the background of a rendered image: discs and boxes that lie behind the finger.

use super::disc::paint_disc;
use super::{BRIGHT, DARK, mix};
use finray_model::NodeId;
use finray_model::camera::{Camera, Pixel};
use finray_model::scene::{MarkerLook, Markers, Rgb};
use image::Rgb32FImage;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Range of the random size of a piece of clutter, in marker radii: the radius of a disc, or half the side of a box.
const SIZES: [f64; 2] = [0.5, 2.5];
/// Least gap, in marker radii, between the centre of any marker and a piece of clutter. Half the diagonal of the square around the piece counts as
/// its radius.
const CLEAR: f64 = 3.0;
/// Painting of clutter stops after this number of successive random positions that are all too close to a marker.
const MOST_DRAWS: usize = 1000;
/// Largest random change of each colour channel of a piece of clutter from its nominal colour, grey levels.
const OTHER_SHADE: f64 = 30.0;
/// Nominal colours of those pieces of clutter that do not have a marker's colour.
const GREYS: [Rgb; 2] = [[120, 110, 100], [220, 220, 225]];

/// Paints up to `count` pieces of clutter that touch no marker; fewer if there is no space.
pub(super) fn scatter(
    canvas: &mut Rgb32FImage,
    camera: &Camera,
    markers: &Markers,
    pixels: &[(NodeId, Pixel)],
    count: usize,
    chance: &mut ChaCha8Rng,
) {
    let [width, height] = camera.lens.size_px().map(f64::from);
    let [first, second] = match markers.look {
        MarkerLook::Coloured { front_rgb, back_rgb } => [front_rgb, back_rgb],
        MarkerLook::Grey { .. } => [BRIGHT, DARK],
    };
    let colours = [first, second, GREYS[0], GREYS[1]];
    for number in 0..count {
        let size_mm = markers.radius_mm * chance.random_range(SIZES[0]..SIZES[1]);
        let shade = [(); 3].map(|()| chance.random_range(-OTHER_SHADE..OTHER_SHADE));
        let colour = colours[number % colours.len()];
        let colour = [0, 1, 2].map(|i| (f64::from(colour[i]) + shade[i]).clamp(0.0, 255.0) as f32);
        let clear = |at: &Pixel| {
            let Ok(sd) = camera.position_sd_mm(at, markers.height_mm, 1.0) else { return false };
            let room = (size_mm * std::f64::consts::SQRT_2 + CLEAR * markers.radius_mm) / sd;
            pixels.iter().all(|(_, marker)| (marker - at).norm() > room)
        };
        let mut draw = || Pixel::new(chance.random_range(0.0..width), chance.random_range(0.0..height));
        let Some(at) = (0..MOST_DRAWS).map(|_| draw()).find(clear) else { return };
        let Ok((centre, by_pixel)) = camera.on_plane_with_derivatives(&at, markers.height_mm) else { continue };
        if number % 3 == 2 {
            let half = size_mm / by_pixel.norm() * std::f64::consts::SQRT_2;
            paint_box(canvas, &at, half, colour);
        } else {
            paint_disc(canvas, camera, (centre, markers.height_mm), size_mm, colour);
        }
    }
}

/// Paints a box that consists of whole pixels. `half` is half the side of the box, px.
fn paint_box(canvas: &mut Rgb32FImage, at: &Pixel, half: f64, colour: [f32; 3]) {
    let (width, height) = canvas.dimensions();
    let side = |middle: f64, size: u32| {
        let from = (middle - half).max(0.0) as u32;
        from..((middle + half).max(0.0) as u32).min(size)
    };
    for v in side(at.y, height) {
        for u in side(at.x, width) {
            mix(&mut canvas.get_pixel_mut(u, v).0, colour, 1.0);
        }
    }
}
