//! Sensing by a neural network: its definition, its file, and its fast evaluation.
//!
//! A network maps measured displacements x (mm: ux, uy of each marker) to inputs z = P (x - mean), and the inputs to forces f (N). For
//! [`ContactSet::Fixed`], the forces are f = skip z + MLP(z). For [`ContactSet::AnyOf`] with forces at the contacts S, ridge regression on the linear
//! finger first gives the forces r = G_S x from the displacements x. For [`ContactSet::AnyOf`], the network then gives the forces f_S = r_S +
//! MLP_S([z, mask, r / prior]). The MLP is a multilayer perceptron: its hidden layers end in tanh, and its last layer is linear.

mod card;
mod error;
mod estimator;
mod file;
mod fingerprint;
mod forward;
mod further;
mod hidden;
mod prepared;

pub use card::{ContactSet, FORMAT, NetworkCard, Origin, Scaling, TestError};
pub use error::NetworkError;
pub use estimator::NetworkEstimator;
pub use fingerprint::{Fingerprint, NoFingerprint};
pub use forward::Instructions;
pub use prepared::ridge_gain;

use error::{require, require_shape};
use nalgebra::DMatrix;

/// Conversion of displacements to inputs: z = P (x - mean), with n coordinates and p <= n inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Mean displacement of the training shapes, length n, mm.
    pub mean: Vec<f64>,
    /// P, p x n, 1/mm. For [`Scaling::Principal`], P has orthogonal rows of length 1 / sqrt(variance_i + noise^2); otherwise P is diagonal.
    pub projection: DMatrix<f64>,
    /// Variance of the noise-free training shapes along the direction of each row of P, length p, mm^2. For scalings other than [`Scaling::Principal`], all
    /// entries are the same squared scale.
    pub variances: Vec<f64>,
    /// Largest |z_i| in training, length p, dimensionless.
    pub largest: Vec<f64>,
}

impl Inputs {
    /// Number of displacement coordinates, n.
    pub fn coordinate_count(&self) -> usize {
        self.mean.len()
    }

    /// Number of inputs, p.
    pub fn count(&self) -> usize {
        self.projection.nrows()
    }
}

/// One dense layer: y = W x + b.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense {
    /// Length of x.
    pub inputs: usize,
    /// Length of y.
    pub outputs: usize,
    /// W by rows, outputs x inputs; in N for the last layer, dimensionless for all others.
    pub weights: Vec<f32>,
    /// b, one entry per output; in N for the last layer, dimensionless for all others.
    pub bias: Vec<f32>,
}

/// A trained network.
///
/// All fields are public, so functions that evaluate or store a network check the network again.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// Purpose, training and errors of the network.
    pub card: NetworkCard,
    /// Conversion of displacements to inputs.
    pub inputs: Inputs,
    /// Layers of the MLP, at least one, all but the last with tanh. The first layer receives the p inputs. For [`ContactSet::AnyOf`], the first layer
    /// has two further inputs per contact. The further inputs for [`ContactSet::AnyOf`] begin with the masks of all contacts: 1 if a force acts at
    /// the contact, otherwise 0. The further inputs for [`ContactSet::AnyOf`] end with the forces of all contacts from ridge regression, divided by
    /// the prior's standard deviation. The last layer returns forces, N.
    pub layers: Vec<Dense>,
    /// Weights of the skip branch by rows, contacts x p, N. Empty without a skip branch, as for [`ContactSet::AnyOf`].
    pub skip: Vec<f32>,
    /// Displacements of the linear finger under 1 N at each contact, n x contacts, mm/N. Only for [`ContactSet::AnyOf`].
    pub compliance: Option<DMatrix<f64>>,
}

