//! Rigid motion between two sets of points in the plane.

use crate::Vector;
use nalgebra::{Isometry2, UnitComplex};

/// Rigid motion that maps the first point of each pair onto the second point, by weighted least squares. Each pair consists of two points, mm, and a weight,
/// which multiplies the pair's distance. The identity without pairs.
///
/// # Reference
/// Umeyama, IEEE Transactions on Pattern Analysis and Machine Intelligence 13 (1991), for the two-dimensional case without scaling.
pub fn rigid_fit(pairs: impl Iterator<Item = (Vector, Vector, f64)> + Clone) -> Isometry2<f64> {
    let mut weights = 0.0;
    let [mut from, mut to] = [Vector::zeros(); 2];
    for (a, b, weight) in pairs.clone() {
        weights += weight * weight;
        from += weight * weight * a;
        to += weight * weight * b;
    }
    if weights == 0.0 {
        return Isometry2::identity();
    }
    let (from, to) = (from / weights, to / weights);
    let (mut along, mut across) = (0.0, 0.0);
    for (a, b, weight) in pairs {
        let (a, b) = (a - from, b - to);
        along += weight * weight * a.dot(&b);
        across += weight * weight * a.perp(&b);
    }
    let turn = UnitComplex::new(across.atan2(along));
    Isometry2::from_parts((to - turn * from).into(), turn)
}
