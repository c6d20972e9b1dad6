//! The equations of an edge: sums over the pixels about it.

use super::plane_map::PlaneMap;
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

impl Sums {
    /// Sums where the edge is now.
    pub fn of(
        samples: &[Sample],
        edge: &Edge,
        (shades, weights): (&Shades, [f64; PARTS]),
        map: &PlaneMap,
        excluded: &[bool],
    ) -> Sums {
        let mut sums = Sums {
            normal: SMatrix::zeros(),
            gradient: SVector::zeros(),
            count: 0.0,
            squares: 0.0,
            weight: 0.0,
            noise: [0.0; PARTS],
            by_sector: vec![(0.0, 0.0, 0.0); shades.sectors],
            pulls: vec![Vector2::zeros(); shades.sectors],
        };
        let band = edge.band();
        for sample in samples {
            let (d, direction, px_a_mm) = map.outside(edge, &sample.at);
            if d.abs() > band {
                continue;
            }
            let (number, background) = shades.outside_at(&direction);
            if excluded.get(number) == Some(&true) {
                continue;
            }
            let trust = shades.trust[number];
            let contrast = (shades.inside_at(&sample.at) - background).cast::<f64>();
            let light = (sample.light - background).cast::<f64>();
            // Centre and radius in units of `scale` mm, about a px.
            let px = px_a_mm * map.scale;
            let (mut squared, mut contrast2) = (0.0, 0.0);
            let mut pull = Vector2::zeros();
            for (part, parts) in [0..1, 1..3].into_iter().enumerate() {
                let (blur, weight) = (edge.blurs[part], weights[part]);
                let x = d / blur;
                let (covered, density) =
                    if x.abs() > BAND { (f64::from(u8::from(x < 0.0)), 0.0) } else { normal_distribution(-x) };
                let (mut own, mut against, mut residuals) = (0.0, 0.0, 0.0);
                for k in parts {
                    let residual = light[k] - contrast[k] * covered;
                    own += contrast[k] * contrast[k];
                    against += contrast[k] * residual;
                    residuals += residual * residual;
                }
                let steepness = density / blur;
                let mut row = SVector::<f64, UNKNOWNS>::zeros();
                (row[0], row[1], row[2]) = (direction.x * px * steepness, direction.y * px * steepness, px * steepness);
                row[3 + part] = x * steepness;
                sums.normal.syger(weight * own * trust, &row, &row, 1.0);
                sums.gradient.axpy(weight * against * trust, &row, 1.0);
                pull += row.fixed_rows::<2>(0) * (weight * against * trust);
                sums.noise[part] += residuals * trust / (1 + part) as f64;
                squared += weight * residuals;
                contrast2 += weight * own;
            }
            sums.pulls[number] += pull;
            sums.count += trust;
            sums.squares += squared * trust;
            sums.weight += contrast2 * trust;
            let sector = &mut sums.by_sector[number];
            *sector = (sector.0 + 1.0, sector.1 + squared, sector.2 + contrast2);
        }
        // Only the lower triangle was summed.
        sums.normal.fill_upper_triangle_with_lower_triangle();
        sums
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
