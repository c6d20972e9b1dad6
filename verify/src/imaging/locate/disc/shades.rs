//! Light of a disc and of what lies about it.

use super::plane_map::Polar;
use super::sums::Sums;
use super::{Edge, Sample};
use finray_model::Vector;
use nalgebra::Vector3;

/// Where the background of a sector is seen: from the band's end, so many px on.
pub(super) const BACKGROUND_PX: f64 = 3.0;
/// Length of a sector along the edge, px, and bounds of their number.
const SECTOR_PX: f64 = 2.0;
const SECTORS: [usize; 2] = [12, 96];
/// Share of the sectors whose background is taken to be even; their scatter is noise.
const EVEN_SECTORS: f64 = 0.3;
/// Scatter that an even background may have beside noise, grey levels.
const SHADING: f64 = 2.0;
/// Pixels inside belong to the disc if no part of their light differs by more than this from the median, grey levels.
const ALIKE: f64 = 40.0;
/// Smallest contrast of a sector, grey levels over all parts of the light.
const LEAST_CONTRAST: f64 = 12.0;
/// A sector whose mean squared residual is beyond that of even sectors by so many of its standard deviations is no edge of the disc.
const UNLIKELY: f64 = 4.0;
/// Smallest variance of a grey level that is told from none: rounding leaves 1/12.
const LEAST_VARIANCE: f64 = 0.5;
/// Share of the sectors that stay however disturbed they are, and that must have an edge.
pub(super) const KEPT_SECTORS: f64 = 0.4;

/// Light of the disc and of what lies about it.
pub(super) struct Shades {
    /// By a step from the centre, mm: constant, by x, by y.
    inside: [Vector3<f32>; 3],
    centre: Vector,
    outside: Vec<Vector3<f32>>,
    /// By sector, how much its pixels count: less where an edge of plate or rib crosses the background, which is then not the same along
    /// the sector.
    pub trust: Vec<f64>,
    pub sectors: usize,
}

impl Shades {
    pub fn new(samples: &[Sample], polars: &[Polar], edge: &Edge, scale: f64) -> Option<Shades> {
        let band = edge.band();
        let sectors =
            ((std::f64::consts::TAU * edge.radius / scale / SECTOR_PX) as usize).clamp(SECTORS[0], SECTORS[1]);
        let mut about = vec![(0.0_f32, Vector3::zeros(), 0.0_f32); sectors];
        let mut inner: Vec<&Sample> = Vec::with_capacity(samples.len() / 2);
        // Small discs have no inside that the blur spares: their middle stands for it.
        let depth = band.min(0.5 * edge.radius / scale);
        for (sample, polar) in samples.iter().zip(polars) {
            let d = polar.outside_px;
            if d < -depth {
                inner.push(sample);
            } else if d > band && d < band + BACKGROUND_PX {
                let (sum, light, squares) = &mut about[sector(polar.turn, sectors).0];
                *sum += 1.0;
                *light += sample.light;
                *squares += sample.light.norm_squared();
            }
        }
        if inner.len() < 3 {
            return None;
        }
        let inside = plane_of_light(&inner, &edge.centre)?;
        let mut outside: Vec<Option<Vector3<f32>>> =
            about.iter().map(|(count, light, _)| (*count > 0.0).then(|| light / *count)).collect();
        // A sector without a pixel, at the border of the image, has its neighbour's background.
        let known: Vec<usize> = (0..sectors).filter(|&i| outside[i].is_some()).collect();
        for i in 0..sectors {
            if outside[i].is_none() {
                let distance = |j: usize| (i.abs_diff(j)).min(sectors - i.abs_diff(j));
                outside[i] = outside[*known.iter().min_by_key(|&&j| distance(j))?];
            }
        }
        let outside = outside.into_iter().collect::<Option<Vec<_>>>()?;
        let scatter = |(count, light, squares): &(f32, Vector3<f32>, f32)| match *count > 1.0 {
            true => f64::from((squares - light.norm_squared() / count) / (count - 1.0)).max(0.0),
            false => 0.0,
        };
        let trust = trust(&about.iter().map(scatter).collect::<Vec<_>>());
        Some(Shades { inside, centre: edge.centre, outside, trust, sectors })
    }

