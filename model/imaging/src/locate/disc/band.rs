//! The pixels about an edge, and sums over these pixels for the least-squares equations of the edge.

use super::plane_map::{Pixels, PlaneMap, Polar, turn};
use super::shades::Shades;
use super::sums::{SectorSums, Sums};
use super::{BAND, Edge, PARTS, UNKNOWNS};
use finray_model::Vector;
use nalgebra::{SMatrix, SVector};

/// Number of channels: one for brightness, two for colour.
const CHANNELS: [f64; PARTS] = [1.0, 2.0];

/// The pixels about an edge, one list per quantity, with the modelled light of background and disc at each pixel.
#[derive(Debug, Clone, Default)]
pub(super) struct Band {
    /// Signed distance of each pixel from the edge at which the pixels were gathered, px; positive outside the disc.
    outside: Vec<f32>,
    /// Decrease of `outside` per displacement of the edge's centre along each axis of the map. `px` is the decrease of `outside` per increase of the
    /// edge's radius. `nearer` and `px` are in px per map unit.
    nearer: [Vec<f32>; 2],
    px: Vec<f32>,
    sector: Vec<u32>,
    /// For brightness and for colour, three values per pixel: squared contrast, contrast times light above background, and squared light above background.
    light: [[Vec<f32>; 3]; PARTS],
    /// For brightness and for colour at the last edge, three values per pixel. The first value is the disc's share of the pixel's light. The second
    /// value is the increase of this share per px by which the edge moves outwards. The third value is the second value times the pixel's distance
    /// outside the edge in units of the blur.
    share: [[Vec<f32>; 3]; PARTS],
    edge: Edge,
}

impl Band {
    /// Gathers the pixels about an edge, with the modelled light of background and disc at each pixel.
    pub fn gather(&mut self, pixels: &Pixels, map: &PlaneMap, edge: &Edge, shades: &Shades) {
        let Band { outside, nearer, px, sector, light, share, .. } = self;
        let lists = nearer.iter_mut().chain(light.iter_mut().flatten()).chain([&mut *outside, &mut *px]);
        lists.for_each(Vec::clear);
        sector.clear();
        let polar = map.about_edge(edge);
        let band = edge.band() as f32;
        for (i, &d) in pixels.outside.iter().enumerate().filter(|(_, d)| d.abs() <= band) {
            let [x, y] = [pixels.at[0][i], pixels.at[1][i]];
            let Polar { step, far, along } = polar.of(x, y);
            let (number, background) = shades.outside_at(turn(step));
            let disc = shades.inside_at(step);
            outside.push(d);
            nearer[0].push(step[0] / along);
            nearer[1].push(step[1] / along);
            px.push(far / along);
            sector.push(number);
            let mut of_part = [[0.0; 3]; PARTS];
            for k in 0..3 {
                let [contrast, light] = [disc[k] - background[k], pixels.light[k][i] - background[k]];
                let part = &mut of_part[k.min(1)];
                part[0] += contrast * contrast;
                part[1] += contrast * light;
                part[2] += light * light;
            }
            for (list, value) in light.iter_mut().flatten().zip(of_part.iter().flatten()) {
                list.push(*value);
            }
        }
        share.iter_mut().flatten().for_each(|list| list.resize(outside.len(), 0.0));
        self.edge = *edge;
    }

