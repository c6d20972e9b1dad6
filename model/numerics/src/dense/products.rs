//! Matrix-vector products y += W x, for one vector x (a frame) or for many.

use super::vectors::{Aligned, Number};
use pulp::Simd;

/// Number of SIMD vectors of outputs that stay in registers while the inputs of one frame (one vector x) are read. With four independent sums per vector, the
/// latency of an addition is hidden.
const WIDEST_PANEL: usize = 3;
/// Number of outputs that stay in registers while the weights are read. With [`TILE_VECTORS`], 12 sums, 2 inputs and a weight fit into AVX2's 16 registers.
const TILE_OUTPUTS: usize = 6;
/// Number of SIMD vectors of frames that stay in registers while the weights are read.
const TILE_VECTORS: usize = 2;

/// Function applied to a complete sum. It is a trait, because closures are not reliably inlined; without inlining, the product takes ten times as long.
pub trait Finish<N: Number>: Copy {
    /// Applies the function in each lane of `sum`.
    fn finish<S: Simd>(self, simd: S, sum: N::Vector<S>) -> N::Vector<S>;
}

/// The identity: it leaves the sum unchanged.
#[derive(Debug, Clone, Copy)]
pub struct Linear;

impl<N: Number> Finish<N> for Linear {
    #[inline(always)]
    fn finish<S: Simd>(self, _: S, sum: N::Vector<S>) -> N::Vector<S> {
        sum
    }
}

/// A weight matrix W, stored in two orders: one for a single frame, the other for many frames.
#[derive(Debug, Clone)]
pub struct Weights<N: Number> {
    /// Number of inputs, the length of x.
    inputs: usize,
    /// Number of outputs, the length of y.
    outputs: usize,
    /// Weights in the order for one frame: one panel (one to three SIMD vectors of outputs) after the other, input by input within a panel. Zeros fill the last
    /// vector.
    panels: Aligned<N>,
    /// Weights in the order for many frames: one tile (`TILE_OUTPUTS` outputs) after the other, input by input within a tile. Zeros fill the last tile.
    tiles: Aligned<N>,
}

/// Number of frames that [`Weights::add_products`] processes at once.
#[inline(always)]
pub fn tile_frames<N: Number, S: Simd>() -> usize {
    TILE_VECTORS * N::lanes::<S>()
}

/// `count` rounded up to a multiple of the number of lanes.
#[inline(always)]
pub fn padded<N: Number, S: Simd>(count: usize) -> usize {
    count.next_multiple_of(N::lanes::<S>())
}

/// Number of outputs that [`Weights::add_products`] writes: `outputs` rounded up to whole tiles.
pub fn tiled(outputs: usize) -> usize {
    outputs.next_multiple_of(TILE_OUTPUTS)
}

/// Width of the next panel, in SIMD vectors: 2 or 3, or 1 if only one vector of outputs remains.
#[inline(always)]
fn panel_width(vectors_left: usize) -> usize {
    match vectors_left {
        1 => 1,
        2 | 4 => 2,
        _ => WIDEST_PANEL,
    }
}

impl<N: Number> Weights<N> {
    /// Stores a matrix in both orders, for the machine's SIMD width; `weight(output, input)` returns its entries.
    pub fn new<S: Simd>(outputs: usize, inputs: usize, weight: impl Fn(usize, usize) -> N) -> Weights<N> {
        let lanes = N::lanes::<S>();
        let entry = |output: usize, input: usize| if output < outputs { weight(output, input) } else { N::ZERO };
        let mut panels = Aligned::zeros(padded::<N, S>(outputs) * inputs);
        let mut positions = panels.as_mut_slice().iter_mut();
        let mut vector = 0;
        while vector * lanes < outputs {
            let width = panel_width(outputs.div_ceil(lanes) - vector);
            let rows = vector * lanes..(vector + width) * lanes;
            let entries = (0..inputs).flat_map(|input| rows.clone().map(move |output| (output, input)));
            entries.zip(&mut positions).for_each(|((output, input), position)| *position = entry(output, input));
            vector += width;
        }
        let mut tiles = Aligned::zeros(tiled(outputs) * inputs);
        for (tile, positions) in tiles.as_mut_slice().chunks_exact_mut(TILE_OUTPUTS * inputs).enumerate() {
            for (k, position) in positions.iter_mut().enumerate() {
                *position = entry(tile * TILE_OUTPUTS + k % TILE_OUTPUTS, k / TILE_OUTPUTS);
            }
        }
        Weights { inputs, outputs, panels, tiles }
    }

