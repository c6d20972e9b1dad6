//! Measurement of bright or dark discs and rings in grey images. A mark is measured by its outer rim; a ring also by its inner edge, if that edge is a circle.
//!
//! The inside of a ring (such as a screw's head or a hole) and the surroundings of the ring may have any appearance. The rim is where the light
//! changes most along a ray from the centre. Rays are cast in the plane of the markers, where the rim is a circle, independent of perspective and
//! lens distortion.
//!
//! A strip (a rib or a bracket) that crosses a rim at a slant systematically shifts the edges that rays find, by some hundredths of a pixel. Instead
//! of the rays, the model of a blurred edge (module `disc`) gives the centre; the model is fitted where the background is even. If the edge model
//! does not fit, as for a screw that is lit from one side, the rays give the centre.

mod votes;

use super::disc::{Buffers, Disc, Outline, View};
use crate::RgbRows;
use finray_model::Vector;
use finray_model::camera::{Camera, Pixel};
use finray_model::scene::Shade;
use image::{GrayImage, Pixel as _, Rgb};
use nalgebra::{Complex, Matrix2, Matrix3, Vector3};
use votes::Slopes;

/// Number of rays that are cast from a centre.
const RAYS: usize = 64;
/// Distance between samples along a ray, px.
const STEP_PX: f64 = 0.25;
/// Range in which the edge is searched for along a ray, relative to the expected radius.
const REACH: [f64; 2] = [0.75, 1.3];
/// Length on each side of an edge over which light is averaged, px.
const SIDE_PX: f64 = 1.0;
/// A ray finds the rim only if the light changes by at least this across the edge, grey levels.
const LEAST_CONTRAST: f64 = 8.0;
/// Share of the rays that must find the rim; with fewer, there is no rim.
const LEAST_SHARE: f64 = 0.6;
/// A ray is an outlier if its edge deviates from the circle by more than this number of standard deviations.
const OUTLIER: f64 = 3.0;
/// Lower bound of the standard deviation in the test for outliers, px.
const LEAST_SPREAD_PX: f64 = 0.15;
/// A rim is rejected if its radius deviates from the stated radius by more than this share. The tolerance is wide, because the sharpest edge in the
/// image may lie beside the rim.
const RADIUS_TOLERANCE: f64 = 0.2;
/// A rim is rejected if the standard deviation of the edges about the circle exceeds this share of the radius.
const LARGEST_SPREAD: f64 = 0.1;
/// Two rims are both kept only if their centres are at least this far apart, in radii, because markers do not overlap.
const APART: f64 = 1.8;
/// Number of times that rays are cast, each time from the current centre; also the number of rounds of each circle fit.
const ROUNDS: usize = 4;
/// A circle is first fitted to all rays. Each of this number of further fits uses only the share [`LEAST_SHARE`] of the rays, those closest to the
/// previous circle.
const TRIMMED_ROUNDS: usize = 2;
/// Lower bound of the standard deviation of a centre found by rays, px. For a centre by the edge model, the bound is half of this value.
const LEAST_SD_PX: f64 = 0.01;

/// Weights of brightness and colour. Colour has no weight, because rims are measured in grey.
const BRIGHTNESS_ALONE: [f64; 2] = [1.0, 0.0];

/// A measured rim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rim {
    /// Position of the rim's centre, mm, in the finger frame at the scene's camera pose.
    pub centre: Vector,
    /// Pixel of the rim's centre.
    pub pixel: Pixel,
    /// Radius of the rim, mm.
    pub radius_mm: f64,
    /// Standard deviation of one coordinate of the centre, mm.
    pub sd_mm: f64,
    /// Standard deviation of one coordinate of the centre as found by rays, mm. A rim that is less round has a larger value.
    pub rays_sd_mm: f64,
    /// Share of the rays that do not find the rim, 0..1.
    pub missed: f64,
    /// Centre of the outer rim alone, mm.
    outer: Vector,
    /// Standard deviation of one coordinate of `outer`, mm.
    pub outer_sd_mm: f64,
    /// The outer rim by the edge model; `None` for a rim found by rays.
    pub disc: Option<Disc>,
    /// Centre of a ring's inner edge, mm, and its variance, mm^2.
    inner: Option<(Vector, f64)>,
}

impl Rim {
    /// Standard deviation of one coordinate of the centre, mm. For a centre found by the edge model, the value is multiplied by `wider`.
    pub fn widened_sd_mm(&self, wider: f64) -> f64 {
        if self.disc.is_some() { self.sd_mm * wider } else { self.sd_mm }
    }

