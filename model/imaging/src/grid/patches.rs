//! Patches that are darker or lighter than their surroundings; round ones are selected as dots.

use finray_model::camera::Pixel;
use image::{GrayImage, Luma};
use imageproc::contrast::adaptive_threshold;
use imageproc::region_labelling::{Connectivity, connected_components};
use nalgebra::Matrix2;

/// A patch differs from its surroundings by at least this contrast, grey levels.
const CONTRAST: i32 = 10;
/// A patch with a smaller area than this, px^2, is ignored.
const LEAST_AREA: f64 = 12.0;
/// A patch with a larger area than this, as a share of the image, is ignored.
const LARGEST_SHARE: f64 = 0.02;
/// Range of the area of an elliptic patch, divided by the area of the ellipse with the same second moments. The ratio deviates from 1 because of the pixels.
const FULLNESS: [f64; 2] = [0.85, 1.15];
/// An ellipse is a dot only if the ratio of its axes is at most this: the ratio of a disc seen at 70 degrees.
const LONGEST: f64 = 3.0;
/// At most this number of patches is considered, in raster order. An image with more patches shows something else.
const MOST_DOTS: usize = 6000;

/// A patch, described by an ellipse.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dot {
    /// Centre of the patch, px.
    pub pixel: Pixel,
    /// Radius of a disc with the patch's area, px.
    pub radius_px: f64,
    /// Transforms steps in the image to steps in which a slanted dot is round: the inverse square root of the patch's second moments, scaled to determinant
    /// 1.
    pub upright: Matrix2<f64>,
}

impl Dot {
    /// First-order distance of a pixel from the rim of the ellipse, px; negative inside.
    pub fn distance_px(&self, at: &Pixel) -> f64 {
        let round = self.upright * (at - self.pixel);
        let (far, slope) = (round.norm(), (self.upright * round).norm());
        if slope > 0.0 { (far - self.radius_px) * far / slope } else { -self.radius_px }
    }

    /// Longer half axis of the ellipse, px.
    pub fn longer_px(&self) -> f64 {
        self.radius_px / self.upright.symmetric_eigenvalues().min()
    }
}

/// The patches of an image.
#[derive(Debug, Clone, Default)]
pub(super) struct Patches {
    /// Patches that are round.
    pub dots: Vec<Dot>,
    /// Other patches of suitable size, for instance dots that the image border cuts or that are partly covered.
    pub others: Vec<Dot>,
}

/// Finds the patches of an image that differ from the mean brightness of blocks. `block_px` is half the side of a block, px; `are_dark` selects dark patches.
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

/// Area (px^2) and first and second moments of a patch, in px.
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

    /// Second moments about the centre (uu, uv, vv), px^2, including those of the pixels themselves (1/12).
    fn about_middle(&self) -> [f64; 3] {
        let m = self.middle();
        let of = |sum: f64, product: f64, own: f64| sum / self.area - product + own / 12.0;
        [of(self.second[0], m.x * m.x, 1.0), of(self.second[1], m.x * m.y, 0.0), of(self.second[2], m.y * m.y, 1.0)]
    }

    /// The transform of [`Dot::upright`].
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