    /// Computes the sums at the current edge, which is close to the edge at which the pixels were gathered. `trust` is the weight of each sector's pixels. If
    /// the outline is known (`IS_OUTLINE_OPEN` is false), the normal matrix omits radius and blur.
    pub fn sum<const IS_OUTLINE_OPEN: bool>(
        &mut self,
        edge: &Edge,
        weights: [f64; PARTS],
        trust: &[f32],
        sums: &mut Sums,
    ) {
        for part in 0..PARTS {
            self.shares(edge, part);
        }
        sums.by_sector.clear();
        sums.by_sector.resize(trust.len(), SectorSums::default());
        sums.channels = weights.iter().zip(CHANNELS).filter(|(weight, _)| **weight > 0.0).map(|(_, of)| of).sum();
        let weights = weights.map(|weight| weight as f32);
        let count = self.outside.len();
        let [light_y, light_c] = self.light.each_ref().map(|lists| lists.each_ref().map(|list| &list[..count]));
        let [share_y, share_c] = self.share.each_ref().map(|lists| lists.each_ref().map(|list| &list[..count]));
        let [x, y] = self.nearer.each_ref().map(|list| &list[..count]);
        let (px, sector) = (&self.px[..count], &self.sector[..count]);
        // Sums of products of the derivatives by centre (x, y), radius (r) and blurs (b). `together` contains xx, xy, yy, xr, yr, rr; `with_blur`
        // contains xb, yb, rb, bb for each blur.
        let mut together = [0.0_f64; 6];
        let mut with_blur = [[0.0_f64; 4]; PARTS];
        let mut pulls = [0.0_f64; 3 + PARTS];
        let mut totals = [0.0_f64; 3 + PARTS];
        for i in 0..count {
            let of_sector = &mut sums.by_sector[sector[i] as usize];
            let trusted = trust[sector[i] as usize];
            let row = [x[i], y[i], px[i]];
            let (mut steepness2, mut pull, mut stiff_outwards) = (0.0, 0.0, 0.0);
            let (mut squared, mut contrast2) = (0.0, 0.0);
            for (part, (light, share)) in [(light_y, share_y), (light_c, share_c)].into_iter().enumerate() {
                let [own, with, other] = light.map(|list| list[i]);
                let [covered, steepness, widening] = share.map(|list| list[i]);
                let weight = weights[part];
                // Squared residual, and product of residual and contrast.
                let residual2 = other - covered * (2.0 * with - covered * own);
                let along = weight * (with - covered * own);
                squared += weight * residual2;
                contrast2 += weight * own;
                pull += along * steepness;
                let stiff = weight * own * trusted;
                steepness2 += stiff * steepness * steepness;
                stiff_outwards += weight * own * steepness * steepness;
                if IS_OUTLINE_OPEN {
                    let both = stiff * steepness * widening;
                    for (sum, row) in with_blur[part].iter_mut().zip(row) {
                        *sum += f64::from(both * row);
                    }
                    with_blur[part][3] += f64::from(stiff * widening * widening);
                    pulls[3 + part] += f64::from(along * widening * trusted);
                }
                totals[3 + part] += f64::from(residual2 * trusted);
            }
            let outwards = [pull * row[2], stiff_outwards * row[2] * row[2]];
            let pull = pull * trusted;
            let products =
                [row[0] * row[0], row[0] * row[1], row[1] * row[1], row[0] * row[2], row[1] * row[2], row[2] * row[2]];
            let wanted = if IS_OUTLINE_OPEN { 6 } else { 3 };
            for (sum, product) in together.iter_mut().zip(products).take(wanted) {
                *sum += f64::from(steepness2 * product);
            }
            let pulled = row.map(|row| pull * row);
            for (sum, pulled) in pulls.iter_mut().zip(pulled) {
                *sum += f64::from(pulled);
            }
            for (total, value) in totals.iter_mut().zip([trusted, squared * trusted, contrast2 * trusted]) {
                *total += f64::from(value);
            }
            of_sector.count += 1.0;
            of_sector.squares += squared;
            of_sector.contrast2 += contrast2;
            of_sector.pull.x += pulled[0];
            of_sector.pull.y += pulled[1];
            for (sum, value) in of_sector.outwards.iter_mut().zip(outwards) {
                *sum += value;
            }
            for (sum, product) in of_sector.stiffness.iter_mut().zip(products) {
                *sum += steepness2 * product;
            }
        }
        sums.normal = normal_matrix(together, with_blur);
        sums.gradient = SVector::from(pulls);
        let [count, squares, weight, brightness, colour] = totals;
        (sums.count, sums.squares, sums.weight) = (count, squares, weight);
        sums.noise = [brightness, colour / 2.0];
    }

    /// Computes the disc's share of the light of each pixel at the current edge.
    fn shares(&mut self, edge: &Edge, part: usize) {
        let count = self.outside.len();
        let shift = if part == 1 { edge.colour_shift } else { Vector::zeros() };
        let moved = edge.centre + shift - self.edge.centre;
        let [moved_x, moved_y] = [moved.x as f32, moved.y as f32];
        let grown = (edge.radius - self.edge.radius) as f32;
        let sharp = (1.0 / edge.blurs[part]) as f32;
        let [x, y] = self.nearer.each_ref().map(|list| &list[..count]);
        let (outside, px) = (&self.outside[..count], &self.px[..count]);
        let [covered, steepness, widening] = self.share[part].each_mut().map(|list| &mut list[..count]);
        for i in 0..count {
            let d = (outside[i] - (x[i] * moved_x + y[i] * moved_y + px[i] * grown)) * sharp;
            let (share, density) = normal_distribution(-d);
            covered[i] = share;
            steepness[i] = density * sharp;
            widening[i] = density * sharp * d;
        }
    }
}

/// Normal matrix of the edge's unknowns; `together` contains the entries of centre and radius, and `with_blur` contains the entries of each blur.
fn normal_matrix(together: [f64; 6], with_blur: [[f64; 4]; PARTS]) -> SMatrix<f64, UNKNOWNS, UNKNOWNS> {
    let [xx, xy, yy, xr, yr, rr] = together;
    let [[xb, yb, rb, bb], [xc, yc, rc, cc]] = with_blur;
    #[rustfmt::skip]
    let normal = SMatrix::from_row_slice(&[
        xx, xy, xr, xb, xc,
        xy, yy, yr, yb, yc,
        xr, yr, rr, rb, rc,
        xb, yb, rb, bb, 0.0,
        xc, yc, rc, 0.0, cc,
    ]);
    normal
}

/// Normal distribution function, accurate to 1e-6, and its density. The distribution function and the density are cut off at [`BAND`], where the edge
/// ends.
///
/// # Reference
/// Abramowitz and Stegun, Handbook of Mathematical Functions, 26.2.17.
#[inline]
pub(super) fn normal_distribution(x: f32) -> (f32, f32) {
    let far = x.abs();
    let t = 1.0 / (1.0 + 0.231_641_9 * far);
    let polynomial = t * (0.319_381_53 + t * (-0.356_563_78 + t * (1.781_477_9 + t * (-1.821_256 + t * 1.330_274_4))));
    // exp(-x^2 / 2) as the eighth power of a short series.
    let v = -x * x / 16.0;
    let root = 1.0 + v * (1.0 + v * (0.5 + v * (1.0 / 6.0 + v * (1.0 / 24.0 + v * (1.0 / 120.0)))));
    let (squared, inverse_root_of_tau) = (root * root, 0.398_942_3);
    let density = squared * squared * squared * squared * inverse_root_of_tau;
    let is_edge = far <= BAND as f32;
    let (tail, density) = if is_edge { (density * polynomial, density) } else { (0.0, 0.0) };
    (if x > 0.0 { 1.0 - tail } else { tail }, density)
}
