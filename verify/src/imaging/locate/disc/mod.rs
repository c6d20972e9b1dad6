//! The centre of a disc, from the light of the pixels about its edge.
//!
//! A pixel at the distance d outside the disc's edge (px) shows background + (disc - background) Phi(-d / b): the edge, blurred by a
//! Gaussian of standard deviation b, Phi the normal distribution. Brightness and colour have a b each, since compressed images store colour
//! with fewer pixels. The disc's own light is a plane over its inside, the background one colour for each sector around it, since plates
//! and ribs cross it. Centre, radius and both b are found by least squares over the pixels of the edge; each counts by the square of its
//! contrast, as noise is the same everywhere. Sectors that do not look like an edge (an occluder, another marker) are left out.
//!
//! Distances are taken in the finger's plane, where the disc is a circle: what perspective and lens do to its image is allowed for.

mod plane_map;
mod shades;
mod sums;

use finray_model::Vector;
use finray_model::camera::{Camera, Pixel};
use image::RgbImage;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};
use plane_map::{PlaneMap, Polar};
use shades::{BACKGROUND_PX, KEPT_SECTORS, Shades};
use sums::{Band, Sums};

/// Unknowns of an edge: centre (two), radius, blur of brightness and of colour.
const UNKNOWNS: usize = 5;
/// Parts of the light: brightness and colour.
const PARTS: usize = 2;
/// Standard deviation of the difference of their blurs, px, for noise of two grey levels: holds the one that a marker hardly shows.
const BLURS_APART_PX: f64 = 1.0;
const USUAL_NOISE: f64 = 2.0;
/// Half the width of the band of pixels about the edge, in b.
const BAND: f64 = 2.5;
/// b where the search starts, and its bounds, px. A pixel's own width is a blur of 0.29 px.
const FIRST_BLUR_PX: f64 = 0.9;
const BLURS_PX: [f64; 2] = [0.25, 6.0];
/// Largest deviation of the radius from the expected one, as a share.
const RADIUS_TOLERANCE: f64 = 0.25;
/// Largest residual standard deviation, as a share of the contrast.
const LARGEST_RESIDUAL: f64 = 0.2;
/// Steps on the way to the edge, with shades found anew at each, and rounds in which sectors are judged where the edge is by then: where
/// nothing is known, and where radius and blur are.
const FIRST: (usize, usize) = (3, 3);
const AGAIN: (usize, usize) = (1, 2);
/// Room for a centre that is not where the search begins, px.
const ROOM_PX: f64 = 1.0;
/// Steps in a round.
const ROUND_STEPS: usize = 2;
/// Largest change of the centre in the last step, px; it counts as an error.
const SETTLED_PX: f64 = 0.05;
/// Smallest standard deviation of a centre, px: shading, rounding to grey levels and what the model of the edge leaves out.
const LEAST_SD_PX: f64 = 0.01;

/// Sectors of a piece of edge, whose pixels may err alike: eight pixels, as compression takes them together.
const PIECE_SECTORS: usize = 4;

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
    /// Variance of the centre as its pieces of edge scatter, over that from the residual of independent pixels: more than 1 where
    /// neighbouring pixels err alike, as after compression.
    pub excess_variance: f64,
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

/// A pixel about the edge.
struct Sample {
    /// Where it lies in the plane, mm.
    at: Vector,
    /// Its brightness and, at right angles to that, two parts of its colour: see [`plane_map::light_of`].
    light: Vector3<f32>,
}

/// What is sought: centre and radius (mm, in the plane), and the blurs (px).
#[derive(Debug, Clone, Copy)]
struct Edge {
    centre: Vector,
    radius: f64,
    blurs: [f64; PARTS],
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
    /// What squared differences of brightness and of colour count: inverse to their noise, 1 for the less noisy.
    pub weights: [f64; PARTS],
}

impl View<'_> {
    /// Measures a disc of about this radius about a pixel; `None` where there is none.
    pub fn measure(&self, radius_mm: f64, about: &Pixel) -> Option<Disc> {
        Search::new(self, Outline { radius_mm, blurs_px: [FIRST_BLUR_PX; PARTS] }, about, true)?.found()
    }

    /// Measures the centre alone of a disc whose radius and blur are known from others.
    pub fn measure_centre(&self, outline: Outline, about: &Pixel) -> Option<Disc> {
        Search::new(self, outline, about, false)?.found()
    }
}

/// The search for one edge.
struct Search<'a> {
    view: &'a View<'a>,
    map: PlaneMap,
    samples: Vec<Sample>,
    edge: Edge,
    /// The outline at the start.
    expected: Outline,
    /// Whether radius and blur are sought too.
    is_outline_open: bool,
}

