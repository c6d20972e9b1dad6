//! Measurement of the centre of a disc from the light of the pixels about its edge. The light of a pixel consists of its brightness and two
//! components of colour, in grey levels.
//!
//! A pixel at the distance d (px) outside the disc's edge is modelled as background + (disc - background) Phi(-d / b). The model is an edge blurred
//! by a Gaussian of standard deviation b; Phi is the normal distribution function. Brightness and colour have separate blurs b, because compressed
//! images store colour with fewer pixels. The disc's light varies linearly over its inside. The background may differ from sector to sector around
//! the disc, because plates and ribs cross it; between the middles of two sectors, the background is interpolated. Centre, radius and both blurs
//! follow from least squares over the pixels of the edge. Pixels are weighted by the squared contrast, because the noise is the same everywhere.
//! Sectors that do not look like an edge (an occluder, another marker) are omitted.
//!
//! Distances are measured in the finger's plane, where the disc is a circle, so that perspective and lens distortion are taken into account.

mod band;
mod cover;
mod plane_map;
mod shades;
mod sums;

use crate::RgbRows;
use band::{Band, normal_distribution};
pub(super) use cover::{Cover, UsualCover, median};
use finray_model::Vector;
use finray_model::camera::{Camera, Pixel};
use nalgebra::{Complex, Matrix2, SMatrix, SVector, Vector2};
use plane_map::{Pixels, PlaneMap};
use shades::{BACKGROUND_PX, KEPT_SECTORS, Shades};
use sums::{SectorSums, Sums};

/// Number of unknowns of an edge: centre (two coordinates), radius, blur of brightness and blur of colour.
const UNKNOWNS: usize = 5;
/// Number of parts of the light: brightness and colour.
const PARTS: usize = 2;
/// Prior standard deviation of the difference between the blurs of brightness and colour, px, for a noise of [`USUAL_NOISE`]. The prior constrains a
/// blur that the pixels of a marker hardly determine.
const BLURS_APART_PX: f64 = 0.15;
/// Noise to which [`BLURS_APART_PX`] refers, grey levels.
const USUAL_NOISE: f64 = 2.0;
/// Half width of the band of pixels about the edge, in standard deviations of the edge's blur.
const BAND: f64 = 2.5;
/// Initial standard deviation of the edge's blur, px.
const FIRST_BLUR_PX: f64 = 0.9;
/// Lower bound of the standard deviation of the edge's blur, px. The width of a pixel alone causes 0.29 px.
const LEAST_BLUR_PX: f64 = 0.25;
/// Largest blur of markers, as a share of their radius. With a larger blur, no pixel of a disc shows the disc's undisturbed light, and the image is rejected.
pub(super) const LARGEST_BLUR: f64 = 0.33;
/// A disc is rejected if its radius deviates from the expected radius by more than this, relative to the expected radius.
const RADIUS_TOLERANCE: f64 = 0.25;
/// A coloured disc is rejected if its residual standard deviation exceeds this share of the contrast.
const LARGEST_RESIDUAL: f64 = 0.2;
/// Largest residual standard deviation of a grey disc, as a share of the contrast. The limit is below [`LARGEST_RESIDUAL`], because a grey disc that is
/// rejected here can still be measured by rays (`rim`). Photographed screws with shiny heads, and rims sharpened by the camera, exceed the limit.
const LARGEST_GREY_RESIDUAL: f64 = 0.07;
/// Largest expected distance of the centre from the starting point of the search, px.
const ROOM_PX: f64 = 1.0;
/// Largest number of rounds, each of which gathers the pixels about the current edge.
const ROUNDS: usize = 9;
/// Largest number of Gauss-Newton steps per round.
const STEPS: usize = 5;
/// A round ends when the step of the centre is below this, px.
const STILL_PX: f64 = 0.002;
/// If the edge moves by less than this in a round, px, the edge counts as close to the disc, and unlikely sectors are omitted in the next round.
const NEAR_PX: f64 = 1.0;
/// If the edge moves by less than this in a round, px, the edge counts as found.
const THERE_PX: f64 = 0.25;
/// A disc is rejected if its centre still moves by more than this in the last step, px. The standard deviation of the centre includes the last step.
const SETTLED_PX: f64 = 0.05;
/// Lower bound of the standard deviation of a centre, px. The bound covers shading, rounding to grey levels, and errors of the edge model.
const LEAST_SD_PX: f64 = 0.005;
/// Standard deviation of the centre of a small or blurred disc, px: this value times (blur / radius)^2. The edges of small or blurred discs are wide,
/// so that fewer pixels show the surroundings alone. [`SMALL_SD_PX`] and [`LEAST_SD_PX`] come from rendered images of discs of 3 to 12 px with blurs
/// of 0.8 to 3.2 px.
const SMALL_SD_PX: f64 = 0.45;
/// Additional standard deviation of the centre of a ring, px: this value times the share of neighbouring light in the middle of the ring's width. In
/// narrow rings, every pixel also shows neighbouring light.
const RING_SD_PX: f64 = 0.4;

