//! Matrix-vector products y += W x.

use super::vectors::{Aligned, Number};
use pulp::Simd;

/// Number of SIMD vectors of outputs that stay in registers while the inputs are read. With four independent sums per vector, the
/// latency of an addition is hidden.
const WIDEST_PANEL: usize = 3;

/// Function applied to a complete sum. The function is passed as a trait, because closures are not reliably inlined; without inlining, the product
/// takes ten times as long.
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

/// A weight matrix W.
#[derive(Debug, Clone)]
pub struct Weights<N: Number> {
    /// Number of inputs, the length of x.
    inputs: usize,
    /// Number of outputs, the length of y.
    outputs: usize,
    /// Weights in the order in which the product reads them: panel by panel (a panel is one to three SIMD vectors of outputs), and input by input
    /// within a panel. Zeros fill the last vector.
    panels: Aligned<N>,
}

/// `count` rounded up to a multiple of the number of lanes.
#[inline(always)]
pub fn padded<N: Number, S: Simd>(count: usize) -> usize {
    count.next_multiple_of(N::lanes::<S>())
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
    /// Stores a matrix in the order in which the product reads it with the machine's SIMD width; `weight(output, input)` returns its entries.
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
        Weights { inputs, outputs, panels }
    }

    /// Number of outputs, the length of y.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Computes y = finish(y + W x); the length of `y` is the number of outputs, rounded up by [`padded`]. Fetching weights from memory takes most of
    /// the time, so `finish` runs after each panel, while the weights of the next panel arrive.
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
