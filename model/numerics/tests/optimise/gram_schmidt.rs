//! Tests small least-squares problems that are solved in place.

use finray_numerics::optimise::GramSchmidt;

/// Fits a parabola to five points with a known solution: y = 1 + 2 x - x^2, plus a part that no column explains.
#[test]
fn fits_what_can_be_fitted() {
    let x = [-2.0_f64, -1.0, 0.0, 1.0, 2.0];
    // The unexplained part is orthogonal to 1, x and x^2.
    let unexplained = [1.0, -2.0, 0.0, 2.0, -1.0];
    let mut problem = GramSchmidt::default();
    problem.reset(5, 3);
    for (i, x) in x.into_iter().enumerate() {
        for power in 0..3 {
            problem.column_mut(power)[i] = x.powi(power as i32);
        }
        problem.column_mut(3)[i] = 1.0 + 2.0 * x - x * x + unexplained[i];
    }
    let solution = problem.solve().map(<[f64]>::to_vec).unwrap_or_default();
    for (found, expected) in solution.iter().zip([1.0, 2.0, -1.0]) {
        assert!((found - expected).abs() < 1e-14, "{solution:?}");
    }
    assert_eq!(solution.len(), 3);
    // Sum of (1 + 2 x - x^2)^2 over the five points.
    let explained = 49.0 + 4.0 + 1.0 + 4.0 + 1.0;
    assert!((problem.explained() - explained).abs() < 1e-12);
}

#[test]
fn dependent_columns_have_no_solution() {
    let mut problem = GramSchmidt::default();
    problem.reset(2, 1);
    problem.column_mut(1).fill(1.0);
    assert!(problem.solve().is_none());
}
