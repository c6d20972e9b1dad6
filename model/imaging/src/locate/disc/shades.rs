//! Light of a disc and of its background.

use super::Edge;
use super::plane_map::{Pixels, PlaneMap, Polar, turn};
use super::sums::{SectorSums, Sums};
use nalgebra::Vector3;

/// Width of the ring about the edge's band from which the background is sampled, px.
pub(super) const BACKGROUND_PX: f64 = 3.0;
/// Length of a sector along the edge, px.
const SECTOR_PX: f64 = 1.3;
/// Smallest and largest number of sectors around the edge.
const SECTORS: [usize; 2] = [12, 96];
/// Share of the sectors that are assumed to have an even background. The scatter of the light in these sectors measures the noise.
const EVEN_SECTORS: f64 = 0.3;
/// Standard deviation of the light that an even background may have in addition to the noise, grey levels.
const SHADING: f32 = 2.0;
/// A pixel inside the disc belongs to an occluder if a component of its light differs from the median by more than this, grey levels.
const ALIKE: f32 = 40.0;
/// The background of a grey disc is uneven if its step between neighbouring sectors, or its scatter within a sector, exceeds a limit. The limit of an
/// uneven background is the root sum of squares of two parts: this share of the contrast, and [`UNEVEN_NOISE`] times the noise.
const UNEVEN_SHARE: f32 = 0.1;
/// Part of the limit of an uneven background that comes from noise, in standard deviations of the noise.
const UNEVEN_NOISE: f32 = 3.0;
/// The light of a ring is sampled at a margin from both of its edges. The margin is at most this share of the ring's width.
const RING_MARGIN: f64 = 0.4;
/// Approximate number of inner pixels that are used; more add no information.
const INSIDE_PIXELS: usize = 400;
/// The median is computed from this number of inner pixels; more add no information.
const MEDIAN_PIXELS: usize = 48;
/// The slope of the light is estimated only from at least this number of pixels.
const SLOPE_PIXELS: usize = 12;
/// A sector is omitted if its contrast over all components of light is below this, grey levels.
pub(super) const LEAST_CONTRAST: f32 = 12.0;
/// A sector does not show the disc's edge if its mean squared residual is too far above the value of even sectors. The largest accepted excess is
/// this number of standard deviations.
const UNLIKELY: f32 = 4.0;
/// Lower bound of the assumed variance of a grey level, in squared grey levels. Rounding alone causes 1/12.
const LEAST_VARIANCE: f32 = 0.5;
/// This share of the sectors, the least disturbed ones, is kept in any case if these sectors have contrast. A disc is rejected if a smaller share of
/// its sectors is kept.
pub(super) const KEPT_SECTORS: f64 = 0.4;

/// Light of the disc and of its background.
#[derive(Debug, Clone, Default)]
pub(super) struct Shades {
    /// Light inside the disc as a linear function of the vector from the centre: constant, slope by x, slope by y.
    inside: [Vector3<f32>; 3],
    /// Light of the background in each sector: brightness and two components of colour, grey levels.
    outside: Vec<Vector3<f32>>,
    /// Weight of each sector's pixels, 0..1. The weight is below 1 if the background varies within the sector, for instance because the edge of a
    /// plate or rib crosses the background.
    pub trust: Vec<f32>,
    /// Sums of the background's light in each sector.
    sectors: Vec<Background>,
    /// Indices of the pixels that lie inside the disc.
    inner: Vec<u32>,
    /// Buffer for the computation of medians.
    sorted: Vec<f32>,
}

/// Light of the background pixels of one sector.
#[derive(Debug, Clone, Copy, Default)]
struct Background {
    /// Number of background pixels.
    count: f32,
    /// Sum of the light of the sector's background pixels: brightness and two components of colour, grey levels.
    light: Vector3<f32>,
    /// Sum of the squared light of the sector's background pixels over all components, in squared grey levels.
    squares: f32,
}

impl Background {
    /// Variance of the light, in squared grey levels.
    fn variance(&self) -> f32 {
        match self.count > 1.0 {
            true => ((self.squares - self.light.norm_squared() / self.count) / (self.count - 1.0)).max(0.0),
            false => 0.0,
        }
    }
}

