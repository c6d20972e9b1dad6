//! Tests the factorisation of small matrices by solving for known solutions.

use finray_numerics::linear::Ldl;
use nalgebra::{Matrix3, Vector3};

fn rows(k: &Matrix3<f64>) -> [[f64; 3]; 3] {
    k.transpose().data.0
}

fn solved(ldl: &Ldl<f64, 3>, right: Vector3<f64>) -> Vector3<f64> {
    ldl.backward(&ldl.divided(&ldl.forward_vector(&right.into()))).into()
}

#[test]
fn solves_and_sees_the_sign() {
    let k = Matrix3::new(4.0, 1.0, -2.0, 1.0, 5.0, 0.5, -2.0, 0.5, 6.0);
    let x = Vector3::new(1.0, -2.0, 3.0);
    let mut ldl = Ldl::empty(0.0);
    let mut columns = [[1.0, 7.0], [-2.0, 8.0], [3.0, 9.0]];
    ldl.factorise(&rows(&k), &mut columns);
    assert!(ldl.positive);
    assert!((solved(&ldl, k * x) - x).norm() < 1e-14);
    assert_eq!(columns.map(|row| row[0]), ldl.forward_vector(&x.into()));
    assert_eq!(columns.map(|row| row[1]), ldl.forward_vector(&[7.0, 8.0, 9.0]));
    let indefinite = k - Matrix3::identity() * 4.5;
    ldl.factorise(&rows(&indefinite), &mut [[]; 3]);
    assert!(!ldl.positive);
    assert!((solved(&ldl, indefinite * x) - x).norm() < 1e-13);
    // The first two rows differ by only 1e-3.
    ldl.factorise(&rows(&Matrix3::new(1.0, 1.0, 0.0, 1.0, 1.001, 0.0, 0.0, 0.0, 1.0)), &mut [[]; 3]);
    assert!(ldl.pivots_exceed(&[0.99, 0.99e-3, 0.99]) && !ldl.pivots_exceed(&[0.99, 1.01e-3, 0.99]));
    ldl.factorise(&rows(&(k * f64::NAN)), &mut [[]; 3]);
    assert!(!ldl.positive);
}
