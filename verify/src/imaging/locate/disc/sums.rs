//! The equations of an edge: sums over the pixels about it.

use super::plane_map::Polar;
use super::shades::Shades;
use super::{BAND, Edge, PARTS, Sample, UNKNOWNS};
use nalgebra::{SMatrix, SVector, Vector2};

/// Sums over the pixels of the band.
pub(super) struct Sums {
    pub normal: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    pub gradient: SVector<f64, UNKNOWNS>,
    pub count: f64,
    /// Of the weighted squared residuals, grey levels^2.
    pub squares: f64,
    /// Of the weighted squared contrasts.
    pub weight: f64,
    /// Of the squared residuals of brightness and, halved, of colour.
    pub noise: [f64; PARTS],
    /// By sector: pixels, squared residuals, squared contrasts.
    pub by_sector: Vec<(f64, f64, f64)>,
    /// By sector: the centre's part of the gradient.
    pub pulls: Vec<Vector2<f64>>,
}

/// A pixel of the band, as it lies to an edge.
struct Near {
    /// Distance outside the edge, px.
    d: f64,
    direction: Vector2<f64>,
    /// px a mm along it.
    px_a_mm: f64,
    sector: usize,
    /// Light beyond the background, and that of the disc beyond it.
    light: [f64; 3],
    contrast: [f64; 3],
}

/// The pixels about an edge, with the background and the disc's light at each.
pub(super) struct Band {
    near: Vec<Near>,
    /// Where the edge was when they were gathered.
    edge: Edge,
    trust: Vec<f64>,
    scale: f64,
}

impl Band {
    pub fn new(samples: &[Sample], polars: &[Polar], edge: &Edge, shades: &Shades, scale: f64) -> Band {
        let band = edge.band();
        let near = samples.iter().zip(polars).filter_map(|(sample, polar)| {
            let Polar { outside_px: d, direction, px_a_mm, turn } = *polar;
            if d.abs() > band {
                return None;
            }
            let (sector, background) = shades.outside_at(turn);
            let contrast = (shades.inside_at(&sample.at) - background).cast::<f64>();
            let light = (sample.light - background).cast::<f64>();
            Some(Near { d, direction, px_a_mm, sector, light: light.into(), contrast: contrast.into() })
        });
        Band { near: near.collect(), edge: *edge, trust: shades.trust.clone(), scale }
    }

    /// The sums where the edge is now: a little away from where the pixels were gathered.
    pub fn sums(&self, edge: &Edge, weights: [f64; PARTS], excluded: &[bool]) -> Sums {
        let sectors = self.trust.len();
        let mut sums = Sums {
            normal: SMatrix::zeros(),
            gradient: SVector::zeros(),
            count: 0.0,
            squares: 0.0,
            weight: 0.0,
            noise: [0.0; PARTS],
            by_sector: vec![(0.0, 0.0, 0.0); sectors],
            pulls: vec![Vector2::zeros(); sectors],
        };
        let moved = edge.centre - self.edge.centre;
        let grown = edge.radius - self.edge.radius;
        for near in &self.near {
            if excluded.get(near.sector) == Some(&true) {
                continue;
            }
            let d = near.d - (near.direction.dot(&moved) + grown) * near.px_a_mm;
            let trust = self.trust[near.sector];
            // Centre and radius in units of `scale` mm, about a px.
            let px = near.px_a_mm * self.scale;
            let (mut squared, mut contrast2) = (0.0, 0.0);
            for (part, parts) in [0..1, 1..3].into_iter().enumerate() {
                let (blur, weight) = (edge.blurs[part], weights[part]);
                let x = d / blur;
                let (covered, density) = match x.abs() > BAND {
                    true => (f64::from(u8::from(x < 0.0)), 0.0),
                    false => normal_distribution(-x),
                };
                let (mut own, mut against, mut residuals) = (0.0, 0.0, 0.0);
                for k in parts {
                    let residual = near.light[k] - near.contrast[k] * covered;
                    own += near.contrast[k] * near.contrast[k];
                    against += near.contrast[k] * residual;
                    residuals += residual * residual;
                }
                let steepness = density / blur;
                let along = px * steepness;
                let row = [near.direction.x * along, near.direction.y * along, along, x * steepness];
                sums.add(part, &row, weight * own * trust, weight * against * trust);
                sums.pulls[near.sector] += Vector2::new(row[0], row[1]) * (weight * against * trust);
                sums.noise[part] += residuals * trust / (1 + part) as f64;
                squared += weight * residuals;
                contrast2 += weight * own;
            }
            sums.count += trust;
            sums.squares += squared * trust;
            sums.weight += contrast2 * trust;
            let sector = &mut sums.by_sector[near.sector];
            *sector = (sector.0 + 1.0, sector.1 + squared, sector.2 + contrast2);
        }
        // Only the lower triangle was summed.
        sums.normal.fill_upper_triangle_with_lower_triangle();
        sums
    }
}

impl Sums {
    /// Adds a pixel's part: `row` has the derivatives by centre, radius and the part's own blur.
    fn add(&mut self, part: usize, row: &[f64; 4], weight: f64, pull: f64) {
        let at = [0, 1, 2, 3 + part];
        for (i, &line) in at.iter().enumerate() {
            self.gradient[line] += row[i] * pull;
            for (k, &column) in at.iter().enumerate().take(i + 1) {
                self.normal[(line, column)] += weight * row[i] * row[k];
            }
        }
    }
}

/// The normal distribution, to 1e-7, and its density.
///
/// # Reference
/// Abramowitz and Stegun, Handbook of Mathematical Functions, 26.2.17.
fn normal_distribution(x: f64) -> (f64, f64) {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let polynomial =
        t * (0.319_381_530 + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let tail = density * polynomial;
    (if x > 0.0 { 1.0 - tail } else { tail }, density)
}
