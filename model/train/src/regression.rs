//! Principal directions of the training shapes, and the linear regression that gives the linear branch its initial weights.

use crate::samples::Samples;
use finray_model::sensing::network::{Inputs, Scaling};
use nalgebra::{DMatrix, DVector};

/// Directions whose standard deviation is below this share of the noise carry no information and are omitted.
const LEAST_SHARE_OF_NOISE: f64 = 0.1;
/// Directions whose variance is below this share of the largest variance are omitted as rounding errors. This limit also holds without noise.
const LEAST_SHARE_OF_LARGEST: f64 = 1e-14;

/// Normalisation of displacements to inputs, computed from training shapes.
#[derive(Debug, Clone)]
pub(super) struct Normalisation {
    /// Mean displacement coordinates, mm.
    pub(super) mean: DVector<f64>,
    /// Projection of n displacement coordinates onto p inputs, p x n, 1/mm.
    pub(super) projection: DMatrix<f64>,
    /// Squared scale of the displacements along the direction of each input, mm^2.
    pub(super) variances: Vec<f64>,
    /// Standard deviation of the camera noise in each input, dimensionless. The noise is independent between inputs.
    pub(super) noise: Vec<f64>,
}

impl Normalisation {
    pub(super) fn new(training: &Samples, scaling: Scaling, noise_mm: f64) -> Normalisation {
        let displacements = &training.displacements;
        let mean = displacements.column_mean();
        let mut centred = displacements.clone();
        centred.column_iter_mut().for_each(|mut column| column -= &mean);
        let covariance = &centred * centred.transpose() / training.count() as f64;
        let alike = |n: usize, variance: f64| (DMatrix::identity(n, n), vec![variance; n]);
        let (directions, variances) = match scaling {
            Scaling::Principal => principal_directions(covariance, noise_mm),
            Scaling::Spread => alike(covariance.nrows(), covariance.trace() / covariance.nrows() as f64),
            Scaling::Largest => alike(covariance.nrows(), displacements.amax().powi(2)),
        };
        let spreads_mm: Vec<f64> = variances.iter().map(|variance| variance.sqrt().hypot(noise_mm)).collect();
        let projection = DMatrix::from_fn(directions.ncols(), directions.nrows(), |row, column| {
            directions[(column, row)] / spreads_mm[row]
        });
        let noise = spreads_mm.iter().map(|spread_mm| noise_mm / spread_mm).collect();
        Normalisation { mean, projection, variances, noise }
    }

    /// Noise-free inputs of each case, p x cases.
    pub(super) fn inputs_of(&self, samples: &Samples) -> DMatrix<f64> {
        let mut inputs = &self.projection * &samples.displacements;
        let offset = &self.projection * &self.mean;
        inputs.column_iter_mut().for_each(|mut column| column -= &offset);
        inputs
    }

    /// The normalisation in the form in which a network stores it, with the largest absolute value of each input over the training cases.
    pub(super) fn stored(&self, inputs: &DMatrix<f64>) -> Inputs {
        Inputs {
            mean: self.mean.iter().copied().collect(),
            projection: self.projection.clone(),
            variances: self.variances.clone(),
            largest: inputs.row_iter().map(|row| row.amax()).collect(),
        }
    }
}

/// Eigenvectors of the covariance whose variance exceeds the limits, in descending order of variance, and these variances, mm^2.
fn principal_directions(covariance: DMatrix<f64>, noise_mm: f64) -> (DMatrix<f64>, Vec<f64>) {
    let eigen = covariance.symmetric_eigen();
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let largest = eigen.eigenvalues[order[0]];
    let least = f64::max((LEAST_SHARE_OF_NOISE * noise_mm).powi(2), LEAST_SHARE_OF_LARGEST * largest);
    let kept = order.iter().take_while(|&&i| eigen.eigenvalues[i] > least).count().max(1);
    order.truncate(kept);
    (eigen.eigenvectors.select_columns(&order), order.iter().map(|&i| eigen.eigenvalues[i].max(0.0)).collect())
}

/// Least-squares fit that predicts forces from noisy inputs: forces = mean + gain^T inputs.
#[derive(Debug, Clone)]
pub(super) struct Regression {
    /// Mean force of each contact, N.
    pub(super) mean_n: Vec<f64>,
    /// Gain, p x contacts, N per unit input.
    pub(super) gain: DMatrix<f64>,
    /// Root mean square residual of each force without noise, N.
    pub(super) left_over_n: Vec<f64>,
}

impl Regression {
    /// Minimises the mean over the cases of E |mean + gain^T (z + noise) - f|^2, where the expectation E over the noise is in closed form. `None` if
    /// inputs are linearly dependent.
    pub(super) fn new(inputs: &DMatrix<f64>, forces: &DMatrix<f64>, noise: &[f64]) -> Option<Regression> {
        let cases = inputs.ncols() as f64;
        let mean_n = forces.column_mean();
        let mut centred = forces.clone();
        centred.column_iter_mut().for_each(|mut column| column -= &mean_n);
        let mut normal = inputs * inputs.transpose() / cases;
        for (i, noise) in noise.iter().enumerate() {
            normal[(i, i)] += noise * noise;
        }
        let gain = normal.cholesky()?.solve(&(inputs * centred.transpose() / cases));
        let left_over = centred - gain.transpose() * inputs;
        let left_over_n = left_over.row_iter().map(|row| (row.norm_squared() / cases).sqrt()).collect();
        Some(Regression { mean_n: mean_n.iter().copied().collect(), gain, left_over_n })
    }
}
