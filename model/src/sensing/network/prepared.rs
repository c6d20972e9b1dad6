//! A network prepared for the contacts at which forces act, and for the visible markers.

use super::{ContactSet, Dense, Network};
use crate::sensing::linear::Inverse;
use nalgebra::DMatrix;

/// Gain G of ridge regression, contacts x n, N/mm. G = (C^T C + ridge^2)^-1 C^T maps displacements x to the forces r = G x at the contacts marked in
/// `touching`. C consists of the columns of `compliance` (n x contacts, mm/N) for the marked contacts. The rows of G for other contacts are zero.
/// `ridge` is the noise of a coordinate divided by the prior standard deviation of a force, mm/N.
pub fn ridge_gain(compliance: &DMatrix<f64>, touching: &[bool], ridge: f64) -> DMatrix<f64> {
    let those: Vec<usize> = (0..touching.len()).filter(|&i| touching[i]).collect();
    let inverse = Inverse::of(&compliance.select_columns(&those), ridge);
    let mut gain = DMatrix::zeros(compliance.ncols(), compliance.nrows());
    for (row, &contact) in inverse.gain.row_iter().zip(&those) {
        gain.set_row(contact, &row);
    }
    gain
}

/// Network in one form for [`ContactSet::Fixed`] and [`ContactSet::AnyOf`]: z = P x + offset, f = skip z + MLP(z).
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    /// P, inputs x coordinates, 1/mm.
    pub(super) projection: DMatrix<f64>,
    /// Vector added to P x, dimensionless.
    pub(super) offset: Vec<f64>,
    /// The layers of the MLP.
    pub(super) layers: Vec<Dense>,
    /// Weights of the skip branch by rows, outputs x inputs, N. Empty without a skip branch.
    pub(super) skip: Vec<f32>,
}

impl Prepared {
    /// Prepares a network for the forces at the contacts `outputs`, which are indices in the network's list. For [`ContactSet::AnyOf`], `selected`
    /// lists the contacts at which forces act; it includes `outputs`.
    ///
    /// The mask of the selected contacts is constant and becomes part of the bias of the first layer. Ridge regression estimates the forces at the
    /// selected contacts. These forces, divided by the prior, become further inputs with a skip connection to the outputs. The forces from ridge
    /// regression are G_S x with G_S = (C_S^T C_S + (noise / prior)^2)^-1 C_S^T.
    pub(super) fn new(network: &Network, selected: &[usize], outputs: &[usize]) -> Prepared {
        let (p, m) = (network.inputs.count(), network.contact_count());
        let mut layers = network.layers.clone();
        if let Some(last) = layers.last_mut() {
            last.weights = rows(&last.weights, last.inputs, outputs);
            last.bias = rows(&last.bias, 1, outputs);
            last.outputs = outputs.len();
        }
        let mean = nalgebra::DVector::from_column_slice(&network.inputs.mean);
        let mut projection = network.inputs.projection.clone();
        let mut offset: Vec<f64> = (-(&projection * mean)).iter().copied().collect();
        let mut skip = rows(&network.skip, p, outputs);
        if let (ContactSet::AnyOf, Some(compliance)) = (network.card.contact_set, &network.compliance) {
            let prior_n = network.card.prior_n;
            let touching: Vec<bool> = (0..m).map(|contact| selected.contains(&contact)).collect();
            let ridge = ridge_gain(compliance, &touching, network.card.noise_mm / prior_n).select_rows(selected);
            let count = selected.len();
            projection = projection.resize_vertically(p + count, 0.0);
            projection.rows_mut(p, count).copy_from(&(ridge / prior_n));
            offset.resize(p + count, 0.0);
            skip = vec![0.0; outputs.len() * (p + count)];
            for (k, output) in outputs.iter().enumerate() {
                for (i, _) in selected.iter().enumerate().filter(|(_, contact)| *contact == output) {
                    skip[k * (p + count) + p + i] = prior_n as f32;
                }
            }
            if let Some(first) = layers.first_mut() {
                *first = with_mask(first, p, m, selected);
            }
        }
        Prepared { projection, offset, layers, skip }
    }

