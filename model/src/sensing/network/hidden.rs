//! Estimates the displacements of hidden markers from the training shapes.
//!
//! Training shapes are x = mean + V^T c + noise, with principal directions V and independent coefficients c, whose variances L are stored. The
//! measured coordinates x_s deviate from their mean by d = x_s - mean_s. If the measured coordinates deviate by d, the expected coordinates of all
//! markers are mean + F d. The matrix F is the identity for measured coordinates (s), and S_hs S_ss^-1 for hidden coordinates (h). The covariance of
//! all coordinates is S = V^T L V + noise^2 I (Rasmussen and Williams, Gaussian Processes for Machine Learning, eq. (A.6)).

use super::Network;
use nalgebra::DMatrix;

/// Noise that is assumed for networks trained without noise, as a share of the shapes' standard deviation. This noise keeps S_ss invertible.
const LEAST_NOISE: f64 = 1e-6;

/// The principal directions V as unit vectors, p x n for p inputs and n coordinates.
pub(super) fn directions(network: &Network) -> DMatrix<f64> {
    let mut directions = network.inputs.projection.clone();
    for mut row in directions.row_iter_mut() {
        let norm = row.norm();
        if norm > 0.0 {
            row /= norm;
        }
    }
    directions
}

/// Linear map F from the measured coordinates `seen` (indices, in their order) to all coordinates, dimensionless: one row per coordinate of the
/// network, one column per measured coordinate. Also returns the covariance of the error of F for noise-free shapes, mm^2. The covariance of the
/// error is zero if all coordinates are measured. `None` if the covariance of the measured coordinates is singular up to rounding errors.
pub(super) fn filling(network: &Network, seen: &[usize]) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let n = network.inputs.coordinate_count();
    let mut matrix = DMatrix::zeros(n, seen.len());
    for (column, &coordinate) in seen.iter().enumerate() {
        matrix[(coordinate, column)] = 1.0;
    }
    if seen.len() == n {
        return Some((matrix, DMatrix::zeros(n, n)));
    }
    let v = directions(network);
    let variances = nalgebra::DVector::from_column_slice(&network.inputs.variances);
    let shapes = v.transpose() * DMatrix::from_diagonal(&variances) * &v;
    let noise = network.card.noise_mm.powi(2).max(LEAST_NOISE * LEAST_NOISE * shapes.trace() / n as f64);
    let among_seen = shapes.select_rows(seen).select_columns(seen) + DMatrix::identity(seen.len(), seen.len()) * noise;
    // The columns of S_ss^-1 S_sh.
    let filled = among_seen.cholesky()?.solve(&shapes.select_rows(seen));
    for hidden in (0..n).filter(|coordinate| !seen.contains(coordinate)) {
        matrix.row_mut(hidden).copy_from(&filled.column(hidden).transpose());
    }
    // F maps the measured part of a shape to a whole shape; the error of F is the difference from the true whole shape.
    let mut selection = DMatrix::zeros(seen.len(), n);
    for (row, &coordinate) in seen.iter().enumerate() {
        selection[(row, coordinate)] = 1.0;
    }
    let missing = &matrix * selection - DMatrix::identity(n, n);
    Some((matrix, &missing * shapes * missing.transpose()))
}
