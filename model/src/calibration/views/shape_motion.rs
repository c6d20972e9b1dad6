//! The motion of a whole shape that is closest to the motions of its points.

use crate::Vector;

/// The motion of a whole shape, as small as a turn may be, that is closest to what each of its points is to move by: points, and their motions.
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

/// What is left of residuals at points, mm^2, once the whole shape has moved to where they are least.
pub(super) fn misfit_of_shape(all: &[(Vector, Vector)]) -> f64 {
    let moved = motion_of_shape(all);
    all.iter().map(|(point, left)| (left - moved(point)).norm_squared()).sum()
}