impl Shades {
    /// Samples the pixels inside and outside an edge. Returns `None` if too few pixels lie inside the edge, or no pixel lies in the background. `grey_inner` is
    /// the inner radius of a grey disc or ring, in the map's units; see [`super::View`].
    pub fn gather(&mut self, pixels: &Pixels, map: &PlaneMap, edge: &Edge, grey_inner: Option<f64>) -> Option<()> {
        let band = edge.band();
        let sectors = ((std::f64::consts::TAU * edge.radius / SECTOR_PX) as usize).clamp(SECTORS[0], SECTORS[1]);
        // In small discs every pixel is blurred, so the middle pixels represent the inside.
        let deepest = |inner: f64| if inner > 0.0 { RING_MARGIN * (edge.radius - inner) } else { 0.5 * edge.radius };
        let inner = grey_inner.unwrap_or(0.0);
        let depth = -band.min(deepest(inner)) as f32;
        let nearest = if inner > 0.0 { inner as f32 - depth } else { 0.0 };
        let background = [band as f32, (band + BACKGROUND_PX) as f32];
        let polar = map.about_edge(edge);
        self.sectors.clear();
        self.sectors.resize(sectors, Background::default());
        self.inner.clear();
        for (i, &d) in pixels.outside.iter().enumerate() {
            if d < depth {
                if nearest == 0.0 || polar.of(pixels.at[0][i], pixels.at[1][i]).far >= nearest {
                    self.inner.push(i as u32);
                }
            } else if d > background[0] && d < background[1] {
                let Polar { step, .. } = polar.of(pixels.at[0][i], pixels.at[1][i]);
                let light = Vector3::new(pixels.light[0][i], pixels.light[1][i], pixels.light[2][i]);
                let sector = &mut self.sectors[sector(turn(step), sectors).0];
                sector.count += 1.0;
                sector.light += light;
                sector.squares += light.norm_squared();
            }
        }
        if self.inner.len() < 3 {
            return None;
        }
        self.find_inside(pixels, edge)?;
        self.find_outside()?;
        match grey_inner {
            Some(_) => self.trust_even(),
            None => self.find_trust(),
        }
        Some(())
    }

    fn find_outside(&mut self) -> Option<()> {
        let count = self.sectors.len();
        self.outside.clear();
        for i in 0..count {
            // A sector without pixels, at the image border, gets the background of its nearest neighbour.
            let seen = |k: usize| self.sectors[k % count].count > 0.0;
            let beside = |away: &usize| seen(i + away) || seen(i + count - away);
            let away = (0..=count / 2).find(beside)?;
            let Background { count: pixels, light, .. } = if seen(i + away) {
                self.sectors[(i + away) % count]
            } else {
                self.sectors[(i + count - away) % count]
            };
            self.outside.push(light / pixels);
        }
        Some(())
    }

    /// Noise variance, in squared grey levels: the largest variance among the sectors with the most even backgrounds, whose share is
    /// [`EVEN_SECTORS`].
    fn noise(&mut self) -> f32 {
        self.sorted.clear();
        self.sorted.extend(self.sectors.iter().map(Background::variance));
        let at = ((self.sorted.len() - 1) as f64 * EVEN_SECTORS) as usize;
        *self.sorted.select_nth_unstable_by(at, f32::total_cmp).1
    }

    /// Computes the weights of the sectors. The larger the variance of a sector's background, the smaller is the sector's weight.
    fn find_trust(&mut self) {
        let noise = self.noise() + SHADING * SHADING;
        let even = |sector: &Background| noise / (noise + (sector.variance() - 2.0 * noise).max(0.0));
        self.trust.clear();
        self.trust.extend(self.sectors.iter().map(|sector| even(sector).powi(2)));
    }

    /// Computes the weights for grey discs: 1 only where the background is even, both within sectors and between neighbouring sectors. If a strip of
    /// the background crosses the edge at a slant, or ends outside the edge, the background at the edge differs from the background farther out. The
    /// blurred edge of a strip in the background also affects the neighbouring sectors.
    fn trust_even(&mut self) {
        let (count, noise) = (self.sectors.len(), self.noise());
        self.sorted.clear();
        self.sorted.extend(self.outside.iter().map(|light| (light - self.inside[0]).norm()));
        let contrast = *self.sorted.select_nth_unstable_by(count / 2, f32::total_cmp).1;
        let limit = (UNEVEN_SHARE * contrast).powi(2) + UNEVEN_NOISE * UNEVEN_NOISE * noise;
        self.trust.clear();
        self.trust.resize(count, 1.0);
        for i in 0..count {
            let next = (i + 1) % count;
            let is_step = (self.outside[next] - self.outside[i]).norm_squared() > limit;
            let scatters = self.sectors[i].variance() > limit;
            if is_step || scatters {
                let last = if is_step { next + 1 } else { next };
                [i + count - 1, i, next, last].into_iter().for_each(|k| self.trust[k % count] = 0.0);
            }
        }
    }