    /// Measures the centre of the outer rim again, with the outline that all rims of an image share. `None` if the edge model found the rim, but does not
    /// fit with that outline. The standard deviation is at least that with an unknown outline: where only one side of a rim has an even background, an
    /// error of the outline moves the centre.
    pub fn with_outline(
        self,
        view: &GreyView,
        shape: &RimShape,
        outline: Outline,
        buffers: &mut Buffers,
    ) -> Option<Rim> {
        let Some(disc) = self.disc else { return Some(self) };
        let disc = edge_view(view, shape).measure_centre(outline, &disc.pixel, buffers)?;
        Some(Rim { outer: disc.centre, outer_sd_mm: disc.sd_mm.max(self.outer_sd_mm), disc: Some(disc), ..self })
    }

    /// The rim with the weighted mean of the outer and the inner edge as its centre. `outer_sd_mm` is the standard deviation of the outer centre, mm, and
    /// `wider` the factor on that of the inner one. If these centres contradict each other, the variance of the outer one is raised until they agree.
    pub fn combined(self, view: &GreyView, shape: &RimShape, outer_sd_mm: f64, wider: f64) -> Option<Rim> {
        let (centre, sd_mm) = match self.inner.filter(|_| outer_sd_mm.is_finite()) {
            None => (self.outer, outer_sd_mm),
            Some((inner, inner_variance)) => {
                let (away, inner_variance) = (inner - self.outer, inner_variance * wider * wider);
                let outer_variance = (outer_sd_mm * outer_sd_mm).max(away.norm_squared() / 2.0 - inner_variance);
                let share = outer_variance / (outer_variance + inner_variance);
                (self.outer + away * share, (share * inner_variance).sqrt())
            }
        };
        let pixel = view.camera.project(&centre.push(shape.height_mm)).ok()?;
        Some(Rim { centre, pixel, sd_mm, ..self })
    }
}

/// Shape of the rims that are searched for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RimShape {
    /// Outer radius, mm.
    pub radius_mm: f64,
    /// Inner radius, mm; 0 for a disc. Inside this radius, the mark may have any appearance.
    pub inner_radius_mm: f64,
    /// Whether the mark is brighter or darker than its surroundings.
    pub shade: Shade,
    /// Height of the rims above the finger's plane, mm.
    pub height_mm: f64,
}

/// A grey image with its camera and the slopes of the brightness at its pixels.
pub(super) struct GreyView<'a> {
    camera: &'a Camera,
    image: &'a dyn RgbRows,
    grey: GrayImage,
    slopes: Slopes,
}

impl<'a> GreyView<'a> {
    pub fn new(camera: &'a Camera, image: &'a dyn RgbRows) -> GreyView<'a> {
        let grey = grey_of(image);
        GreyView { camera, image, slopes: Slopes::of(&grey), grey }
    }
}

/// Brightness of the pixels of an image.
fn grey_of(image: &dyn RgbRows) -> GrayImage {
    let [width, height] = image.size_px();
    let mut grey = GrayImage::new(width, height);
    let mut buffer = Vec::new();
    for (row, lights) in grey.rows_mut().enumerate() {
        let pixels = image.row(row, 0..width as usize, &mut buffer).chunks_exact(3);
        lights.zip(pixels).for_each(|(light, pixel)| *light = Rgb([pixel[0], pixel[1], pixel[2]]).to_luma());
    }
    grey
}

/// Rims of a given shape that do not overlap, in descending order of the votes for their centres. `radius_px` is the approximate radius of the rims
/// in the image, px.
pub(super) fn rims(view: &GreyView, shape: &RimShape, radius_px: f64) -> Vec<Rim> {
    let centres = votes::centres(&view.slopes, radius_px, shape.shade);
    let mut buffers = Buffers::default();
    let mut found: Vec<Rim> = Vec::new();
    for rim in centres.iter().filter_map(|centre| measured(view, shape, centre, &mut buffers)) {
        if found.iter().all(|other| (other.centre - rim.centre).norm() > APART * shape.radius_mm) {
            found.push(rim);
        }
    }
    found
}

/// Distance from the centre to the edge that each ray finds, mm; `None` for a ray that finds no edge.
type Edges = [Option<f64>; RAYS];

fn direction(ray: usize) -> Vector {
    let (sine, cosine) = (std::f64::consts::TAU * ray as f64 / RAYS as f64).sin_cos();
    Vector::new(cosine, sine)
}

/// Measures the rim about a pixel. Returns `None` if no rim is there.
fn measured(view: &GreyView, shape: &RimShape, about: &Pixel, buffers: &mut Buffers) -> Option<Rim> {
    let (circle, mm_a_px) = circle(view, shape, view.camera.on_plane(about, shape.height_mm).ok()?)?;
    let pixel = view.camera.project(&circle.centre.push(shape.height_mm)).ok()?;
    let sd_mm = circle.sd_mm.max(LEAST_SD_PX * mm_a_px);
    let Circle { centre, radius_mm, .. } = circle;
    // If the edge model does not fit, the rays give the centre.
    let disc = edge_view(view, shape).measure(radius_mm, &pixel, buffers);
    let (outer, outer_sd_mm) = disc.map_or((centre, sd_mm), |disc| (disc.centre, disc.sd_mm));
    let radius_mm = disc.map_or(radius_mm, |disc| disc.outline.radius_mm);
    let missed = 1.0 - circle.share;
    let inner = inner_edge(view, shape, outer);
    Rim { centre, pixel, radius_mm, sd_mm, rays_sd_mm: sd_mm, missed, outer, outer_sd_mm, disc, inner }
        .combined(view, shape, outer_sd_mm, 1.0)
}

