//! The equations of an edge: sums over the pixels about it.

use super::plane_map::PlaneMap;
use super::shades::Shades;
use super::{BAND, Edge, Sample};
use nalgebra::{Matrix3, Matrix4, Vector2, Vector4};

/// Sums over the pixels of the band.
pub(super) struct Sums {
    pub normal: Matrix4<f64>,
    pub gradient: Vector4<f64>,
    pub count: f64,
    /// Of the squared residuals in the metric of the light, grey levels^2.
    pub squares: f64,
    /// Of the squared contrasts.
    pub weight: f64,
    /// Of the products of the residuals' colours, grey levels^2.
    pub colours: Matrix3<f64>,
    /// By sector: pixels, squared residuals, squared contrasts.
    pub by_sector: Vec<(f64, f64, f64)>,
    /// By sector: the centre's part of the gradient.
    pub pulls: Vec<Vector2<f64>>,
}

impl Sums {
    /// Sums where the edge is now. `metric` weighs the differences of colours.
    pub fn of(
        samples: &[Sample],
        edge: &Edge,
        (shades, metric): (&Shades, &Matrix3<f32>),
        map: &PlaneMap,
        excluded: &[bool],
    ) -> Sums {
        let mut sums = Sums {
            normal: Matrix4::zeros(),
            gradient: Vector4::zeros(),
            count: 0.0,
            squares: 0.0,
            weight: 0.0,
            colours: Matrix3::zeros(),
            by_sector: vec![(0.0, 0.0, 0.0); shades.sectors],
            pulls: vec![Vector2::zeros(); shades.sectors],
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
            let weighed = metric * contrast;
            let contrast2 = f64::from(contrast.dot(&weighed));
            if contrast2 < 1.0 {
                continue;
            }
            let light = sample.light - background;
            let share = f64::from(light.dot(&weighed)) / contrast2;
            let x = d / edge.blur;
            let (covered, density) = normal_distribution(-x);
            let residual = share - covered;
            let steepness = density / edge.blur;
            // Centre and radius in units of `scale` mm, about a px.
            let along = Vector2::from(direction) * (px_a_mm * map.scale);
            let row = Vector4::new(along.x, along.y, px_a_mm * map.scale, x) * steepness;
            let trust = shades.trust[number];
            sums.normal += row * row.transpose() * (contrast2 * trust);
            sums.gradient += row * (residual * contrast2 * trust);
            sums.pulls[number] += row.xy() * (residual * contrast2 * trust);
            sums.count += trust;
            let squared = residual * residual * contrast2;
            sums.squares += squared * trust;
            sums.weight += contrast2 * trust;
            let colour = (light - contrast * covered as f32).cast::<f64>();
            sums.colours += colour * colour.transpose() * trust;
            let sector = &mut sums.by_sector[number];
            *sector = (sector.0 + 1.0, sector.1 + squared, sector.2 + contrast2);
        }
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
