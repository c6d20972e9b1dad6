//! Rendering of the image that a camera takes of a deformed finger, with known true centres of the markers.
//!
//! Plates and ribs are painted as strips along curves. Each curve has the shape of a beam with given positions and rotations of its two ends and no
//! load between them. Markers are discs parallel to the finger's plane; their edge pixels are blended in proportion to the area that the disc covers.
//! Light falloff, blur and noise are applied last, in this order.

mod clutter;
mod disc;
mod grid;
mod outline;

pub use grid::{GridPlate, render_grid};

use disc::paint_disc;
use finray_model::camera::{Camera, Pixel};
use finray_model::mesh::FingerShape;
use finray_model::scene::{MarkerLook, Markers, Reference, Rgb, Shade, marker_offset};
use finray_model::{Finger, NodeId, Vector};
use image::{ImageBuffer, Rgb32FImage, RgbImage};
use nalgebra::Rotation2;
use outline::finger_mask;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Colour of the background, which is dark.
const BACKGROUND: Rgb = [64, 68, 74];
/// Colour of the finger's body, which is light.
const BODY: Rgb = [186, 188, 190];
/// Colour of bright grey markers.
const BRIGHT: Rgb = [250, 250, 248];
/// Colour of dark grey markers.
const DARK: Rgb = [22, 24, 26];

/// Contents of an image to render, and its disturbances.
#[derive(Debug, Clone, Copy)]
pub struct RenderRequest<'a> {
    /// The camera with the pose of the finger frame.
    pub camera: &'a Camera,
    /// The finger to render.
    pub finger: &'a Finger,
    /// Motions of the finger's key nodes.
    pub shape: &'a FingerShape,
    /// Appearance and size of the finger's markers.
    pub markers: &'a Markers,
    /// Markers relative to their nodes, as in [`Scene::marker_offsets`](finray_model::Scene::marker_offsets).
    pub offsets: &'a [Vector],
    /// Reference marks on the finger's base.
    pub references: &'a [Reference],
    /// Nodes whose markers are not painted.
    pub hidden: &'a [NodeId],
    /// Disturbances of the image.
    pub disturbances: Disturbances,
}

impl<'a> RenderRequest<'a> {
    /// A finger with all markers, centred on their nodes, without reference marks, in an undisturbed image.
    pub fn of(camera: &'a Camera, finger: &'a Finger, shape: &'a FingerShape, markers: &'a Markers) -> Self {
        let disturbances = Disturbances::default();
        RenderRequest { camera, finger, shape, markers, offsets: &[], references: &[], hidden: &[], disturbances }
    }
}

/// Disturbances of a rendered image.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Disturbances {
    /// Share of the light that is lost in the corners of the image, 0..1. The loss grows with the square of the distance from the image's centre.
    pub light_falloff: f64,
    /// Standard deviation of a Gaussian blur of the image, px.
    pub blur_px: f64,
    /// Standard deviation of the noise that is added to every channel of every pixel, grey levels (of 255).
    pub grey_noise: f64,
    /// Number of discs and boxes in the background; fewer are painted if there is no space. Half of the pieces of clutter have the colours of the
    /// markers.
    pub clutter: usize,
    /// Seed of the random numbers for noise and clutter.
    pub seed: u64,
}

/// Error for a camera that does not see the finger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// A key node cannot be projected to a pixel of the camera.
    #[error("the camera does not see the finger: node {node} {reason}")]
    NotSeen {
        /// The key node without a pixel.
        node: NodeId,
        /// Reason why the node has no pixel.
        reason: finray_model::camera::ViewError,
    },
    /// All key nodes are outside the image.
    #[error("the camera does not see the finger: all nodes of the finger are outside the image")]
    Outside,
}

/// Pixels of the true marker positions at all key nodes, each with its node. `height_mm` is the height of the markers above the finger's plane, mm.
fn marker_pixels(
    camera: &Camera,
    finger: &Finger,
    shape: &FingerShape,
    height_mm: f64,
) -> Result<Vec<(NodeId, Pixel)>, RenderError> {
    let seen = shape.motions().iter().map(|motion| {
        let at = (finger.marker_position(motion.node) + motion.marker_displacement(finger)).push(height_mm);
        let pixel = camera.project(&at).map_err(|reason| RenderError::NotSeen { node: motion.node, reason })?;
        Ok((motion.node, pixel))
    });
    let seen = seen.collect::<Result<Vec<_>, _>>()?;
    if seen.iter().any(|(_, pixel)| camera.lens.contains(pixel)) { Ok(seen) } else { Err(RenderError::Outside) }
}

