//! Points and normals of an object's outline.

use super::*;

/// At a point of an ellipse, the normal has the direction of the gradient.
#[test]
fn points_of_an_outline_have_its_normal() {
    let shape = TouchedOutline::Ellipse { semi_axes_mm: [30.0, 12.0] };
    let object = TouchedObject { shape, pose: Isometry2::new(Vector::new(5.0, -3.0), 0.4), sd_mm: 0.0, sd_rad: 0.0 };
    for step in 0..72 {
        let (sin, cos) = (f64::from(step) * 5.0_f64.to_radians()).sin_cos();
        let (on, normal) = (Vector::new(30.0 * cos, 12.0 * sin), Vector::new(cos / 30.0, sin / 12.0).normalize());
        let turn = UnitComplex::new(0.5);
        let found = object.point_facing(turn * normal, [1.0, 2.0, 0.1]);
        assert!((found - (Vector::new(6.0, -1.0) + turn * on)).norm() < 1e-12, "{step}: {found}");
    }
}
