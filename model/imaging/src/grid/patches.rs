//! Detection of patches that are darker or lighter than their surroundings. Round patches count as dots.

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
/// Range of the area of an elliptic patch, divided by the area of the ellipse with the same second moments. Even for an ellipse, the ratio differs from 1,
/// because patches consist of whole pixels.
const FULLNESS: [f64; 2] = [0.85, 1.15];
/// An ellipse is a dot only if the ratio of its axes is at most this, about the ratio of a disc seen at 70 degrees from its normal.
const LONGEST: f64 = 3.0;
/// At most this number of round patches, and of other patches, is considered, in raster order. An image with more patches shows something other than
/// a calibration grid.
const MOST_DOTS: usize = 6000;

/// A patch, described by an ellipse.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dot {
    /// Centre of the patch, px.
    pub pixel: Pixel,
    /// Radius of a disc with the patch's area, px.
    pub radius_px: f64,
    /// Linear map of image vectors that makes a slanted dot round: the inverse square root of the patch's second moments, scaled to determinant 1.
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

/// Finds the patches of an image that are darker or lighter than the mean of the block around each pixel. `block_px` is half the side of a block, px;
/// `are_dark` selects dark patches.
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
        patches[number - 1].add(Pixel::new(f64::from(u), f64::from(v)));
    }
    let largest = LARGEST_SHARE * f64::from(grey.width()) * f64::from(grey.height());
    patches.retain(|patch| (LEAST_AREA..=largest).contains(&patch.area));
    let (mut dots, mut others): (Vec<Moments>, Vec<Moments>) = patches.iter().partition(|patch| patch.is_round());
    dots.truncate(MOST_DOTS);
    others.truncate(MOST_DOTS);
    let [dots, others] = [dots, others].map(|patches| patches.iter().map(Moments::ellipse).collect());
    Patches { dots, others }
}

/// Area (px^2) and sums of the positions and of their squares over the pixels of a patch.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    area: f64,
    first: Pixel,
    second: Matrix2<f64>,
}

impl Moments {
    fn add(&mut self, at: Pixel) {
        self.area += 1.0;
        self.first += at;
        self.second += at * at.transpose();
    }

    /// Second moments about the centre, px^2, including the extent of each pixel (1/12).
    fn about_middle(&self) -> Matrix2<f64> {
        let middle = self.first / self.area;
        self.second / self.area - middle * middle.transpose() + Matrix2::<f64>::identity() / 12.0
    }

    fn is_round(&self) -> bool {
        let axes = self.about_middle().symmetric_eigenvalues();
        // For a patch without extent, the result is not a number, and no range contains it.
        let fullness = self.area / (4.0 * std::f64::consts::PI * axes.product().sqrt());
        (FULLNESS[0]..=FULLNESS[1]).contains(&fullness) && axes.max() <= LONGEST * LONGEST * axes.min()
    }

    fn ellipse(&self) -> Dot {
        let axes = self.about_middle().symmetric_eigen();
        let mean = axes.eigenvalues.product().powf(0.25);
        let scales = axes.eigenvalues.map(|variance| mean / variance.sqrt());
        let upright = axes.eigenvectors * Matrix2::from_diagonal(&scales) * axes.eigenvectors.transpose();
        Dot { pixel: self.first / self.area, radius_px: (self.area / std::f64::consts::PI).sqrt(), upright }
    }
}
