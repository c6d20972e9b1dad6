//! Markers that the edge of an object covers in part.

use super::bent;
use crate::kit::{DISTURBED, camera_of, scene};
use finray_imaging::locate::{Locator, RimLocator};
use finray_imaging::render::{Disturbances, RenderRequest, render};
use finray_model::Vector;
use finray_model::camera::Pixel;
use finray_model::scene::{MarkerLook, Markers, Shade};
use finray_tests::{random_stream, repetitions};
use image::RgbImage;
use nalgebra::Vector2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Colours of objects: dark, as the background, as the finger, white, almost as either marker, blue, as either marker.
const COLOURS: [[f64; 3]; 9] = [
    [20.0, 20.0, 22.0],
    [64.0, 68.0, 74.0],
    [186.0, 188.0, 190.0],
    [250.0, 250.0, 250.0],
    [210.0, 170.0, 70.0],
    [180.0, 60.0, 60.0],
    [40.0, 70.0, 160.0],
    [226.0, 186.0, 46.0],
    [198.0, 52.0, 44.0],
];
/// Radius of a marker of the scene, px.
const RADIUS_PX: f64 = 12.0;
/// Markers farther than this from an object are not affected by it, px: radius, band of the edge and surroundings.
const CLEAR_PX: f64 = RADIUS_PX + 8.0;
/// Largest error of a located marker, in stated standard deviations.
const LARGEST_SIGMAS: f64 = 5.0;
/// An object with a straight or round edge in front of the image.
struct Object {
    edge: Pixel,
    inward: Vector2<f64>,
    /// Radius of a round object, px; `None` for a rectangle.
    round: Option<f64>,
    half: Vector2<f64>,
}

impl Object {
    /// An object whose edge passes the pixel `centre` at a random distance, less than a marker's radius.
    fn over(centre: &Pixel, chance: &mut ChaCha8Rng) -> Object {
        let angle = chance.random_range(0.0..std::f64::consts::TAU);
        let inward = Vector2::new(angle.cos(), angle.sin());
        let edge = centre + inward * (RADIUS_PX * chance.random_range(-0.9..0.9));
        let round = chance.random_bool(0.4).then(|| RADIUS_PX * chance.random_range(1.0..6.0));
        let half = Vector2::new(chance.random_range(1.2..3.0), chance.random_range(1.5..4.0)) * RADIUS_PX;
        Object { edge, inward, round, half }
    }

    /// Signed distance of a pixel from the object's edge, px; positive inside. For rectangles, the distance is that from the nearest side.
    fn depth(&self, at: &Pixel) -> f64 {
        match self.round {
            Some(radius) => radius - (at - self.edge - self.inward * radius).norm(),
            None => {
                let from = at - self.edge - self.inward * self.half.x;
                let along = Vector2::new(-self.inward.y, self.inward.x);
                (self.half.x - from.dot(&self.inward).abs()).min(self.half.y - from.dot(&along).abs())
            }
        }
    }

    /// Paints the object with an edge that is blurred as the rest of the image.
    fn paint(&self, image: &mut RgbImage, colour: [f64; 3], chance: &mut ChaCha8Rng) {
        for (u, v, pixel) in image.enumerate_pixels_mut() {
            let depth = self.depth(&Pixel::new(f64::from(u), f64::from(v)));
            if depth > -4.0 {
                // The logistic function differs from the normal distribution of a blur of 0.8 px by at most 1 %.
                let share = 1.0 / (1.0 + (-1.702 * depth / DISTURBED.blur_px).exp());
                for (value, colour) in pixel.0.iter_mut().zip(colour) {
                    let noise = share * DISTURBED.grey_noise * chance.random_range(-1.7..1.7);
                    *value = (f64::from(*value) * (1.0 - share) + colour * share + noise + 0.5) as u8;
                }
            }
        }
    }
}

/// Errors and counts of markers beside objects.
#[derive(Default)]
struct Tally {
    /// Largest coordinate of the error of each located marker that an object covers in part, in stated standard deviations.
    covered: Vec<f64>,
    /// The same of all other markers that were located.
    whole: Vec<f64>,
    /// Markers that an object covers in part and that are left out; markers that no object affects, and those of them that are left out.
    left_out: usize,
    clear: usize,
    lost: usize,
}

