//! The centre of a disc, from the light of the pixels about its edge.
//!
//! A pixel at the distance d outside the disc's edge (px) shows background + (disc - background) Phi(-d / b): the edge, blurred by a
//! Gaussian of standard deviation b, Phi the normal distribution. Brightness and colour have a b each, since compressed images store colour
//! with fewer pixels. The disc's own light falls off evenly over its inside, the background one colour for each sector around it, since plates
//! and ribs cross it. Centre, radius and both b are found by least squares over the pixels of the edge; each counts by the square of its
//! contrast, as noise is the same everywhere. Sectors that do not look like an edge (an occluder, another marker) are left out.
//!
//! Distances are taken in the finger's plane, where the disc is a circle: what perspective and lens do to its image is allowed for.

mod band;
mod plane_map;
mod shades;
mod sums;

use band::{Band, normal_distribution};
use finray_model::Vector;
use finray_model::camera::{Camera, Pixel};
use image::RgbImage;
use nalgebra::{Complex, Matrix2, SMatrix, SVector, Vector2};
use plane_map::{Pixels, PlaneMap};
use shades::{BACKGROUND_PX, KEPT_SECTORS, Shades};
use sums::{SectorSums, Sums};

/// Unknowns of an edge: centre (two), radius, blur of brightness and of colour.
const UNKNOWNS: usize = 5;
/// Parts of the light: brightness and colour.
const PARTS: usize = 2;
/// Standard deviation of the difference of their blurs, px, for noise of two grey levels: holds the one that a marker hardly shows.
const BLURS_APART_PX: f64 = 0.15;
const USUAL_NOISE: f64 = 2.0;
/// Half the width of the band of pixels about the edge, in b.
const BAND: f64 = 2.5;
/// b where the search starts, and its smallest, px. A pixel's own width is a blur of 0.29 px.
const FIRST_BLUR_PX: f64 = 0.9;
const LEAST_BLUR_PX: f64 = 0.25;
/// Largest blur of markers, as a share of their radius: beyond it nothing of a disc shows its own light.
pub(super) const LARGEST_BLUR: f64 = 0.33;
/// Largest deviation of the radius from the expected one, as a share.
const RADIUS_TOLERANCE: f64 = 0.25;
/// Largest residual standard deviation, as a share of the contrast; and that of grey discs, for which there is another way (`rim`). Photographed
/// screws, whose heads shine and whose rims the camera has sharpened, are above it.
const LARGEST_RESIDUAL: f64 = 0.2;
const LARGEST_GREY_RESIDUAL: f64 = 0.07;
/// Room for a centre that is not where the search begins, px.
const ROOM_PX: f64 = 1.0;
/// Rounds in which pixels are gathered where the edge is by then, and steps in a round, at most; a step that moves the centre by less, px,
/// is the last of its round.
const ROUNDS: usize = 9;
const STEPS: usize = 5;
const STILL_PX: f64 = 0.002;
/// An edge that moves less than this in a round, px, is near: from then on unlikely sectors are left out; and one that moves less than this is
/// there.
const NEAR_PX: f64 = 1.0;
const THERE_PX: f64 = 0.25;
/// Largest change of the centre in the last step, px; it counts as an error.
const SETTLED_PX: f64 = 0.05;
/// Smallest standard deviation of a centre, px: shading, rounding to grey levels and what the model of the edge leaves out.
const LEAST_SD_PX: f64 = 0.005;
/// The same of small or blurred discs, px, times (blur / radius)^2: of what lies about them less is seen beside their edge. Both are from
/// rendered images, of discs of 3 to 12 px with blurs of 0.8 to 3.2 px.
const SMALL_SD_PX: f64 = 0.45;
/// The same of rings, px, times the share of the light in the middle of the ring that comes from beside it: its own light is nowhere seen.
const RING_SD_PX: f64 = 0.4;

/// A disc that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disc {
    /// Its centre in the finger's plane, mm.
    pub centre: Vector,
    /// The pixel of the centre.
    pub pixel: Pixel,
    /// Standard deviation of one coordinate of the centre, mm.
    pub sd_mm: f64,
    /// Radius, mm, and blur, px, as found or as given.
    pub outline: Outline,
    /// Variance of the centre from what the residuals have of two and of three periods around the edge, over that from independent pixels: more
    /// than 1 where neighbouring pixels err alike, as after compression.
    pub excess_variances: [f64; 2],
    /// Mean squared residual of brightness and of colour about the edge, grey levels^2.
    pub noise: [f64; PARTS],
}

