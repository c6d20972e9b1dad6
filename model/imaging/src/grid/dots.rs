//! Round patches that are darker or lighter than their surroundings.

use finray_model::camera::Pixel;
use image::{GrayImage, Luma};
use imageproc::contrast::adaptive_threshold;
use imageproc::region_labelling::{Connectivity, connected_components};
use nalgebra::Matrix2;

/// Smallest difference to the surroundings, grey levels.
const CONTRAST: i32 = 10;
/// Smallest patch, px, and largest as a share of the image.
const LEAST_AREA: f64 = 12.0;
const LARGEST_SHARE: f64 = 0.02;
/// Area over that of the ellipse with the same second moments, of a patch that is an ellipse but for its pixels.
const FULLNESS: [f64; 2] = [0.85, 1.15];
/// Largest ratio of an ellipse's axes: a disc seen at 70 degrees.
const LONGEST: f64 = 3.0;
/// Reach of the light that belongs to a dot, and from where on its surroundings are seen, in its radii and px beyond.
const OWN: (f64, f64) = (1.15, 2.5);
const AROUND: (f64, f64) = (1.35, 4.5);
/// Part of a dot's shorter half axis within which its light is even.
const INNER: f64 = 0.6;
/// Patches beyond this many, the first in the image, are left: an image of something else.
const MOST_DOTS: usize = 6000;

/// A dot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dot {
    /// The middle of its light.
    pub pixel: Pixel,
    /// Radius of a disc of its area, px.
    pub radius_px: f64,
    /// Turns steps in the image into steps in which a slanted dot is round: the inverse square root of its second moments, of determinant 1.
    pub upright: Matrix2<f64>,
}

/// Round patches of an image.
pub(super) fn dots(grey: &GrayImage, block_px: u32, are_dark: bool) -> Vec<Dot> {
    if 2 * block_px >= grey.width().min(grey.height()) {
        return Vec::new();
    }
    let threshold = adaptive_threshold(grey, block_px, if are_dark { CONTRAST } else { -CONTRAST });
    let background = if are_dark { 255 } else { 0 };
    let labels = connected_components(&threshold, Connectivity::Four, Luma([background]));
    let mut patches: Vec<Moments> = Vec::new();
    for (u, v, label) in labels.enumerate_pixels().filter(|(_, _, label)| label.0[0] > 0) {
        let number = label.0[0] as usize;
        if patches.len() < number {
            patches.resize(number, Moments::default());
        }
        patches[number - 1].add(f64::from(u), f64::from(v));
    }
    let largest = LARGEST_SHARE * f64::from(grey.width()) * f64::from(grey.height());
    let round = patches.iter().filter(|patch| patch.is_round(largest)).take(MOST_DOTS);
    round.filter_map(|patch| patch.measured(grey)).collect()
}

/// Area and moments of a patch.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    area: f64,
    first: [f64; 2],
    second: [f64; 3],
}

impl Moments {
    fn add(&mut self, u: f64, v: f64) {
        self.area += 1.0;
        self.first = [self.first[0] + u, self.first[1] + v];
        self.second = [self.second[0] + u * u, self.second[1] + u * v, self.second[2] + v * v];
    }

    fn middle(&self) -> Pixel {
        Pixel::from(self.first) / self.area
    }

    /// Second moments about the middle, a pixel's own (1/12) included.
    fn about_middle(&self) -> [f64; 3] {
        let m = self.middle();
        let of = |sum: f64, product: f64, own: f64| sum / self.area - product + own / 12.0;
        [of(self.second[0], m.x * m.x, 1.0), of(self.second[1], m.x * m.y, 0.0), of(self.second[2], m.y * m.y, 1.0)]
    }

    /// See [`Dot::upright`].
    fn upright(&self) -> Matrix2<f64> {
        let [uu, uv, vv] = self.about_middle();
        let axes = Matrix2::new(uu, uv, uv, vv).symmetric_eigen();
        let mean = axes.eigenvalues.product().powf(0.25);
        let scales = axes.eigenvalues.map(|variance| mean / variance.sqrt());
        axes.eigenvectors * Matrix2::from_diagonal(&scales) * axes.eigenvectors.transpose()
    }