/// Locates the markers in `images` images, each with three objects whose edges cover markers.
fn tally(look: MarkerLook, images: u64) -> Tally {
    let scene = scene();
    let markers = Markers { look, ..scene.markers.expect("the fixture has markers") };
    let (finger, camera) = (&scene.finger, &camera_of(&scene));
    let mut tally = Tally::default();
    for number in 0..images {
        let mut chance = random_stream(65, number);
        let Some(shape) = bent(finger, &mut chance) else { continue };
        let disturbances = Disturbances { seed: number, clutter: 0, ..DISTURBED };
        let (references, hidden): (&[_], &[_]) = (&[], &[]);
        let request =
            RenderRequest { references, hidden, disturbances, ..RenderRequest::of(camera, finger, &shape, &markers) };
        let mut image = render(&request).expect("a finger in sight");
        let centres: Vec<(Vector, Pixel)> = shape
            .motions()
            .iter()
            .map(|motion| {
                let at = motion.position + motion.displacement;
                (at, camera.project(&at.push(markers.height_mm)).expect("seen"))
            })
            .collect();
        let objects: Vec<Object> =
            (0..3).map(|_| Object::over(&centres[chance.random_range(0..centres.len())].1, &mut chance)).collect();
        for object in &objects {
            object.paint(&mut image, COLOURS[chance.random_range(0..COLOURS.len())], &mut chance);
        }
        let located = match look {
            MarkerLook::Coloured { .. } => Locator::new(finger, camera, &markers).expect("a locator").locate(&image),
            MarkerLook::Grey { .. } => {
                let locator = RimLocator::new(finger, camera, &markers, None).expect("a locator");
                locator.locate(&image).map(|seen| seen.located)
            }
        };
        let located = located.expect("a finger");
        for (motion, (at, pixel)) in shape.motions().iter().zip(&centres) {
            let depth = objects.iter().map(|object| object.depth(pixel)).fold(f64::NEG_INFINITY, f64::max);
            let (is_covered, is_clear) = (depth > -RADIUS_PX, depth < -CLEAR_PX);
            tally.clear += usize::from(is_clear);
            match located.iter().find(|marker| marker.node == motion.node) {
                None => {
                    tally.left_out += usize::from(is_covered);
                    tally.lost += usize::from(is_clear);
                }
                Some(found) => {
                    let sigmas = (found.position - at).amax() / found.sd_mm;
                    if is_covered { tally.covered.push(sigmas) } else { tally.whole.push(sigmas) }
                }
            }
        }
    }
    tally
}

/// Markers that the edge of an object covers in part are left out, or are as accurate as stated. Errors of those that were located once reached 9.9
/// standard deviations; in images drawn by another program, a third to a half of them were beyond 3.
#[test]
fn half_covered_markers_are_left_out_or_right() {
    let coloured = scene().markers.expect("the fixture has markers").look;
    let grey = MarkerLook::Grey { shade: Shade::Bright, inner_radius_mm: 0.0 };
    for look in [coloured, grey] {
        let Tally { covered, whole, left_out, clear, lost } = tally(look, repetitions(8, 100) as u64);
        let largest = |all: &[f64]| all.iter().fold(0.0_f64, |largest, sigmas| largest.max(*sigmas));
        let beyond = |all: &[f64]| all.iter().filter(|sigmas| **sigmas > 3.0).count();
        assert!(largest(&covered) < LARGEST_SIGMAS && largest(&whole) < LARGEST_SIGMAS, "{covered:?} {whole:?}");
        assert!(beyond(&covered) <= 1 + covered.len() / 20, "{covered:?}");
        // 0.5 % of the larger of two normal errors exceed three standard deviations.
        assert!(beyond(&whole) as f64 <= 1.0 + 0.01 * whole.len() as f64, "{whole:?}");
        assert!(lost as f64 <= 1.0 + 0.01 * clear as f64, "{lost} of {clear} clear markers");
        assert!(left_out > 0 && clear > 80);
    }
}
