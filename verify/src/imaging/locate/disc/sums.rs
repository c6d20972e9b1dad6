//! The equations of an edge: sums over the pixels about it.

use super::plane_map::PlaneMap;
use super::shades::Shades;
use super::{BAND, Edge, Sample};
use nalgebra::{Matrix4, Vector2, Vector4};

/// Sums over the pixels of the band.
pub(super) struct Sums {
    pub normal: Matrix4<f64>,
    pub gradient: Vector4<f64>,
    pub count: f64,
    /// Of the squared residuals, grey levels^2.
    pub squares: f64,
    /// Of the squared contrasts.
    pub weight: f64,
    /// By sector: pixels, squared residuals, squared contrasts.
    pub by_sector: Vec<(f64, f64, f64)>,
}

impl Sums {
    pub fn of(samples: &[Sample], edge: &Edge, shades: &Shades, map: &PlaneMap, excluded: &[bool]) -> Sums {
        let mut sums = Sums {
            normal: Matrix4::zeros(),
            gradient: Vector4::zeros(),
            count: 0.0,
            squares: 0.0,
            weight: 0.0,
            by_sector: vec![(0.0, 0.0, 0.0); shades.sectors],
        };
        let band = BAND * edge.blur;
        for sample in samples {
            let (d, direction, px_a_mm) = map.outside(edge, &sample.at);
            if d.abs() > band {
                continue;
            }
            let (number, background) = shades.outside_at(&direction);
            if excluded.get(number) == Some(&true) {
                continue;
            }
            let contrast = shades.inside_at(&sample.at) - background;
            let contrast2 = f64::from(contrast.norm_squared());
            if contrast2 < 1.0 {
                continue;
            }
            let share = f64::from((sample.light - background).dot(&contrast)) / contrast2;
            let x = d / edge.blur;
            let residual = share - normal_distribution(-x);
            let steepness = (-0.5 * x * x).exp() / (edge.blur * std::f64::consts::TAU.sqrt());
            // Centre and radius in units of `scale` mm, about a px.
            let along = Vector2::from(direction) * (px_a_mm * map.scale);
            let row = Vector4::new(along.x, along.y, px_a_mm * map.scale, x) * steepness;
            let trust = shades.trust[number];
            sums.normal += row * row.transpose() * (contrast2 * trust);
            sums.gradient += row * (residual * contrast2 * trust);
            sums.count += trust;
            let squared = residual * residual * contrast2;
            sums.squares += squared * trust;
            sums.weight += contrast2 * trust;
            let sector = &mut sums.by_sector[number];
            *sector = (sector.0 + 1.0, sector.1 + squared, sector.2 + contrast2);
        }
        sums
    }
}

/// Phi, to 1e-7.
///
/// # Reference
/// Abramowitz and Stegun, Handbook of Mathematical Functions, 26.2.17.
fn normal_distribution(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let polynomial =
        t * (0.319_381_530 + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt() * polynomial;
    if x > 0.0 { 1.0 - tail } else { tail }
}
