//! Tests bordered equations with a singular matrix.

use finray_numerics::linear::{Bordered, Direction, IndefiniteFactor};
use sprs::CsMat;

/// At a limit point, the stiffness is singular within rounding, but the solution of the bordered equations loses no digits. The example solves K x -
/// m f = r and c x + d m = l, with K = diag(3e-15, 2), f = (0.7, 0.5), c = (1, 0) and d = 3. The solution for the forces r = (1.1, 2) and the length
/// l = 4 is known in closed form.
#[test]
fn keeps_digits_where_the_stiffness_is_singular() {
    let stiffness = CsMat::new_csc((2, 2), vec![0, 1, 2], vec![0, 1], vec![3e-15, 2.0]);
    let mut factor = IndefiniteFactor::default();
    assert_eq!(factor.factorise(&stiffness), Some(0));
    let constraint = Direction { unknowns: vec![1.0, 0.0], multiple: 3.0 };
    let load_vector = [0.7, 0.5];
    let found = Bordered::new(&factor, &load_vector, &constraint)
        .and_then(|equations| equations.solve(&[1.1, 2.0], 4.0))
        .expect("the bordered matrix is regular");
    // Within rounding, -0.7 m = 1.1, x + 3 m = 4 and 2 y - 0.5 m = 2.
    let m = -1.1 / 0.7;
    let expected = [4.0 - 3.0 * m, 1.0 + 0.25 * m, m];
    for (ours, expected) in [found.unknowns[0], found.unknowns[1], found.multiple].iter().zip(expected) {
        assert!((ours - expected).abs() < 1e-12, "{ours} against {expected}");
    }
}
