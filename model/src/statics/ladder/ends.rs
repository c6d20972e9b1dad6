//! Vectors and matrices by the motions of two ends.

use crate::number::Number;
use nalgebra::SVector;

/// x, y and rotation of a first end, then of a second.
pub(super) type Ends<R = f64> = [R; 6];
/// Second derivatives by [`Ends`], symmetric: only the upper triangle is kept up to date.
pub(super) type EndsMatrix<R = f64> = [[R; 6]; 6];

/// The two ends of [`Ends`].
#[inline(always)]
pub(super) fn halves<R: Number>(ends: &Ends<R>) -> [[R; 3]; 2] {
    let [a, b, c, d, e, f] = *ends;
    [[a, b, c], [d, e, f]]
}

/// Two ends as [`Ends`].
#[inline(always)]
pub(super) fn joined<R: Number>(first: &[R; 3], second: &[R; 3]) -> Ends<R> {
    [first[0], first[1], first[2], second[0], second[1], second[2]]
}

/// The numbers of an element's vector.
#[inline(always)]
pub(super) fn numbers<R: Number>(vector: &SVector<R, 6>) -> Ends<R> {
    vector.data.0[0]
}