/// Returns the circle (mm, in the finger frame at the scene's camera pose) through the edges that rays from near `centre` find. Also returns the
/// length of one px at the circle, mm. `None` if there is no rim.
fn circle(view: &GreyView, shape: &RimShape, mut centre: Vector) -> Option<(Circle, f64)> {
    let camera = view.camera;
    let mut last = None;
    for _ in 0..ROUNDS {
        let (_, by_pixel) = camera
            .on_plane_with_derivatives(&camera.project(&centre.push(shape.height_mm)).ok()?, shape.height_mm)
            .ok()?;
        let mm_a_px = by_pixel.determinant().abs().sqrt();
        let edges = edges(&view.grey, camera, shape, &centre, mm_a_px);
        let circle = Circle::through(&edges, LEAST_SPREAD_PX * mm_a_px)?;
        if circle.centre.norm() > shape.radius_mm {
            return None;
        }
        centre += circle.centre;
        last = Some((Circle { centre, ..circle }, mm_a_px));
    }
    let is_rim = |(circle, _): &(Circle, f64)| {
        let off = (circle.radius_mm / shape.radius_mm - 1.0).abs();
        circle.share >= LEAST_SHARE && off <= RADIUS_TOLERANCE && circle.spread_mm <= LARGEST_SPREAD * shape.radius_mm
    };
    last.filter(is_rim)
}

/// Centre of the inner edge of a ring, mm, and its variance, mm^2. `None` for a disc, or if the inner edge is not a circle. Strips behind a ring shift its
/// outer edge but not its inner edge.
fn inner_edge(view: &GreyView, shape: &RimShape, about: Vector) -> Option<(Vector, f64)> {
    let shade = match shape.shade {
        Shade::Bright => Shade::Dark,
        Shade::Dark => Shade::Bright,
    };
    let inner = RimShape { radius_mm: shape.inner_radius_mm, inner_radius_mm: 0.0, shade, ..*shape };
    if inner.radius_mm <= 0.0 {
        return None;
    }
    let (circle, mm_a_px) = circle(view, &inner, about)?;
    Some((circle.centre, circle.sd_mm.max(LEAST_SD_PX * mm_a_px).powi(2)))
}

/// The image with the settings for the model of a blurred edge.
fn edge_view<'a>(view: &'a GreyView, shape: &RimShape) -> View<'a> {
    View {
        image: view.image,
        camera: view.camera,
        height_mm: shape.height_mm,
        grey_inner_mm: Some(shape.inner_radius_mm),
        weights: BRIGHTNESS_ALONE,
        colour_shift_px: Vector::zeros(),
    }
}

/// Finds the position of the largest change of light along each ray.
fn edges(grey: &GrayImage, camera: &Camera, shape: &RimShape, centre: &Vector, mm_a_px: f64) -> Edges {
    let [nearest, farthest] = REACH.map(|share| share * shape.radius_mm);
    let side_mm = SIDE_PX * mm_a_px;
    // Samples start outside the inner radius of a ring, because its inside may have any appearance.
    let from = (nearest - side_mm).max(shape.inner_radius_mm);
    let step = STEP_PX * mm_a_px;
    let count = ((farthest + side_mm - from) / step).ceil() as usize + 1;
    let side = (SIDE_PX / STEP_PX).round() as usize;
    let sign = match shape.shade {
        Shade::Bright => 1.0,
        Shade::Dark => -1.0,
    };
    let mut light = Vec::with_capacity(count);
    std::array::from_fn(|ray| {
        let along = direction(ray);
        light.clear();
        for k in 0..count {
            let at = centre + along * (from + k as f64 * step);
            light.push(sign * crate::light(grey, &camera.project(&at.push(shape.height_mm)).ok()?)?);
        }
        // Decrease of the light from the inner to the outer side of sample k.
        let fall = |k: usize| {
            let inside: f64 = light[k.saturating_sub(side)..k].iter().sum::<f64>() / k.min(side) as f64;
            let outside: f64 =
                light[k + 1..(k + 1 + side).min(count)].iter().sum::<f64>() / side.min(count - 1 - k) as f64;
            inside - outside
        };
        let first = ((nearest.max(from) - from) / step).ceil().max(1.0) as usize;
        let last = (((farthest - from) / step).floor() as usize).min(count - 2);
        let best = (first..=last).max_by(|&a, &b| fall(a).total_cmp(&fall(b)))?;
        if fall(best) < LEAST_CONTRAST || best == first || best == last {
            return None;
        }
        // The edge is the vertex of the parabola through the largest decrease and its two neighbours.
        let [before, here, after] = [best - 1, best, best + 1].map(fall);
        let bend = before - 2.0 * here + after;
        let shift = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        Some(from + (best as f64 + shift) * step)
    })
}

