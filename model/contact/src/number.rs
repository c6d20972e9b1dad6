//! Vectors of plain and dual numbers. A formula that is written once for both yields values and derivatives.

use finray_model::Vector;
use nalgebra::{Matrix2, Vector2};
use num_dual::DualNum;

/// A real number or a dual number.
pub(crate) trait Number: DualNum<Primitive = f64> + Copy {}

impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

pub(crate) fn constant<D: Number>(vector: Vector) -> Vector2<D> {
    vector.map(D::from)
}

pub(crate) fn times<D: Number>(matrix: Matrix2<f64>, vector: Vector2<D>) -> Vector2<D> {
    let row = |i: usize| vector.x * matrix[(i, 0)] + vector.y * matrix[(i, 1)];
    Vector2::new(row(0), row(1))
}

pub(crate) fn turned<D: Number>(by: D, vector: Vector2<D>) -> Vector2<D> {
    let (sin, cos) = by.sin_cos();
    Vector2::new(vector.x * cos - vector.y * sin, vector.x * sin + vector.y * cos)
}

/// The vector rotated by +90 degrees.
pub(crate) fn across<D: Number>(vector: Vector2<D>) -> Vector2<D> {
    Vector2::new(-vector.y, vector.x)
}

pub(crate) fn inner<D: Number>(a: Vector2<D>, b: Vector2<D>) -> D {
    a.x * b.x + a.y * b.y
}
