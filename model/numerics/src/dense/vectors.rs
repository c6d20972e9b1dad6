//! Vectors of f32 and f64 under one name, for kernels that take both.

use pulp::Simd;

/// A number of which a machine holds several in a register.
pub trait Number: Copy + 'static {
    /// A register of them.
    type Vector<S: Simd>: Copy;
    /// Zero.
    const ZERO: Self;
    /// How many a register holds.
    fn lanes<S: Simd>() -> usize;
    /// The same number in every lane.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Vector<S>;
    /// a b + c, rounded once where the machine can.
    fn mul_add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>, c: Self::Vector<S>) -> Self::Vector<S>;
    /// a + b.
    fn add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// The whole vectors of a slice.
    fn vectors<S: Simd>(numbers: &[Self]) -> &[Self::Vector<S>];
    /// The whole vectors of a slice, to be written.
    fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [Self::Vector<S>];
}

macro_rules! number {
    ($number:ident, $vector:ident, $lanes:ident, $splat:ident, $mul_add:ident, $add:ident, $vectors:ident, $vectors_mut:ident) => {
        impl Number for $number {
            type Vector<S: Simd> = S::$vector;
            const ZERO: $number = 0.0;

            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: $number) -> S::$vector {
                simd.$splat(value)
            }

            #[inline(always)]
            fn mul_add<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
                simd.$mul_add(a, b, c)
            }

            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn vectors<S: Simd>(numbers: &[$number]) -> &[S::$vector] {
                S::$vectors(numbers).0
            }

            #[inline(always)]
            fn vectors_mut<S: Simd>(numbers: &mut [$number]) -> &mut [S::$vector] {
                S::$vectors_mut(numbers).0
            }
        }
    };
}

number!(f32, f32s, F32_LANES, splat_f32s, mul_add_e_f32s, add_f32s, as_simd_f32s, as_mut_simd_f32s);
number!(f64, f64s, F64_LANES, splat_f64s, mul_add_e_f64s, add_f64s, as_simd_f64s, as_mut_simd_f64s);

/// Numbers that begin on a cache line, so that no vector lies across two.
#[derive(Debug)]
pub struct Aligned<N> {
    /// With room to spare.
    numbers: Vec<N>,
    start: usize,
    len: usize,
}

/// Bytes of a cache line.
const LINE: usize = 64;

impl<N: Number> Aligned<N> {
    /// A list of zeros of this length.
    pub fn zeros(len: usize) -> Aligned<N> {
        let room = LINE / size_of::<N>();
        let numbers = vec![N::ZERO; len + room];
        // The address may be unknowable, as under an interpreter: then any start will do.
        let start = Some(numbers.as_ptr().align_offset(LINE)).filter(|start| *start <= room).unwrap_or(0);
        Aligned { numbers, start, len }
    }

    /// The numbers.
    #[inline(always)]
    pub fn as_slice(&self) -> &[N] {
        &self.numbers[self.start..self.start + self.len]
    }

    /// The numbers, to be written.
    #[inline(always)]
    pub fn as_mut_slice(&mut self) -> &mut [N] {
        &mut self.numbers[self.start..self.start + self.len]
    }
}

impl<N: Number> Clone for Aligned<N> {
    /// The clone lies elsewhere, so its start is another.
    fn clone(&self) -> Aligned<N> {
        let mut clone = Aligned::zeros(self.len);
        clone.as_mut_slice().copy_from_slice(self.as_slice());
        clone
    }
}