impl<'a> Search<'a> {
    fn new(view: &'a View<'a>, expected: Outline, about: &Pixel, is_outline_open: bool) -> Option<Search<'a>> {
        let map = PlaneMap::new(view.camera, view.height_mm, about, expected.radius_mm)?;
        let edge = Edge { centre: map.origin, radius: expected.radius_mm, blurs: expected.blurs_px };
        // Room for an edge that is a quarter farther out, blurred twice as much, and its background.
        let (wider, blurred) = if is_outline_open { (1.0 + RADIUS_TOLERANCE, 2.0) } else { (1.0, 1.0) };
        let reach = map.radius_px(expected.radius_mm) * wider + blurred * edge.band() + BACKGROUND_PX + ROOM_PX;
        let samples = map.samples(view.image, reach)?;
        Some(Search { view, map, samples, edge, expected, is_outline_open })
    }

    /// Background, disc and band where the edge is now.
    fn band(&self) -> Option<(Shades, Band)> {
        let (edge, scale) = (&self.edge, self.map.scale);
        let polars: Vec<Polar> = self.samples.iter().map(|sample| self.map.polar(edge, &sample.at)).collect();
        let shades = Shades::new(&self.samples, &polars, edge, scale)?;
        let band = Band::new(&self.samples, &polars, edge, &shades, scale);
        Some((shades, band))
    }

    fn found(mut self) -> Option<Disc> {
        let weights = self.view.weights;
        let (first_steps, rounds) = if self.is_outline_open { FIRST } else { AGAIN };
        for _ in 0..first_steps {
            let (_, band) = self.band()?;
            self.step(&band.sums(&self.edge, weights, &[]))?;
        }
        for round in 1..=rounds {
            let (shades, band) = self.band()?;
            let excluded = shades.unlikely(&band.sums(&self.edge, weights, &[]));
            for step in 1..=ROUND_STEPS {
                let sums = band.sums(&self.edge, weights, &excluded);
                let (change_px, inverse) = self.step(&sums)?;
                if (round, step) == (rounds, ROUND_STEPS) && change_px < SETTLED_PX {
                    let kept = excluded.iter().filter(|excluded| !**excluded).count() as f64 / shades.sectors as f64;
                    return (kept >= KEPT_SECTORS).then(|| self.disc(&sums, &inverse, change_px))?;
                }
            }
        }
        None
    }

    /// One step of Gauss and Newton: the change of the centre, px, and the centre's part of the inverse of the normal equations. `None`
    /// where the edge is lost.
    fn step(&mut self, sums: &Sums) -> Option<(f64, Matrix2<f64>)> {
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
        edge.centre += change.fixed_rows::<2>(0) * self.map.scale;
        edge.radius += change[2] * self.map.scale;
        for (part, blur) in edge.blurs.iter_mut().enumerate() {
            let largest = 0.5 * *blur;
            *blur = (*blur + change[3 + part].clamp(-largest, largest)).clamp(BLURS_PX[0], BLURS_PX[1]);
        }
        let away = (edge.centre - self.map.origin).norm();
        let off = (edge.radius / self.expected.radius_mm - 1.0).abs();
        let is_near = away < self.expected.radius_mm && off < 2.0 * RADIUS_TOLERANCE;
        is_near.then(|| (change.fixed_rows::<2>(0).norm(), inverse))
    }

    fn disc(&self, sums: &Sums, inverse: &Matrix2<f64>, change_px: f64) -> Option<Disc> {
        let residual_sd = (sums.squares / (3.0 * sums.count - UNKNOWNS as f64).max(1.0)).sqrt();
        let contrast = (sums.weight / sums.count).sqrt();
        let off = (self.edge.radius / self.expected.radius_mm - 1.0).abs();
        if off > RADIUS_TOLERANCE || residual_sd > LARGEST_RESIDUAL * contrast {
            return None;
        }
        let variance_px2 = (inverse[(0, 0)] + inverse[(1, 1)]) / 2.0 * residual_sd * residual_sd;
        Some(Disc {
            centre: self.edge.centre,
            pixel: self.view.camera.project(&self.edge.centre.push(self.view.height_mm)).ok()?,
            sd_mm: variance_px2.sqrt().hypot(LEAST_SD_PX).hypot(change_px) * self.map.scale,
            outline: Outline { radius_mm: self.edge.radius, blurs_px: self.edge.blurs },
            excess_variance: self.excess_variance(sums, inverse, variance_px2),
            noise: sums.noise.map(|noise| noise / sums.count),
        })
    }
}

impl Search<'_> {
    /// The variance of the centre from the scatter of pieces of its edge, over another one.
    ///
    /// # Reference
    /// The covariance of clustered residuals: K.-Y. Liang and S. Zeger, Longitudinal data analysis using generalized linear models,
    /// Biometrika 73 (1986).
    fn excess_variance(&self, sums: &Sums, inverse: &Matrix2<f64>, variance_px2: f64) -> f64 {
        let pieces: Vec<Vector2<f64>> = sums.pulls.chunks(PIECE_SECTORS).map(|pulls| pulls.iter().sum()).collect();
        let scatter: Matrix2<f64> = pieces.iter().map(|pull| pull * pull.transpose()).sum();
        let pieces = pieces.len() as f64;
        // The centre follows the pieces, which takes two of their degrees of freedom.
        let variance = (inverse * scatter * inverse).trace() / 2.0 * pieces / (pieces - 2.0).max(1.0);
        variance / variance_px2
    }
}