/// What the discs of an image have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outline {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Standard deviation of the blur of brightness and of colour, px.
    pub blurs_px: [f64; PARTS],
}

/// What a disc says of the displacement of colour against brightness, beside its own centre: the normal equations of least squares, over the
/// variance of the residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColourShift {
    pub normal: Matrix2<f64>,
    pub gradient: Vector2<f64>,
}

/// What is sought: centre and radius in the units of the plane's map, and the blurs (px).
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    centre: Vector,
    radius: f64,
    blurs: [f64; PARTS],
    colour_shift: Vector,
}

impl Edge {
    /// Half the width of the band of pixels about the edge in which brightness or colour changes, px.
    fn band(&self) -> f64 {
        BAND * self.blurs[0].max(self.blurs[1])
    }
}

/// An image and how its light is weighed.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    pub image: &'a RgbImage,
    pub camera: &'a Camera,
    /// Height of the discs above the finger's plane, mm.
    pub height_mm: f64,
    /// Of grey discs and rings, the radius inside which anything may be seen, mm; 0 for a whole disc. What lies about them has as much contrast as
    /// they have themselves: their edge is measured only where the background is even.
    pub grey_inner_mm: Option<f64>,
    /// What squared differences of brightness and of colour count: inverse to their noise, 1 for the less noisy; colour may be left out (0).
    pub weights: [f64; PARTS],
    /// How far colour is displaced against brightness along the finger's axes, px: by encoders that take every other pixel's, and by lenses.
    pub colour_shift_px: Vector,
}

/// What one disc after the other is measured in.
#[derive(Debug, Clone, Default)]
pub(super) struct Buffers {
    pixels: Pixels,
    shades: Shades,
    band: Band,
    sums: Sums,
}

impl View<'_> {
    /// Measures a disc of about this radius about a pixel; `None` where there is none.
    pub fn measure(&self, radius_mm: f64, about: &Pixel, buffers: &mut Buffers) -> Option<Disc> {
        Search::new(self, Outline { radius_mm, blurs_px: [FIRST_BLUR_PX; PARTS] }, about, true, buffers)?.found()
    }

    /// Measures the centre alone of a disc whose radius and blur are known from others.
    pub fn measure_centre(&self, outline: Outline, about: &Pixel, buffers: &mut Buffers) -> Option<Disc> {
        Search::new(self, outline, about, false, buffers)?.found()
    }

    /// The same, with what the disc says of a further displacement of colour.
    pub fn measure_centre_and_colour(
        &self,
        outline: Outline,
        about: &Pixel,
        buffers: &mut Buffers,
    ) -> Option<(Disc, ColourShift)> {
        let mut search = Search::new(self, outline, about, false, buffers)?;
        Some((search.found()?, search.colour_shift()?))
    }
}

/// The search for one edge.
struct Search<'a> {
    view: &'a View<'a>,
    map: PlaneMap,
    edge: Edge,
    /// The edge at the start.
    expected: Edge,
    /// Whether radius and blur are sought too.
    is_outline_open: bool,
    /// See [`View::grey_inner_mm`], in the map's units.
    grey_inner: Option<f64>,
    /// Largest blur whose band leaves room for the background among the gathered pixels, px.
    largest_blur_px: f64,
    buffers: &'a mut Buffers,
}

/// The last step of a search.
struct Step {
    /// Change of the centre, px.
    change_px: f64,
    /// The centre's part of the inverse of the normal equations.
    inverse: Matrix2<f64>,
}