    /// Number of outputs.
    pub(super) fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.outputs)
    }

    /// Inputs z of a frame, dimensionless, from its displacements, mm.
    pub(super) fn inputs(&self, displacements: &[f64]) -> Vec<f64> {
        let projected = &self.projection * nalgebra::DVectorView::from_slice(displacements, displacements.len());
        projected.iter().zip(&self.offset).map(|(z, offset)| z + offset).collect()
    }

    /// Forces at the inputs z, N, and their derivatives with respect to the inputs, outputs x inputs, N. For L layers, the derivatives are skip plus the
    /// product of W_L, D_{L-1}, W_{L-1} and so on down to D_1 and W_1, with D = 1 - tanh^2.
    pub(super) fn forces_and_derivatives(&self, z: &[f64]) -> (Vec<f64>, DMatrix<f64>) {
        let mut activations = vec![z.to_vec()];
        for (k, layer) in self.layers.iter().enumerate().take(self.layers.len() - 1) {
            activations.push(layer.applied(&activations[k]).iter().map(|sum| sum.tanh()).collect());
        }
        let outputs = self.outputs();
        let mut derivatives = vec![vec![0.0; outputs]; outputs];
        for (k, row) in derivatives.iter_mut().enumerate() {
            row[k] = 1.0;
        }
        for (layer, inputs) in self.layers.iter().zip(&activations).rev() {
            let first = std::ptr::eq(inputs, &activations[0]);
            for row in &mut derivatives {
                let mut back = vec![0.0; layer.inputs];
                for (rate, weights) in row.iter().zip(layer.weights.chunks_exact(layer.inputs)) {
                    for (back, weight) in back.iter_mut().zip(weights) {
                        *back += rate * f64::from(*weight);
                    }
                }
                if !first {
                    back.iter_mut().zip(inputs).for_each(|(back, h)| *back *= 1.0 - h * h);
                }
                *row = back;
            }
        }
        let skip = |row: usize, column: usize| f64::from(self.skip.get(row * z.len() + column).copied().unwrap_or(0.0));
        let of_layers = self.layers.last().zip(activations.last()).map(|(layer, inputs)| layer.applied(inputs));
        let force = |(row, of_layers): (usize, f64)| {
            of_layers + z.iter().enumerate().map(|(column, z)| skip(row, column) * z).sum::<f64>()
        };
        let forces_n = of_layers.unwrap_or_default().into_iter().enumerate().map(force).collect();
        (forces_n, DMatrix::from_fn(outputs, z.len(), |row, column| derivatives[row][column] + skip(row, column)))
    }
}

impl Dense {
    /// Output of the layer without its tanh: W x + b.
    fn applied(&self, x: &[f64]) -> Vec<f64> {
        let rows = self.weights.chunks_exact(self.inputs).zip(&self.bias);
        rows.map(|(weights, bias)| f64::from(*bias) + dot(weights, x)).collect()
    }
}

/// Number of sums in which a product of vectors is added up, so that the compiler can use vector instructions.
const SUMS: usize = 8;

/// Scalar product of vectors of equal length.
fn dot(weights: &[f32], x: &[f64]) -> f64 {
    let (weights, last_weights) = weights.as_chunks::<SUMS>();
    let (x, last_x) = x.as_chunks::<SUMS>();
    let mut sums = [0.0; SUMS];
    for (weights, x) in weights.iter().zip(x) {
        for k in 0..SUMS {
            sums[k] += f64::from(weights[k]) * x[k];
        }
    }
    let rest = last_weights.iter().zip(last_x).map(|(weight, x)| f64::from(*weight) * x);
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}

/// Selected rows of a matrix of `columns` columns. An empty matrix gives an empty result.
fn rows(matrix: &[f32], columns: usize, selected: &[usize]) -> Vec<f32> {
    if matrix.is_empty() {
        return Vec::new();
    }
    selected.iter().flat_map(|&row| &matrix[row * columns..(row + 1) * columns]).copied().collect()
}

/// First layer for forces at the contacts `selected`. The inputs [z, mask, ridge forces] of the first layer are reduced to [z, ridge forces of the
/// selected contacts].
fn with_mask(layer: &Dense, p: usize, contacts: usize, selected: &[usize]) -> Dense {
    let by_row = || layer.weights.chunks_exact(layer.inputs);
    let kept = |row: &[f32]| -> Vec<f32> {
        row[..p].iter().copied().chain(selected.iter().map(|&contact| row[p + contacts + contact])).collect()
    };
    let masked = |(row, bias): (&[f32], &f32)| {
        (f64::from(*bias) + selected.iter().map(|&contact| f64::from(row[p + contact])).sum::<f64>()) as f32
    };
    Dense {
        inputs: p + selected.len(),
        outputs: layer.outputs,
        weights: by_row().flat_map(kept).collect(),
        bias: by_row().zip(&layer.bias).map(masked).collect(),
    }
}
