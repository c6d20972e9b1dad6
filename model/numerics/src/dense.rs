//! Evaluation of dense layers of a neural network: products of a matrix with a vector, and the hyperbolic tangent.
//!
//! The loops are plain. The compiler generates SIMD instructions for them in functions that [`pulp`] compiles for the machine: the functions here
//! are inlined into [`pulp::WithSimd::with_simd`], whose type `S` states whether the machine has fused multiply-add.

use pulp::Simd;
use std::array;
use std::ops::{Add, Div, Mul};

/// Number of outputs whose sums stay in registers while the inputs are read.
const PANEL: usize = 16;
/// Number of independent sums for each output, which hide the latency of an addition.
const CHAINS: usize = 3;

/// A floating-point type.
pub trait Float: Copy + Default + From<f32> + Add<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// Returns a b + c with one rounding.
    fn fused(a: Self, b: Self, c: Self) -> Self;

    /// The number, limited to -limit to limit; NaN stays NaN.
    fn limited(self, limit: f32) -> Self;
}

macro_rules! float {
    ($($float:ty),*) => {$(
        impl Float for $float {
            #[inline(always)]
            fn fused(a: $float, b: $float, c: $float) -> $float {
                a.mul_add(b, c)
            }

            #[inline(always)]
            fn limited(self, limit: f32) -> $float {
                self.clamp((-limit).into(), limit.into())
            }
        }
    )*};
}

float!(f32, f64);

/// Returns a b + c, with one rounding unless `S` is scalar: a machine without fused multiply-add would call a slow function for it.
#[inline(always)]
fn multiply_add<S: Simd, N: Float>(a: N, b: N, c: N) -> N {
    if S::IS_SCALAR { a * b + c } else { N::fused(a, b, c) }
}

/// A weight matrix W in the order in which the product reads it: panel by panel of outputs, and input by input within a panel. Zeros fill the last
/// panel.
#[derive(Debug, Clone)]
pub struct Weights<N> {
    inputs: usize,
    panels: Vec<Panel<N>>,
}

/// Weights of one input for a panel of outputs. Each panel starts on a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Panel<N>([N; PANEL]);

impl<N: Float> Weights<N> {
    /// Stores a matrix, outputs x inputs; `weight(output, input)` returns its entries.
    pub fn new(outputs: usize, inputs: usize, weight: impl Fn(usize, usize) -> N) -> Weights<N> {
        let entry = |output, input| if output < outputs { weight(output, input) } else { N::default() };
        let panels = (0..outputs).step_by(PANEL).flat_map(|first| (0..inputs).map(move |input| (first, input)));
        let panels = panels.map(|(first, input)| Panel(array::from_fn(|k| entry(first + k, input))));
        Weights { inputs, panels: panels.collect() }
    }

    /// Computes y += W x. The lengths of `x` and `y` are at least the numbers of inputs and outputs.
    #[inline(always)]
    pub fn add_product<S: Simd>(&self, _: S, x: &[N], y: &mut [N]) {
        let x = &x[..self.inputs];
        for (panels, y) in self.panels.chunks_exact(self.inputs).zip(y.chunks_mut(PANEL)) {
            let mut sums = [[N::default(); PANEL]; CHAINS];
            sums[0] = array::from_fn(|k| y.get(k).copied().unwrap_or_default());
            let (strides, rest) = panels.as_chunks::<CHAINS>();
            let (inputs, rest_inputs) = x.as_chunks::<CHAINS>();
            for (weights, inputs) in strides.iter().zip(inputs) {
                // The compiler generates no SIMD instructions for iterators over both arrays.
                for c in 0..CHAINS {
                    for k in 0..PANEL {
                        sums[c][k] = multiply_add::<S, N>(weights[c].0[k], inputs[c], sums[c][k]);
                    }
                }
            }
            for (Panel(weights), &input) in rest.iter().zip(rest_inputs) {
                for k in 0..PANEL {
                    sums[0][k] = multiply_add::<S, N>(weights[k], input, sums[0][k]);
                }
            }
            let sums: [N; PANEL] =
                array::from_fn(|k| sums.iter().skip(1).fold(sums[0][k], |sum, other| sum + other[k]));
            y.iter_mut().zip(sums).for_each(|(y, sum)| *y = sum);
        }
    }
}

/// Magnitude to which arguments are clamped; for larger arguments, |tanh| is 1 within the error of the approximation.
const CLAMP: f32 = 8.0;
/// Coefficients of the numerator N in tanh(x) = x N(x^2) / D(x^2), constant term first. Minimax fit over 0..8 with an error of 6e-9, scaled to minimise the
/// rounding of the coefficients to f32.
const NUMERATOR: [f32; 5] = [1.0770481, 0.14477357, 0.0038432276, 2.3523542e-5, 1.6323131e-8];
/// Coefficients of the denominator D in tanh(x) = x N(x^2) / D(x^2), constant term first.
const DENOMINATOR: [f32; 5] = [1.0770481, 0.5037895, 0.028166784, 0.00036683367, 9.1461675e-7];

/// Replaces each number by its hyperbolic tangent, with an error of at most 3e-7.
#[inline(always)]
pub fn tanh<S: Simd>(_: S, numbers: &mut [f32]) {
    for x in numbers {
        // Without fused multiply-add, f32 would round too much.
        *x = if S::IS_SCALAR { tanh_of::<S, f64>((*x).into()) as f32 } else { tanh_of::<S, f32>(*x) };
    }
}

#[inline(always)]
fn tanh_of<S: Simd, N: Float>(x: N) -> N {
    let x = x.limited(CLAMP);
    let square = x * x;
    let add_power = |sum: N, coefficient: &f32| multiply_add::<S, N>(sum, square, (*coefficient).into());
    let [numerator, denominator] = [NUMERATOR, DENOMINATOR].map(|of| of.iter().rev().fold(N::default(), add_power));
    (x * numerator / denominator).limited(1.0)
}
