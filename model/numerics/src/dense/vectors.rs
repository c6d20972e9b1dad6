//! SIMD vectors of f32 and f64 behind one trait, for kernels that support both number types.

use pulp::Simd;

/// A floating-point type; a SIMD register holds several numbers of this type.
pub trait Number: Copy + 'static {
    /// A SIMD register of these numbers.
    type Vector<S: Simd>: Copy;
    /// The number zero.
    const ZERO: Self;
    /// Number of lanes of a register.
    fn lanes<S: Simd>() -> usize;
    /// Returns `value` in every lane.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Vector<S>;
    /// Returns a b + c in each lane, with one rounding if the machine has fused multiply-add.
    fn mul_add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>, c: Self::Vector<S>) -> Self::Vector<S>;
    /// Returns a + b in each lane.
    fn add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// The slice as whole SIMD vectors; a remainder shorter than a vector is omitted.
    fn vectors<S: Simd>(numbers: &[Self]) -> &[Self::Vector<S>];
    /// The slice as whole mutable SIMD vectors; a remainder shorter than a vector is omitted.
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

/// Numbers that start on a cache line, so that no SIMD vector spans two lines.
#[derive(Debug)]
pub struct Aligned<N> {
    /// Buffer longer than the list, so that the list can start on a cache line.
    numbers: Vec<N>,
    start: usize,
    len: usize,
}

/// Size of a cache line, bytes.
const LINE: usize = 64;

impl<N: Number> Aligned<N> {
    /// A list of `len` zeros.
    pub fn zeros(len: usize) -> Aligned<N> {
        let room = LINE / size_of::<N>();
        let numbers = vec![N::ZERO; len + room];
        // If the address is unknown, as in an interpreter, alignment is not needed.
        let start = Some(numbers.as_ptr().align_offset(LINE)).filter(|start| *start <= room).unwrap_or(0);
        Aligned { numbers, start, len }
    }

    /// The numbers.
    #[inline(always)]
    pub fn as_slice(&self) -> &[N] {
        &self.numbers[self.start..self.start + self.len]
    }

    /// The numbers, mutable.
    #[inline(always)]
    pub fn as_mut_slice(&mut self) -> &mut [N] {
        &mut self.numbers[self.start..self.start + self.len]
    }
}

impl<N: Number> Clone for Aligned<N> {
    /// Copies the numbers; the clone has another address and therefore another offset in its buffer.
    fn clone(&self) -> Aligned<N> {
        let mut clone = Aligned::zeros(self.len);
        clone.as_mut_slice().copy_from_slice(self.as_slice());
        clone
    }
}
