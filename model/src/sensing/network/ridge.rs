//! Ridge forces: what a network for any of its contacts starts from.

use crate::sensing::linear::Inverse;
use nalgebra::DMatrix;

/// Gain G (contacts x n, N/mm) of the ridge forces r = G x of the contacts that touch, (C^T C + ridge^2)^-1 C^T with the
/// columns of the compliance (n x contacts, mm/N) that belong to them; rows of the others are zero. `ridge` is the noise
/// of a coordinate by the forces' standard deviation, mm/N.
pub(crate) fn ridge_gain(compliance: &DMatrix<f64>, touching: &[bool], ridge: f64) -> DMatrix<f64> {
    let those: Vec<usize> = (0..touching.len()).filter(|&i| touching[i]).collect();
    let inverse = Inverse::of(&compliance.select_columns(&those), ridge);
    let mut gain = DMatrix::zeros(compliance.ncols(), compliance.nrows());
    for (row, &contact) in inverse.gain.row_iter().zip(&those) {
        gain.set_row(contact, &row);
    }
    gain
}
