//! Rigid motion of a shape that best fits the motions of its points.

use crate::Vector;

/// Rigid motion, linearised for small rotations, that best fits given motions of points. `all` lists position and motion of each point, mm.
pub(super) fn motion_of_shape(all: &[(Vector, Vector)]) -> impl Fn(&Vector) -> Vector + use<> {
    let count = all.len().max(1) as f64;
    let [middle, shift] =
        all.iter().fold([Vector::zeros(); 2], |[p, r], (point, moved)| [p + point / count, r + moved / count]);
    let (mut turned, mut arms) = (0.0, 0.0);
    for (point, moved) in all {
        let arm = point - middle;
        turned += arm.perp(&(moved - shift));
        arms += arm.norm_squared();
    }
    let turn = turned / arms.max(f64::MIN_POSITIVE);
    move |point| shift + Vector::new(middle.y - point.y, point.x - middle.x) * turn
}

/// Sum of squared residuals at points, mm^2, after the best rigid motion of the shape is removed.
pub(super) fn misfit_of_shape(all: &[(Vector, Vector)]) -> f64 {
    let moved = motion_of_shape(all);
    all.iter().map(|(point, left)| (left - moved(point)).norm_squared()).sum()
}