/// Renders the image of a finger.
///
/// # Errors
/// [`RenderError`] if the camera does not see the finger.
pub fn render(request: &RenderRequest) -> Result<RgbImage, RenderError> {
    let &RenderRequest { camera, finger, shape, markers, offsets, references, hidden, disturbances } = request;
    let pixels = marker_pixels(camera, finger, shape, markers.height_mm)?;
    let [width, height] = camera.lens.size_px();
    let mut canvas: Rgb32FImage = ImageBuffer::from_pixel(width, height, BACKGROUND.map(f32::from).into());
    let mut chance = chance(disturbances.seed, 1);
    clutter::scatter(&mut canvas, camera, markers, &pixels, disturbances.clutter, &mut chance);
    if let Some(mask) = finger_mask(camera, finger, shape) {
        let body = BODY.map(f32::from);
        for (pixel, &covered) in canvas.pixels_mut().zip(mask.data()) {
            mix(&mut pixel.0, body, f32::from(covered) / 255.0);
        }
    }
    let on_front = finger.plate_nodes(finray_model::finger::Plate::Front);
    let is_seen = |node: NodeId| finger.has_marker(node) && !hidden.contains(&node);
    for motion in shape.motions().iter().filter(|motion| is_seen(motion.node)) {
        let offset = Rotation2::new(motion.rotation) * marker_offset(offsets, motion.node);
        let centre = finger.marker_position(motion.node) + motion.marker_displacement(finger) + offset;
        paint_marker(&mut canvas, camera, markers, centre, on_front.contains(&motion.node));
    }
    for reference in references {
        paint_marker(&mut canvas, camera, &reference.markers, reference.at, true);
    }
    Ok(developed(canvas, &disturbances))
}

/// Paints a disc or a ring whose centre is a point of the finger frame, mm.
fn paint_marker(canvas: &mut Rgb32FImage, camera: &Camera, markers: &Markers, centre: Vector, is_front: bool) {
    let at = (centre, markers.height_mm);
    match markers.look {
        MarkerLook::Coloured { front_rgb, back_rgb } => {
            let colour = if is_front { front_rgb } else { back_rgb };
            paint_disc(canvas, camera, at, markers.radius_mm, colour.map(f32::from));
        }
        MarkerLook::Grey { shade, inner_radius_mm } => {
            let [ring, inside] = match shade {
                Shade::Bright => [BRIGHT, DARK],
                Shade::Dark => [DARK, BRIGHT],
            };
            paint_disc(canvas, camera, at, markers.radius_mm, ring.map(f32::from));
            if inner_radius_mm > 0.0 {
                paint_disc(canvas, camera, at, inner_radius_mm, inside.map(f32::from));
            }
        }
    }
}

/// Weights of a Gaussian filter with the standard deviation `sd_px` (px), cut off at four standard deviations. The Gaussian filter of imageproc is
/// cut off at two standard deviations, which makes it too narrow.
fn gaussian(sd_px: f64) -> Vec<f32> {
    let reach = (4.0 * sd_px).ceil() as i32;
    let weight = |step: i32| (-0.5 * (f64::from(step) / sd_px).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(weight).sum();
    (-reach..=reach).map(|step| (weight(step) / sum) as f32).collect()
}

/// Applies light falloff, blur and noise, then rounds to 256 grey levels.
fn developed(mut canvas: Rgb32FImage, disturbances: &Disturbances) -> RgbImage {
    let (width, height) = canvas.dimensions();
    let middle = [f64::from(width - 1) / 2.0, f64::from(height - 1) / 2.0];
    let farthest = (middle[0].powi(2) + middle[1].powi(2)).max(1.0);
    if disturbances.light_falloff > 0.0 {
        for (u, v, pixel) in canvas.enumerate_pixels_mut() {
            let away = (f64::from(u) - middle[0]).powi(2) + (f64::from(v) - middle[1]).powi(2);
            let light = (1.0 - disturbances.light_falloff * away / farthest) as f32;
            pixel.0 = pixel.0.map(|part| part * light);
        }
    }
    if disturbances.blur_px > 0.0 {
        canvas = imageproc::filter::separable_filter_equal(&canvas, &gaussian(disturbances.blur_px));
    }
    let mut chance = chance(disturbances.seed, 0);
    let mut noise = || match disturbances.grey_noise > 0.0 {
        true => disturbances.grey_noise * Distribution::<f64>::sample(&StandardNormal, &mut chance),
        false => 0.0,
    };
    // Adding 0.5 rounds to the nearest grey level; the conversion saturates at 0 and 255.
    let grey = canvas.iter().map(|&part| (f64::from(part) + noise() + 0.5) as u8).collect::<Vec<_>>();
    let mut image = RgbImage::new(width, height);
    image.copy_from_slice(&grey);
    image
}

/// Random number generator for a seed. Different values of `stream` give independent random numbers.
fn chance(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut chance = ChaCha8Rng::seed_from_u64(seed);
    chance.set_stream(stream);
    chance
}

/// Blends a colour into a pixel. `share` is the weight of the colour, 0..1.
fn mix(pixel: &mut [f32; 3], colour: [f32; 3], share: f32) {
    for (part, new) in pixel.iter_mut().zip(colour) {
        *part += share * (new - *part);
    }
}