impl<'a> Search<'a> {
    fn new(
        view: &'a View<'a>,
        expected: Outline,
        about: &Pixel,
        is_outline_open: bool,
        buffers: &'a mut Buffers,
    ) -> Option<Search<'a>> {
        let map = PlaneMap::new(view.camera, view.height_mm, about, expected.radius_mm)?;
        let radius = expected.radius_mm / map.unit_mm;
        let edge =
            Edge { centre: Vector::zeros(), radius, blurs: expected.blurs_px, colour_shift: view.colour_shift_px };
        let radius_px = map.radius_px(radius);
        // Room for an edge that is a quarter farther out, blurred twice as much or as much as it may be, and its background.
        let (wider, band) = match is_outline_open {
            true => (1.0 + RADIUS_TOLERANCE, (2.0 * edge.band()).max(BAND * LARGEST_BLUR * radius_px)),
            false => (1.0, edge.band()),
        };
        let reach = radius_px * wider + band + BACKGROUND_PX + ROOM_PX;
        map.gather(view.image, reach, &mut buffers.pixels);
        let largest_blur_px = (reach - radius_px - BACKGROUND_PX) / BAND;
        let grey_inner = view.grey_inner_mm.map(|inner_mm| inner_mm / map.unit_mm);
        Some(Search { view, map, edge, expected: edge, is_outline_open, grey_inner, largest_blur_px, buffers })
    }

    fn found(&mut self) -> Option<Disc> {
        let weights = self.view.weights;
        // Where the outline is known, so is about where the centre is.
        let mut is_near = !self.is_outline_open;
        for round in 0..ROUNDS {
            // Where the search began, sectors are judged after a step: an edge that is a little off looks unlikely.
            let judged_from = usize::from(round == 0);
            let from = self.edge;
            let Buffers { pixels, shades, band, .. } = &mut *self.buffers;
            self.map.measure_from(&from, pixels);
            shades.gather(pixels, &self.map, &from, self.grey_inner)?;
            band.gather(pixels, &self.map, &from, shades);
            let mut kept = 0.0;
            let mut last = None;
            for step in 0..STEPS {
                let Buffers { shades, band, sums, .. } = &mut *self.buffers;
                let mut sum = |shades: &Shades, sums: &mut Sums| match self.is_outline_open {
                    true => band.sum::<true>(&self.edge, weights, &shades.trust, sums),
                    false => band.sum::<false>(&self.edge, weights, &shades.trust, sums),
                };
                sum(shades, sums);
                if is_near && step == judged_from {
                    kept = shades.distrust_unlikely(sums);
                    sum(shades, sums);
                }
                let found = self.step()?;
                let is_still = step >= judged_from && found.change_px < STILL_PX;
                last = Some(found);
                if !is_near || is_still {
                    break;
                }
            }
            let last = last?;
            let moved = (self.edge.centre - from.centre).norm().max((self.edge.radius - from.radius).abs());
            if is_near && moved < THERE_PX && last.change_px < SETTLED_PX {
                return if kept >= KEPT_SECTORS { self.disc(&last) } else { None };
            }
            is_near = moved < NEAR_PX;
        }
        None
    }

    /// One step of Gauss and Newton; `None` where the edge is lost.
    fn step(&mut self) -> Option<Step> {
        let sums = &self.buffers.sums;
        let edge = &mut self.edge;
        let change: SVector<f64, UNKNOWNS>;
        let inverse: Matrix2<f64>;
        if self.is_outline_open {
            let mut normal = sums.normal;
            let mut gradient = sums.gradient;
            // Both blurs are the lens's, but for compression.
            let tie = (USUAL_NOISE / BLURS_APART_PX).powi(2);
            for (part, other) in [(3, 4), (4, 3)] {
                normal[(part, part)] += tie;
                normal[(part, other)] -= tie;
                gradient[part] -= tie * (edge.blurs[part - 3] - edge.blurs[other - 3]);
            }
            let whole: SMatrix<f64, UNKNOWNS, UNKNOWNS> = normal.cholesky()?.inverse();
            change = whole * gradient;
            inverse = whole.fixed_view::<2, 2>(0, 0).into_owned();
        } else {
            inverse = sums.normal.fixed_view::<2, 2>(0, 0).into_owned().try_inverse()?;
            let of_centre = inverse * sums.gradient.fixed_rows::<2>(0);
            change = SVector::from_fn(|i, _| if i < 2 { of_centre[i] } else { 0.0 });
        }
        edge.centre += change.fixed_rows::<2>(0);
        edge.radius += change[2];
        for (part, blur) in edge.blurs.iter_mut().enumerate() {
            let largest = 0.5 * *blur;
            *blur = (*blur + change[3 + part].clamp(-largest, largest)).clamp(LEAST_BLUR_PX, self.largest_blur_px);
        }
        let away = edge.centre.norm();
        let off = (edge.radius / self.expected.radius - 1.0).abs();
        let is_near = away < self.expected.radius && off < 2.0 * RADIUS_TOLERANCE;
        is_near.then(|| Step { change_px: change.fixed_rows::<2>(0).norm(), inverse })
    }

    /// Where the disc was found; the centre is eliminated.
    fn colour_shift(&mut self) -> Option<ColourShift> {
        let Buffers { shades, band, sums, .. } = &mut *self.buffers;
        let variance = sums.residual_variance();
        let of_both = sums.normal.fixed_view::<2, 2>(0, 0).into_owned();
        let weights = [0.0, self.view.weights[1]];
        band.sum::<false>(&self.edge, weights, &shades.trust, sums);
        let of_colour = sums.normal.fixed_view::<2, 2>(0, 0).into_owned();
        let normal = of_colour - of_colour * of_both.try_inverse()? * of_colour;
        Some(ColourShift { normal: normal / variance, gradient: sums.gradient.fixed_rows::<2>(0) / variance })
    }

    /// See [`RING_SD_PX`].
    fn ring_sd_px(&self) -> f64 {
        let Some(inner) = self.grey_inner.filter(|inner| *inner > 0.0) else { return 0.0 };
        let half_width = 0.5 * (self.edge.radius - inner);
        let (beyond_an_edge, _) = normal_distribution(-(half_width / self.edge.blurs[0]) as f32);
        RING_SD_PX * 2.0 * f64::from(beyond_an_edge)
    }

    fn disc(&self, last: &Step) -> Option<Disc> {
        let (sums, inverse) = (&self.buffers.sums, &last.inverse);
        let residual_sd = sums.residual_variance().sqrt();
        let contrast = (sums.weight / sums.count).sqrt();
        let off = (self.edge.radius / self.expected.radius - 1.0).abs();
        let largest_residual = if self.grey_inner.is_some() { LARGEST_GREY_RESIDUAL } else { LARGEST_RESIDUAL };
        if off > RADIUS_TOLERANCE || residual_sd > largest_residual * contrast {
            return None;
        }
        let variance_px2 = (inverse[(0, 0)] + inverse[(1, 1)]) / 2.0 * residual_sd * residual_sd;
        let centre = self.map.origin + self.edge.centre * self.map.unit_mm;
        let small = (self.edge.blurs[0] / self.edge.radius).powi(2);
        let of_model_px = LEAST_SD_PX.hypot(SMALL_SD_PX * small).hypot(self.ring_sd_px());
        let sd_px = variance_px2.sqrt().hypot(of_model_px).hypot(last.change_px);
        Some(Disc {
            centre,
            pixel: self.view.camera.project(&centre.push(self.view.height_mm)).ok()?,
            sd_mm: sd_px * self.map.unit_mm,
            outline: Outline { radius_mm: self.edge.radius * self.map.unit_mm, blurs_px: self.edge.blurs },
            excess_variances: excess_variances(&sums.by_sector, inverse, variance_px2),
            noise: sums.noise.map(|noise| noise / sums.count),
        })
    }
}

/// The variance of the centre from what the residuals have of two and of three periods around the edge, over another one.
fn excess_variances(sectors: &[SectorSums], inverse: &Matrix2<f64>, variance_px2: f64) -> [f64; 2] {
    let angle = std::f64::consts::TAU / sectors.len() as f64;
    let to_next = Complex::cis(angle);
    let mut direction = Complex::cis(angle / 2.0);
    let mut sums = [Complex::new(0.0, 0.0); 2];
    for of in sectors {
        let pull = f64::from(of.pull.x) * direction.re + f64::from(of.pull.y) * direction.im;
        let square = direction * direction;
        for (sum, turned) in sums.iter_mut().zip([square, square * direction]) {
            *sum += turned * pull;
        }
        direction *= to_next;
    }
    sums.map(|sum| (inverse * inverse).trace() / 2.0 * sum.norm_sqr() / 2.0 / variance_px2)
}