/// A measured disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disc {
    /// Centre in the finger frame, mm.
    pub centre: Vector,
    /// Pixel of the disc's centre.
    pub pixel: Pixel,
    /// Standard deviation of one coordinate of the disc's centre, mm.
    pub sd_mm: f64,
    /// Radius and blurs of the disc, measured or given.
    pub outline: Outline,
    /// Two estimates of the centre's variance, divided by the variance for independent pixel errors; dimensionless. The two estimates come from the
    /// power of the residuals' components with two and with three periods around the edge. The ratios exceed 1 if errors of neighbouring pixels are
    /// correlated, as after compression.
    pub excess_variances: [f64; 2],
    /// Mean squared residual of brightness and of colour about the edge, in squared grey levels.
    pub noise: [f64; PARTS],
    /// Signs that something covers a part of the disc; none are measured while the outline is unknown, as it adapts to a cover.
    pub cover: Cover,
}

/// Radius and blurs that all discs of an image share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outline {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Standard deviations of the blur of brightness and of the blur of colour, px.
    pub blurs_px: [f64; PARTS],
}

/// Normal equations of a disc for the displacement of colour relative to brightness. The disc's centre is eliminated, and all terms are divided by the
/// residual variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColourShift {
    /// Normal matrix, 2 x 2, for a displacement along the finger's axes in px.
    pub normal: Matrix2<f64>,
    /// Right-hand side of the normal equations.
    pub gradient: Vector2<f64>,
}

/// Unknowns of the search: centre and radius in the units of the plane map, and blurs in px.
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    /// Centre of the edge in the map's coordinates and units.
    centre: Vector,
    /// Radius of the edge in the map's units.
    radius: f64,
    /// Standard deviations of the blur of brightness and of the blur of colour, px.
    blurs: [f64; PARTS],
    /// Displacement of colour relative to brightness along the finger's axes, px.
    colour_shift: Vector,
}

impl Edge {
    /// Half width of the band about the edge in which brightness or colour change, px.
    fn band(&self) -> f64 {
        BAND * self.blurs[0].max(self.blurs[1])
    }
}

/// An image with its camera, and settings for the measurement of discs.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub image: &'a dyn RgbRows,
    pub camera: &'a Camera,
    /// Height of the discs above the finger's plane, mm.
    pub height_mm: f64,
    /// Inner radius of a grey ring, mm, inside which any appearance is allowed; 0 for a whole grey disc; `None` for coloured discs. The surroundings of a grey
    /// mark may have as much contrast as the mark, so the edge is measured only where the background is even.
    pub grey_inner_mm: Option<f64>,
    /// Weights of squared differences of brightness and of colour, dimensionless: inversely proportional to their noise variances, and 1 for the less
    /// noisy of the two. Weight 0 omits colour.
    pub weights: [f64; PARTS],
    /// Displacement of colour relative to brightness along the finger's axes, px. Lenses, and encoders that subsample colour, cause this displacement.
    pub colour_shift_px: Vector,
}

/// Buffers that are reused from disc to disc.
#[derive(Debug, Clone, Default)]
pub(super) struct Buffers {
    pixels: Pixels,
    shades: Shades,
    band: Band,
    sums: Sums,
    /// Pixels of a row of the image.
    pub row: Vec<u8>,
}

impl View<'_> {
    /// Measures a disc with a radius of about `radius_mm` near the pixel `about`. Returns `None` if no disc is there.
    pub fn measure(&self, radius_mm: f64, about: &Pixel, buffers: &mut Buffers) -> Option<Disc> {
        Search::new(self, Outline { radius_mm, blurs_px: [FIRST_BLUR_PX; PARTS] }, about, true, buffers)?.found()
    }

    /// Measures only the centre of a disc, whose radius and blurs are known.
    pub fn measure_centre(&self, outline: Outline, about: &Pixel, buffers: &mut Buffers) -> Option<Disc> {
        Search::new(self, outline, about, false, buffers)?.found()
    }

    /// Same as [`measure_centre`](View::measure_centre); also returns the disc's equations for a further displacement of colour.
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

