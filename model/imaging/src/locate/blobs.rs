//! Candidates for coloured markers: patches of the markers' colours, found on a coarse grid of pixels and refined in the full image.

use super::colour::Colours;
use crate::RgbRows;
use finray_model::camera::Pixel;
use finray_model::finger::Plate;
use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};

/// Number of grid cells per marker radius. With this number, the patch of a marker has about 28 cells.
const ACROSS_RADIUS: f64 = 3.0;
/// Range of a patch's area relative to a marker's area. A smaller patch is more than half hidden or not a marker; a larger patch is not a single marker.
const AREA: [f64; 2] = [0.3, 1.8];
/// At most this number of patches is considered, the largest first. An image with more patches shows something other than a finger's markers.
const MOST_BLOBS: usize = 400;

/// An image is rejected if its markers have a smaller radius than this, px, because every pixel of such a marker is blurred.
pub(super) const LEAST_RADIUS_PX: f64 = 2.5;
/// Patches can be markers of equal size at different distances from the camera only if the ratio of the patches' radii is at most this.
const ALIKE: f64 = 1.4;

/// A patch of a marker's colour.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blob {
    /// Plate to which the colour belongs.
    pub side: Plate,
    /// Centre of the patch's pixels, px.
    pub centre: Pixel,
}

/// Patches of about a marker's size; `radius_px` is the expected radius of a marker, px.
pub(super) fn blobs(image: &dyn RgbRows, colours: &Colours, radius_px: f64) -> Vec<Blob> {
    let stride = ((radius_px / ACROSS_RADIUS) as u32).max(1);
    let whole = std::f64::consts::PI * (radius_px / f64::from(stride)).powi(2);
    // One cell more or less changes the area of a small marker considerably, so a deviation of one cell is allowed.
    let fits = |patch: &Patch| {
        let cells = f64::from(patch.cells);
        cells + 1.0 >= AREA[0] * whole && cells - 1.0 <= AREA[1] * whole
    };
    let mut blobs: Vec<(u32, Blob)> = Vec::new();
    let mut buffer = Vec::new();
    for patch in patches(image, colours, stride).iter().filter(|patch| fits(patch)) {
        let rough = patch.sum / f64::from(patch.cells) * f64::from(stride);
        let side = if patch.value == 1 { Plate::Front } else { Plate::Back };
        if let Some(centre) = middle_of_colour(image, colours, side, &rough, 1.5 * radius_px, &mut buffer) {
            blobs.push((patch.cells, Blob { side, centre }));
        }
    }
    blobs.sort_by_key(|(cells, _)| std::cmp::Reverse(*cells));
    blobs.truncate(MOST_BLOBS);
    blobs.into_iter().map(|(_, blob)| blob).collect()
}

/// Most common radius of the patches, px, where each patch counts as a disc of equal area; and the number of patches with about this radius. `None`
/// if no patch is large enough.
pub(super) fn commonest_radius(image: &dyn RgbRows, colours: &Colours) -> Option<(f64, usize)> {
    const STRIDE: u32 = 2;
    let radius = |patch: &Patch| (f64::from(patch.cells) / std::f64::consts::PI).sqrt() * f64::from(STRIDE);
    let mut radii: Vec<f64> =
        patches(image, colours, STRIDE).iter().map(radius).filter(|radius| *radius >= LEAST_RADIUS_PX).collect();
    radii.sort_by(f64::total_cmp);
    // Median of the largest group of patches with similar radii.
    let group = |from: usize| radii[from..].partition_point(|radius| *radius < ALIKE * radii[from]);
    let (from, count) = (0..radii.len()).map(|from| (from, group(from))).max_by_key(|(_, count)| *count)?;
    Some((radii[from + count / 2], count))
}

/// Patches of one colour on the grid that consists of every `stride`-th pixel.
fn patches(image: &dyn RgbRows, colours: &Colours, stride: u32) -> Vec<Patch> {
    let size_px = image.size_px();
    let [width, height] = size_px.map(|px| px.div_ceil(stride));
    let mut grid = GrayImage::new(width, height);
    let mut buffer = Vec::new();
    for (row, cells) in grid.rows_mut().enumerate() {
        let pixels = image.row(row * stride as usize, 0..size_px[0] as usize, &mut buffer);
        for (cell, pixel) in cells.zip(pixels.chunks_exact(3).step_by(stride as usize)) {
            let side = colours.side_of(&[pixel[0], pixel[1], pixel[2]]);
            *cell = Luma([side.map_or(0, |side| 1 + side as u8)]);
        }
    }
    let labels = connected_components(&grid, Connectivity::Eight, Luma([0]));
    let mut patches: Vec<Patch> = Vec::new();
    for (x, y, label) in labels.enumerate_pixels().filter(|(_, _, label)| label.0[0] > 0) {
        let number = label.0[0] as usize;
        if patches.len() < number {
            patches.resize(number, Patch::default());
        }
        let patch = &mut patches[number - 1];
        patch.value = grid.get_pixel(x, y).0[0];
        patch.cells += 1;
        patch.sum += Pixel::new(f64::from(x), f64::from(y));
    }
    patches
}

/// Centre of the pixels of one colour within `reach` px of the pixel `about`; `None` without such pixels. `buffer` is used for the pixels of a row.
pub(super) fn middle_of_colour(
    image: &dyn RgbRows,
    colours: &Colours,
    side: Plate,
    about: &Pixel,
    reach: f64,
    buffer: &mut Vec<u8>,
) -> Option<Pixel> {
    let within = |axis: usize, size: u32| {
        let from = (about[axis] - reach).ceil().max(0.0);
        let to = (about[axis] + reach).floor().min(f64::from(size) - 1.0);
        (from <= to).then_some((from as usize, to as usize))
    };
    let [width, height] = image.size_px();
    let (columns, rows) = (within(0, width)?, within(1, height)?);
    let (mut count, mut sum) = (0_u64, [0_u64; 2]);
    for v in rows.0..=rows.1 {
        let pixels = image.row(v, columns.0..columns.1 + 1, buffer);
        for (u, pixel) in (columns.0..).zip(pixels.chunks_exact(3)) {
            if colours.side_of(&[pixel[0], pixel[1], pixel[2]]) == Some(side) {
                count += 1;
                sum[0] += u as u64;
                sum[1] += v as u64;
            }
        }
    }
    (count > 0).then(|| Pixel::new(sum[0] as f64 / count as f64, sum[1] as f64 / count as f64))
}

/// Connected cells of the grid with one colour.
#[derive(Debug, Clone, Copy, Default)]
struct Patch {
    /// Number of the plate whose colour the cells have: 1 for the front plate, 2 for the back plate.
    value: u8,
    /// Number of cells in the patch.
    cells: u32,
    /// Sums of the cells' x and y coordinates in the grid.
    sum: Pixel,
}