    /// Number of outputs, the length of y.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Computes y = finish(y + W x) for one frame; `y` has [`padded`] outputs. Fetching weights from memory takes most of the time, so `finish` runs after each
    /// panel, while the weights of the next panel arrive.
    #[inline(always)]
    pub fn add_product<S: Simd>(&self, simd: S, x: &[N], y: &mut [N], finish: impl Finish<N>) {
        let x = &x[..self.inputs];
        let mut panels = N::vectors::<S>(self.panels.as_slice());
        let mut y = N::vectors_mut::<S>(y);
        while !y.is_empty() {
            let width = panel_width(y.len());
            let (panel, other_panels) = panels.split_at(width * self.inputs);
            let (sums, other_y) = y.split_at_mut(width);
            match width {
                1 => panel_product::<N, S, 1, 8>(simd, panel, x, sums, finish),
                2 => panel_product::<N, S, 2, 6>(simd, panel, x, sums, finish),
                _ => panel_product::<N, S, WIDEST_PANEL, 4>(simd, panel, x, sums, finish),
            }
            (panels, y) = (other_panels, other_y);
        }
    }

    /// Computes Y += W X for [`tile_frames`] frames. X has one row per input and Y one row per output, each with one entry per frame; Y has [`tiled`] rows.
    #[inline(always)]
    pub fn add_products<S: Simd>(&self, simd: S, x: &[N], y: &mut [N]) {
        let x = N::vectors::<S>(x).as_chunks::<TILE_VECTORS>().0;
        let y = N::vectors_mut::<S>(y).as_chunks_mut::<TILE_VECTORS>().0;
        let weights = self.tiles.as_slice().as_chunks::<TILE_OUTPUTS>().0;
        for (tile, rows) in weights.chunks_exact(self.inputs).zip(y.as_chunks_mut::<TILE_OUTPUTS>().0) {
            let mut sums = *rows;
            for (weights, x) in tile.iter().zip(x) {
                for (weight, sums) in weights.iter().zip(&mut sums) {
                    let weight = N::splat(simd, *weight);
                    for (sum, x) in sums.iter_mut().zip(x) {
                        *sum = N::mul_add(simd, weight, *x, *sum);
                    }
                }
            }
            *rows = sums;
        }
    }
}

/// Computes y = finish(y + W x) for a panel of `WIDTH` SIMD vectors of outputs, with `CHAINS` independent sums per vector.
#[inline(always)]
fn panel_product<N: Number, S: Simd, const WIDTH: usize, const CHAINS: usize>(
    simd: S,
    panel: &[N::Vector<S>],
    x: &[N],
    y: &mut [N::Vector<S>],
    finish: impl Finish<N>,
) {
    let mut sums = [[N::splat(simd, N::ZERO); WIDTH]; CHAINS];
    let (strides, rest) = panel.as_chunks::<WIDTH>().0.as_chunks::<CHAINS>();
    let (inputs, rest_inputs) = x.as_chunks::<CHAINS>();
    for (weights, inputs) in strides.iter().zip(inputs) {
        for ((weights, input), sums) in weights.iter().zip(inputs).zip(&mut sums) {
            add_input(simd, weights, *input, sums);
        }
    }
    for ((weights, input), sums) in rest.iter().zip(rest_inputs).zip(&mut sums) {
        add_input(simd, weights, *input, sums);
    }
    for (k, y) in y.iter_mut().enumerate() {
        let sum = sums.iter().fold(*y, |total, sums| N::add(simd, total, sums[k]));
        *y = finish.finish(simd, sum);
    }
}

/// Adds the contribution of one input to the sums of a panel.
#[inline(always)]
fn add_input<N: Number, S: Simd, const WIDTH: usize>(
    simd: S,
    weights: &[N::Vector<S>; WIDTH],
    input: N,
    sums: &mut [N::Vector<S>; WIDTH],
) {
    let input = N::splat(simd, input);
    for (weight, sum) in weights.iter().zip(sums) {
        *sum = N::mul_add(simd, *weight, input, *sum);
    }
}
