//! Chroma samples that several pixels share: their positions, and their interpolation.
//!
//! Interpolation is cubic (Catmull-Rom), because a marker's edge in repeated samples lies up to half a pixel away from its place.
//!
//! # Reference
//! R. G. Keys, Cubic convolution interpolation for digital image processing, IEEE Trans. ASSP 29 (1981), with a = -1/2.

use std::ops::Range;

/// Sum of the weights of an interpolation along one axis.
const ONE: i32 = 128;
/// Interpolated chroma is in units of 1/`FINE` of a sample's step.
pub(super) const FINE: i32 = 16;
/// Number of chroma columns that are interpolated at once.
const BLOCK: usize = 64;

/// Number and position of chroma samples along one axis of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Siting {
    /// One sample for each pixel.
    Each,
    /// One sample for two pixels, in the middle between them.
    Between,
    /// One sample for two pixels, at the first of them.
    First,
}

impl Siting {
    /// Number of samples for a number of pixels.
    pub fn count(self, pixels: usize) -> usize {
        if self == Siting::Each { pixels } else { pixels.div_ceil(2) }
    }

    /// Weights of four consecutive samples at an even (0) or odd (1) pixel p. The second sample has the number p / 2 - 1 for an even pixel between samples,
    /// otherwise p / 2; for one sample a pixel, p.
    fn weights(self, parity: usize) -> [i32; 4] {
        match (self, parity) {
            (Siting::Each, _) | (Siting::First, 0) => [0, ONE, 0, 0],
            (Siting::First, _) => [-8, 72, 72, -8],
            (Siting::Between, 0) => [-3, 29, 111, -9],
            (Siting::Between, _) => [-9, 111, 29, -3],
        }
    }

    /// Number of the first of the four samples at a pixel, plus two.
    fn first_plus_two(self, pixel: usize) -> usize {
        match self {
            Siting::Each => pixel + 1,
            Siting::Between => pixel.div_ceil(2),
            Siting::First => pixel / 2 + 1,
        }
    }
}

/// The two chroma planes of a frame.
pub(super) struct ChromaPlanes<'a> {
    /// Samples of blue and of red, row by row.
    pub planes: [&'a [u8]; 2],
    /// Numbers of columns and rows of each plane.
    pub size: [usize; 2],
    /// Siting across and down.
    pub siting: [Siting; 2],
}

impl ChromaPlanes<'_> {
    /// Calls `set` with blue and red chroma of each pixel of a part of a row, from left to right. Chroma is relative to grey, in units of 1/[`FINE`]. The samples along
    /// the border continue beyond it.
    pub fn each(&self, row: usize, columns: Range<usize>, mut set: impl FnMut(i32, i32)) {
        let [width, height] = self.size;
        let [across, down] = self.siting;
        let row_weights = down.weights(row % 2);
        let first = down.first_plus_two(row);
        let rows: [usize; 4] = std::array::from_fn(|j| width * (first + j).saturating_sub(2).min(height - 1));
        let to_fine = |sum: i32| (sum + ONE * ONE / FINE / 2) >> (ONE * ONE / FINE).ilog2();
        let mut start = columns.start;
        while start < columns.end {
            let end = columns.end.min(start + BLOCK);
            let from = across.first_plus_two(start);
            let samples = across.first_plus_two(end - 1) + 4 - from;
            let mut sums = [[0; BLOCK + 4]; 2];
            for (sums, plane) in sums.iter_mut().zip(self.planes) {
                for (i, sum) in sums[..samples].iter_mut().enumerate() {
                    let column = (from + i).saturating_sub(2).min(width - 1);
                    *sum = (0..4).map(|j| row_weights[j] * (i32::from(plane[rows[j] + column]) - 128)).sum();
                }
            }
            let weights = [0, 1].map(|parity| across.weights(parity));
            for column in start..end {
                let (weights, at) = (weights[column % 2], across.first_plus_two(column) - from);
                let [blue, red] = sums.each_ref().map(|sums| (0..4).map(|j| weights[j] * sums[at + j]).sum());
                set(to_fine(blue), to_fine(red));
            }
            start = end;
        }
    }
}
