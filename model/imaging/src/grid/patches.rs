//! Patches that are darker or lighter than their surroundings, and which of them are round.

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
/// Patches beyond this many, the first in the image, are left: an image of something else.
const MOST_DOTS: usize = 6000;

/// A patch as an ellipse.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dot {
    /// Its middle.
    pub pixel: Pixel,
    /// Radius of a disc of its area, px.
    pub radius_px: f64,
    /// Turns steps in the image into steps in which a slanted dot is round: the inverse square root of its second moments, of determinant 1.
    pub upright: Matrix2<f64>,
}

impl Dot {
    /// Distance of a pixel from the rim, px, to first order: negative inside.
    pub fn distance_px(&self, at: &Pixel) -> f64 {
        let round = self.upright * (at - self.pixel);
        let (far, slope) = (round.norm(), (self.upright * round).norm());
        if slope > 0.0 { (far - self.radius_px) * far / slope } else { -self.radius_px }
    }

    /// The longer half axis, px.
    pub fn longer_px(&self) -> f64 {
        self.radius_px / self.upright.symmetric_eigenvalues().min()
    }
}

/// Patches of an image.
#[derive(Debug, Clone, Default)]
pub(super) struct Patches {
    /// The round ones.
    pub dots: Vec<Dot>,
    /// The others of their size: dots that the border of the image cuts, or that something covers in part.
    pub others: Vec<Dot>,
}

/// The patches of an image against a mean over blocks.
pub(super) fn patches(grey: &GrayImage, block_px: u32, are_dark: bool) -> Patches {
    if 2 * block_px >= grey.width().min(grey.height()) {
        return Patches::default();
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
    patches.retain(|patch| (LEAST_AREA..=largest).contains(&patch.area));
    let (mut dots, mut others): (Vec<Moments>, Vec<Moments>) = patches.iter().partition(|patch| patch.is_round());
    dots.truncate(MOST_DOTS);
    others.truncate(MOST_DOTS);
    let [dots, others] = [dots, others].map(|patches| patches.iter().map(Moments::ellipse).collect());
    Patches { dots, others }
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

    fn is_round(&self) -> bool {
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

    fn ellipse(&self) -> Dot {
        let radius_px = (self.area / std::f64::consts::PI).sqrt();
        Dot { pixel: self.middle(), radius_px, upright: self.upright() }
    }
}