    fn is_round(&self, largest: f64) -> bool {
        if !(LEAST_AREA..=largest).contains(&self.area) {
            return false;
        }
        let [uu, uv, vv] = self.about_middle();
        let determinant = uu * vv - uv * uv;
        if determinant <= 0.0 {
            return false;
        }
        let fullness = self.area / (4.0 * std::f64::consts::PI * determinant.sqrt());
        let half = (uu + vv) / 2.0;
        let spread = (half * half - determinant).max(0.0).sqrt();
        (FULLNESS[0]..=FULLNESS[1]).contains(&fullness) && half + spread <= LONGEST * LONGEST * (half - spread)
    }

    /// The middle of the light that the surroundings lack or do not have: a plane of light through the surroundings is taken off.
    fn measured(&self, grey: &GrayImage) -> Option<Dot> {
        let radius = (self.area / std::f64::consts::PI).sqrt();
        let middle = self.middle();
        let (own, reach) = (OWN.0 * radius * self.length() + OWN.1, AROUND.0 * radius * self.length() + AROUND.1);
        let (width, height) = (f64::from(grey.width()) - 1.0, f64::from(grey.height()) - 1.0);
        // Without its surroundings a dot at the border would be measured by half.
        if middle.x < reach || middle.y < reach || middle.x > width - reach || middle.y > height - reach {
            return None;
        }
        let mut normal = nalgebra::Matrix3::zeros();
        let mut right = nalgebra::Vector3::zeros();
        let pixels = || {
            let range = |at: f64| (at - reach).ceil() as u32..=(at + reach).floor() as u32;
            range(middle.y).flat_map(move |v| range(middle.x).map(move |u| (u, v)))
        };
        let at = |u: u32, v: u32| Pixel::new(f64::from(u), f64::from(v)) - middle;
        let light = |u: u32, v: u32| f64::from(grey.get_pixel(u, v).0[0]);
        for (u, v) in pixels().filter(|&(u, v)| (own..reach).contains(&at(u, v).norm())) {
            let row = nalgebra::Vector3::new(1.0, at(u, v).x, at(u, v).y);
            normal += row * row.transpose();
            right += row * light(u, v);
        }
        let plane = normal.cholesky()?.solve(&right);
        let (mut mass, mut moment) = (0.0, Pixel::zeros());
        let (mut inner, mut depth) = (0.0, 0.0);
        for (u, v) in pixels().filter(|&(u, v)| at(u, v).norm() < own) {
            // As a share of the light there: light that falls off makes one side of a dot darker, and would shift its middle.
            let ground = plane.dot(&nalgebra::Vector3::new(1.0, at(u, v).x, at(u, v).y));
            let lacking = light(u, v) / ground.max(1.0) - 1.0;
            mass += lacking;
            moment += at(u, v) * lacking;
            if at(u, v).norm() < INNER * radius / self.length() {
                inner += 1.0;
                depth += lacking;
            }
        }
        let shift = moment / mass;
        // The threshold lies anywhere on the blurred edge; light that is missing over its depth in the middle is the area.
        let area = mass * inner / depth;
        let is_good = shift.norm() < 0.5 * radius && (0.5..2.0).contains(&(area / self.area));
        let radius_px = (area / std::f64::consts::PI).sqrt();
        is_good.then(|| Dot { pixel: middle + shift, radius_px, upright: self.upright() })
    }

    /// Ratio of the longer half axis to the radius of a disc of the same area.
    fn length(&self) -> f64 {
        let [uu, uv, vv] = self.about_middle();
        let half = (uu + vv) / 2.0;
        let longer = half + (half * half - (uu * vv - uv * uv)).max(0.0).sqrt();
        (2.0 * longer.sqrt() / (self.area / std::f64::consts::PI).sqrt()).clamp(1.0, LONGEST)
    }
}