    /// Fits a plane to the brightness inside the disc, and applies the relative slope of this plane to colour as well. Omits pixels of an occluder.
    fn find_inside(&mut self, pixels: &Pixels, edge: &Edge) -> Option<()> {
        let mut median = [0.0; 3];
        for (median, light) in median.iter_mut().zip(&pixels.light) {
            self.sorted.clear();
            let stride = (self.inner.len() / MEDIAN_PIXELS).max(1);
            self.sorted.extend(self.inner.iter().step_by(stride).map(|&i| light[i as usize]));
            let middle = self.sorted.len() / 2;
            *median = *self.sorted.select_nth_unstable_by(middle, f32::total_cmp).1;
        }
        let centre = [edge.centre.x as f32, edge.centre.y as f32];
        // Sums of 1, x, y, xx, xy, yy; of brightness times 1, x, y; and of each colour component.
        let mut moments = [0.0_f64; 6];
        let mut brightness = [0.0_f64; 3];
        let mut colour = [0.0_f64; 2];
        let mut count = 0;
        for &i in self.inner.iter().step_by((self.inner.len() / INSIDE_PIXELS).max(1)) {
            let i = i as usize;
            let light = [pixels.light[0][i], pixels.light[1][i], pixels.light[2][i]];
            if (0..3).any(|k| (light[k] - median[k]).abs() >= ALIKE) {
                continue;
            }
            let [x, y] = [f64::from(pixels.at[0][i] - centre[0]), f64::from(pixels.at[1][i] - centre[1])];
            for (sum, term) in moments.iter_mut().zip([1.0, x, y, x * x, x * y, y * y]) {
                *sum += term;
            }
            let light = light.map(f64::from);
            for (sum, term) in brightness.iter_mut().zip([1.0, x, y]) {
                *sum += light[0] * term;
            }
            for (sum, light) in colour.iter_mut().zip(&light[1..]) {
                *sum += light;
            }
            count += 1;
        }
        // Few pixels determine a median, but not a slope.
        if count < SLOPE_PIXELS {
            self.inside = [Vector3::from(median), Vector3::zeros(), Vector3::zeros()];
            return Some(());
        }
        let [n, x, y, xx, xy, yy] = moments;
        let normal = nalgebra::Matrix3::new(n, x, y, x, xx, xy, y, xy, yy).cholesky()?;
        let plane = normal.solve(&Vector3::from(brightness));
        // Illumination scales all channels equally, and compression degrades colour more than brightness. The relative slope of brightness is also
        // used for colour.
        let relative = [plane[1], plane[2]].map(|slope| slope / plane[0].max(1.0));
        let mean = [x / n, y / n];
        let falls_to = 1.0 + relative[0] * mean[0] + relative[1] * mean[1];
        let [first, second] = colour.map(|sum| sum / n / falls_to);
        let middle = Vector3::new(plane[0], first, second);
        self.inside = [1.0, relative[0], relative[1]].map(|share| (middle * share).cast::<f32>());
        Some(())
    }

    #[inline]
    pub fn inside_at(&self, step: [f32; 2]) -> Vector3<f32> {
        self.inside[0] + self.inside[1] * step[0] + self.inside[2] * step[1]
    }

    /// Index of the sector in a direction, and the background in that direction, interpolated between the middles of two sectors.
    #[inline]
    pub fn outside_at(&self, turn: f32) -> (u32, Vector3<f32>) {
        let count = self.outside.len();
        let (number, part) = sector(turn, count);
        let other = match part < 0.5 {
            true => number.checked_sub(1).unwrap_or(count - 1),
            false if number + 1 < count => number + 1,
            false => 0,
        };
        let share = (part - 0.5).abs();
        (number as u32, self.outside[number] * (1.0 - share) + self.outside[other] * share)
    }

    /// Sets the weight of sectors without contrast, or with a larger residual than even sectors, to zero. Returns the share of sectors that are kept.
    pub fn distrust_unlikely(&mut self, sums: &Sums) -> f64 {
        let channels = sums.channels as f32;
        let mean = |of: &SectorSums| of.squares / (channels * of.count).max(1.0);
        self.sorted.clear();
        self.sorted.extend(sums.by_sector.iter().filter(|of| of.count > 0.0).map(mean));
        let at = (self.sorted.len() as f64 * EVEN_SECTORS) as usize;
        let even = match self.sorted.is_empty() {
            true => LEAST_VARIANCE,
            false => self.sorted.select_nth_unstable_by(at, f32::total_cmp).1.max(LEAST_VARIANCE),
        };
        // Ratio of a sector's residual to the limit from the noise; infinite without contrast.
        let excess = |of: &SectorSums| {
            let (count, contrast2) = (of.count.max(1.0), of.contrast2 / of.count.max(1.0));
            let has_edge = of.count > 0.0 && contrast2 > LEAST_CONTRAST * LEAST_CONTRAST;
            if has_edge {
                mean(of) / (even * (1.0 + UNLIKELY * (2.0 / (channels * count)).sqrt()))
            } else {
                f32::INFINITY
            }
        };
        self.sorted.clear();
        self.sorted.extend(sums.by_sector.iter().map(excess));
        let at = (self.sorted.len() as f64 * KEPT_SECTORS) as usize;
        // If most sectors are disturbed, the least disturbed ones are kept. The residual of disturbed sectors that are kept increases the standard
        // deviation of the disc's centre.
        let limit = self.sorted.select_nth_unstable_by(at, f32::total_cmp).1.clamp(1.0, f32::MAX);
        let mut kept = 0;
        for (trust, of) in self.trust.iter_mut().zip(&sums.by_sector) {
            let stays = excess(of) <= limit;
            kept += usize::from(stays);
            if !stays {
                *trust = 0.0;
            }
        }
        kept as f64 / self.trust.len() as f64
    }
}

/// Index of the sector in a direction, and the position within that sector, 0..1.
#[inline]
fn sector(turn: f32, sectors: usize) -> (usize, f32) {
    let at = turn * sectors as f32;
    let number = (at as usize).min(sectors - 1);
    (number, at - number as f32)
}
