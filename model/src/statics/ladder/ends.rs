//! Vectors and matrices with one entry or one row for each motion of the two ends of a chain or element.

use crate::number::Number;
use nalgebra::SVector;

/// Motions x, y (mm) and rotation (rad) of the first end, then of the second end. Also used for the forces (N) and moments (N mm) conjugate to these
/// motions.
pub(super) type Ends<R = f64> = [R; 6];
/// Second derivatives with respect to the motions in [`Ends`]. The matrix is symmetric, and only its upper triangle is valid.
pub(super) type EndsMatrix<R = f64> = [[R; 6]; 6];

/// Splits [`Ends`] into the parts of its first and second end.
#[inline(always)]
pub(super) fn halves<R: Number>(ends: &Ends<R>) -> [[R; 3]; 2] {
    let [a, b, c, d, e, f] = *ends;
    [[a, b, c], [d, e, f]]
}

/// Joins the parts of two ends to [`Ends`].
#[inline(always)]
pub(super) fn joined<R: Number>(first: &[R; 3], second: &[R; 3]) -> Ends<R> {
    [first[0], first[1], first[2], second[0], second[1], second[2]]
}

/// The entries of an element's vector as an array.
#[inline(always)]
pub(super) fn numbers<R: Number>(vector: &SVector<R, 6>) -> Ends<R> {
    vector.data.0[0]
}