/// The search for the edge of one disc.
struct Search<'a> {
    view: &'a View<'a>,
    map: PlaneMap,
    /// The edge at the current step of the search.
    edge: Edge,
    /// The edge at the starting point of the search.
    expected: Edge,
    /// Whether radius and blurs are unknown in addition to the centre.
    is_outline_open: bool,
    /// Inner radius as in [`View::grey_inner_mm`], in the units of the map.
    grey_inner: Option<f64>,
    /// Largest blur for which the gathered pixels contain band and background, px.
    largest_blur_px: f64,
    buffers: &'a mut Buffers,
}

/// The last step of a search.
struct Step {
    /// Length of the change of the centre, px.
    change_px: f64,
    /// Block of the inverse normal matrix that belongs to the centre.
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
        // The gathered pixels must suffice for the background, and for a radius and a blur that are larger than expected.
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
        // A search with a known outline starts close to the disc's centre.
        let mut is_near = !self.is_outline_open;
        for round in 0..ROUNDS {
            // In the first round, sectors are judged only after one step, because a slightly displaced edge would look unlikely.
            let judged_from = usize::from(round == 0);
            let from = self.edge;
            let Buffers { pixels, shades, band, .. } = &mut *self.buffers;
            self.map.measure_from(&from, pixels);
            shades.gather(pixels, &self.map, &from, self.grey_inner)?;
            band.gather(pixels, &self.map, &from, shades);
            let (mut kept, mut missed) = (0.0, 0.0);
            let mut last = None;
            for step in 0..STEPS {
                let Buffers { shades, band, sums, .. } = &mut *self.buffers;
                let mut sum = |shades: &Shades, sums: &mut Sums| match self.is_outline_open {
                    true => band.sum::<true>(&self.edge, weights, &shades.trust, sums),
                    false => band.sum::<false>(&self.edge, weights, &shades.trust, sums),
                };
                sum(shades, sums);
                if is_near && step == judged_from {
                    missed = cover::missed(&sums.by_sector, &shades.trust);
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
                return if kept >= KEPT_SECTORS { self.disc(&last, missed) } else { None };
            }
            is_near = moved < NEAR_PX;
        }
        None
    }

    /// Makes one Gauss-Newton step. Returns `None` if the equations are singular, or if centre or radius is too far from the starting point.
    fn step(&mut self) -> Option<Step> {
        let sums = &self.buffers.sums;
        let edge = &mut self.edge;
        let change: SVector<f64, UNKNOWNS>;
        let inverse: Matrix2<f64>;
        if self.is_outline_open {
            let mut normal = sums.normal;
            let mut gradient = sums.gradient;
            // The lens blurs brightness and colour equally, so their blurs differ only by the effects of compression.
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

    /// Normal equations for the displacement of colour at the measured disc; the centre is eliminated.
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

    /// Standard deviation by [`RING_SD_PX`], px; zero for discs without a hole.
    fn ring_sd_px(&self) -> f64 {
        let Some(inner) = self.grey_inner.filter(|inner| *inner > 0.0) else { return 0.0 };
        let half_width = 0.5 * (self.edge.radius - inner);
        let (beyond_an_edge, _) = normal_distribution(-(half_width / self.edge.blurs[0]) as f32);
        RING_SD_PX * 2.0 * f64::from(beyond_an_edge)
    }

    fn disc(&self, last: &Step, missed: f64) -> Option<Disc> {
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
        let cover = match self.is_outline_open {
            true => Cover::default(),
            false => cover::cover(&sums.by_sector, missed, residual_sd * residual_sd, of_model_px, self.map.unit_mm),
        };
        Some(Disc {
            centre,
            pixel: self.view.camera.project(&centre.push(self.view.height_mm)).ok()?,
            sd_mm: sd_px * self.map.unit_mm,
            outline: Outline { radius_mm: self.edge.radius * self.map.unit_mm, blurs_px: self.edge.blurs },
            excess_variances: excess_variances(&sums.by_sector, inverse, variance_px2),
            noise: sums.noise.map(|noise| noise / sums.count),
            cover,
        })
    }
}

/// Two estimates of the centre's variance, divided by `variance_px2` (dimensionless). The estimates come from the power of the residuals' components
/// with two and with three periods around the edge.
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