    pub fn inside_at(&self, at: &Vector) -> Vector3<f32> {
        let step = at - self.centre;
        self.inside[0] + self.inside[1] * step.x as f32 + self.inside[2] * step.y as f32
    }

    /// The background in a direction, between the middles of two sectors.
    pub fn outside_at(&self, turn: f64) -> (usize, Vector3<f32>) {
        let (number, part) = sector(turn, self.sectors);
        let other = match part < 0.5 {
            true => (number + self.sectors - 1) % self.sectors,
            false => (number + 1) % self.sectors,
        };
        let share = (part - 0.5).abs() as f32;
        (number, self.outside[number] * (1.0 - share) + self.outside[other] * share)
    }

    /// Sectors whose residual is above that of even ones, or that have no contrast.
    pub fn unlikely(&self, sums: &Sums) -> Vec<bool> {
        let mean = |&(count, squares, _): &(f64, f64, f64)| squares / f64::max(3.0 * count, 1.0);
        let mut means: Vec<f64> = sums.by_sector.iter().filter(|sector| sector.0 > 0.0).map(mean).collect();
        means.sort_by(f64::total_cmp);
        let even = means.get((means.len() as f64 * EVEN_SECTORS) as usize).copied().unwrap_or(0.0).max(LEAST_VARIANCE);
        // How far beyond what noise explains; without contrast there is no edge.
        let excess = |sector: &(f64, f64, f64)| {
            let (count, contrast2) = (sector.0.max(1.0), sector.2 / sector.0.max(1.0));
            let has_edge = sector.0 > 0.0 && contrast2 > LEAST_CONTRAST * LEAST_CONTRAST;
            if has_edge {
                mean(sector) / (even * (1.0 + UNLIKELY * (2.0 / (3.0 * count)).sqrt()))
            } else {
                f64::INFINITY
            }
        };
        let excesses: Vec<f64> = sums.by_sector.iter().map(excess).collect();
        let mut sorted = excesses.clone();
        sorted.sort_by(f64::total_cmp);
        // Where most are disturbed the least disturbed stay, and their residual makes the standard deviation.
        let limit = sorted[(sorted.len() as f64 * KEPT_SECTORS) as usize].clamp(1.0, f64::MAX);
        excesses.iter().map(|excess| *excess > limit).collect()
    }
}

/// How much each sector counts, from the variances of their backgrounds: an edge that crosses one may come to lie in its neighbours on the
/// way to the disc.
fn trust(variances: &[f64]) -> Vec<f64> {
    let mut sorted = variances.to_vec();
    sorted.sort_by(f64::total_cmp);
    let noise = sorted[((sorted.len() - 1) as f64 * EVEN_SECTORS) as usize] + SHADING * SHADING;
    let count = variances.len();
    let even = |i: usize| noise / (noise + (variances[i % count] - 2.0 * noise).max(0.0));
    (0..count).map(|i| even(i).min(even(i + 1)).min(even(i + count - 1)).powi(2)).collect()
}

/// Number of the sector of a direction and where in it, 0 to 1.
fn sector(turn: f64, sectors: usize) -> (usize, f64) {
    let at = turn * sectors as f64;
    ((at as usize).min(sectors - 1), at.fract())
}

/// The plane through the light of a disc's inside; pixels of something else (an occluder) are left out.
fn plane_of_light(inner: &[&Sample], centre: &Vector) -> Option<[Vector3<f32>; 3]> {
    let median = [0, 1, 2].map(|channel| {
        let mut values: Vec<f32> = inner.iter().map(|sample| sample.light[channel]).collect();
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f32::total_cmp).1
    });
    let median = Vector3::from(median);
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Matrix3::<f64>::zeros();
    let mut count = 0;
    for sample in inner.iter().filter(|sample| f64::from((sample.light - median).amax()) < ALIKE) {
        let step = sample.at - centre;
        let row = Vector3::new(1.0, step.x, step.y);
        normal += row * row.transpose();
        right += row * sample.light.cast::<f64>().transpose();
        count += 1;
    }
    // Few pixels have a mean and no slope.
    if count < 12 {
        return Some([median, Vector3::zeros(), Vector3::zeros()]);
    }
    let found = normal.cholesky()?.solve(&right);
    Some([0, 1, 2].map(|i| found.row(i).transpose().cast::<f32>()))
}