impl Network {
    /// Assembles a network from its parts and checks it.
    ///
    /// # Errors
    /// [`NetworkError`] as from [`Network::check`].
    pub fn new(
        card: NetworkCard,
        inputs: Inputs,
        layers: Vec<Dense>,
        skip: Vec<f32>,
        compliance: Option<DMatrix<f64>>,
    ) -> Result<Network, NetworkError> {
        let network = Network { card, inputs, layers, skip, compliance };
        network.check()?;
        Ok(network)
    }

    /// Number of contacts, m.
    pub fn contact_count(&self) -> usize {
        self.card.contacts.len()
    }

    /// Checks that all parts fit together and that every number is finite.
    ///
    /// # Errors
    /// [`NetworkError`] naming the part that does not fit, with the expected and the found value.
    pub fn check(&self) -> Result<(), NetworkError> {
        self.card.check()?;
        let (contacts, p) = (self.contact_count(), self.inputs.count());
        let n = 2 * self.card.markers.len();
        require_shape("mean", &[n], &[self.inputs.mean.len()])?;
        let projection = &self.inputs.projection;
        require((1..=n).contains(&p), "projection", format!("1 to {n} rows"), p)?;
        require_shape("projection", &[p, n], &[p, projection.ncols()])?;
        require_shape("variances", &[p], &[self.inputs.variances.len()])?;
        require_shape("largest", &[p], &[self.inputs.largest.len()])?;
        require_finite("mean", self.inputs.mean.iter().copied())?;
        require_finite("projection", projection.iter().copied())?;
        require_not_negative("variances", &self.inputs.variances)?;
        require_not_negative("largest", &self.inputs.largest)?;

        let any_of = self.card.contact_set == ContactSet::AnyOf;
        let mut inputs = p + if any_of { 2 * contacts } else { 0 };
        for (k, layer) in self.layers.iter().enumerate() {
            let (weights, bias) = (Dense::weights_name(k), Dense::bias_name(k));
            let last = k + 1 == self.layers.len();
            let outputs = if last { contacts } else { layer.outputs };
            require_shape(&weights, &[outputs, inputs], &[layer.outputs, layer.inputs])?;
            require_shape(&weights, &[outputs * inputs], &[layer.weights.len()])?;
            require_shape(&bias, &[outputs], &[layer.bias.len()])?;
            require_finite(&weights, layer.weights.iter().copied().map(f64::from))?;
            require_finite(&bias, layer.bias.iter().copied().map(f64::from))?;
            inputs = outputs;
        }
        let are_layers = !self.layers.is_empty() && inputs > 0;
        require(are_layers, "layers", "at least one layer, none of them empty", self.layers.len())?;
        if !self.skip.is_empty() {
            require_shape("skip", &[if any_of { 0 } else { contacts * p }], &[self.skip.len()])?;
            require_finite("skip", self.skip.iter().copied().map(f64::from))?;
        }
        let compliance_shape = self.compliance.as_ref().map_or([0, 0], |compliance| compliance.shape().into());
        require_shape("compliance", &if any_of { [n, contacts] } else { [0, 0] }, &compliance_shape)?;
        require_finite("compliance", self.compliance.iter().flatten().copied())
    }
}

impl Dense {
    /// Name of the weights of layer `k` in messages and files.
    fn weights_name(k: usize) -> String {
        format!("layers.{k}.weight")
    }

    /// Name of the bias of layer `k` in messages and files.
    fn bias_name(k: usize) -> String {
        format!("layers.{k}.bias")
    }
}

fn require_finite(part: &str, values: impl IntoIterator<Item = f64>) -> Result<(), NetworkError> {
    let wrong = values.into_iter().enumerate().find(|(_, value)| !value.is_finite());
    let found = wrong.map_or_else(String::new, |(index, value)| format!("{value} at index {index}"));
    require(wrong.is_none(), part, "finite numbers", found)
}

fn require_not_negative(part: &str, values: &[f64]) -> Result<(), NetworkError> {
    require_finite(part, values.iter().copied())?;
    let least = values.iter().copied().fold(0.0, f64::min);
    require(least >= 0.0, part, "numbers of zero or more", least)
}