/// A circle through the edges that rays found.
#[derive(Debug, Clone, Copy)]
struct Circle {
    /// Centre of the circle, mm, relative to the origin of the rays; in the result of the function `circle`, relative to the origin of the finger
    /// frame.
    centre: Vector,
    /// Radius of the circle, mm.
    radius_mm: f64,
    /// Share of the rays to which the circle is fitted.
    share: f64,
    /// Standard deviation of the edges about the circle, mm.
    spread_mm: f64,
    /// Standard deviation of one coordinate of the circle's centre, mm.
    sd_mm: f64,
}

impl Circle {
    /// Fits a circle by least squares and omits outliers. The fit is of first order in the offset of the circle's centre from the origin of the rays.
    ///
    /// A plate beside a rim affects a quarter of the rays. The rays that a plate beside the rim affects shift the circle so far that half of the
    /// other rays become outliers. The first fit uses all rays. The next fits use only the required share of the rays, those closest to the circle
    /// (least trimmed squares: Rousseeuw, Van Driessen, Data Mining and Knowledge Discovery 12, 2006). Later fits omit outliers.
    fn through(edges: &Edges, least_spread_mm: f64) -> Option<Circle> {
        let mut counts: [bool; RAYS] = std::array::from_fn(|ray| edges[ray].is_some());
        let mut circle = None;
        for round in 0..ROUNDS {
            let met: Vec<(usize, f64)> =
                (0..RAYS).filter(|ray| counts[*ray]).filter_map(|ray| Some((ray, edges[ray]?))).collect();
            if met.len() < RAYS / 3 {
                return None;
            }
            let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for &(ray, distance) in &met {
                let along = direction(ray);
                let row = Vector3::new(along.x, along.y, 1.0);
                normal += row * row.transpose();
                right += row * distance;
            }
            let inverse = normal.try_inverse()?;
            let found = inverse * right;
            let off = |ray: usize, distance: f64| distance - direction(ray).dot(&found.xy()) - found.z;
            let squares: f64 = met.iter().map(|&(ray, distance)| off(ray, distance).powi(2)).sum();
            let spread_mm = (squares / (met.len() - 3) as f64).sqrt();
            let mut sizes: Vec<f64> = (0..RAYS).filter_map(|ray| Some(off(ray, edges[ray]?).abs())).collect();
            let mut nearest = |share: f64| {
                let last = ((share * sizes.len() as f64) as usize).min(sizes.len() - 1);
                *sizes.select_nth_unstable_by(last, f64::total_cmp).1
            };
            let limit = match round < TRIMMED_ROUNDS {
                true => nearest(LEAST_SHARE),
                false => OUTLIER * (1.5 * nearest(0.5)).max(least_spread_mm),
            };
            let residuals: [f64; RAYS] = std::array::from_fn(|ray| {
                edges[ray].filter(|_| counts[ray]).map_or(0.0, |distance| off(ray, distance))
            });
            circle = Some(Circle {
                centre: found.xy(),
                radius_mm: found.z,
                share: met.len() as f64 / RAYS as f64,
                spread_mm,
                sd_mm: centre_sd_mm(&residuals, &inverse.fixed_view::<2, 2>(0, 0).into_owned()),
            });
            counts = std::array::from_fn(|ray| edges[ray].is_some_and(|distance| off(ray, distance).abs() <= limit));
        }
        circle
    }
}

/// Standard deviation of one coordinate of the centre, mm. Errors of neighbouring rays are correlated. The fitted centre absorbs errors with one
/// period around the rim, so the residuals do not show these errors. Their power is estimated from the residuals with two to four periods.
fn centre_sd_mm(residuals: &[f64; RAYS], inverse: &Matrix2<f64>) -> f64 {
    let power = |periods: usize| {
        let turn = |ray: usize| Complex::cis(std::f64::consts::TAU * (periods * ray) as f64 / RAYS as f64);
        residuals.iter().enumerate().map(|(ray, off)| turn(ray) * *off).sum::<Complex<f64>>().norm_sqr() / RAYS as f64
    };
    // For independent errors, the mean power equals the variance of an error.
    let variance = (power(2) + power(3) + power(4)) / 3.0;
    (variance * inverse.trace() / 2.0).sqrt()
}
