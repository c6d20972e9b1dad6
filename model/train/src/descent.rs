//! Training with burn: Adam with a cosine learning rate and early stopping on a validation set.

use super::TrainError;
use super::adam::{Parameter, Step, numbers};
use super::recipe::TrainingRecipe;
use burn_tensor::module::linear;
use burn_tensor::{Device, Gradients, Tensor, TensorData};
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Final learning rate as a share of the initial one.
const LEAST_RATE_SHARE: f64 = 1e-4;

/// Inputs and targets, row-major, one row per case.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Table {
    /// Numbers of inputs and of targets per case.
    pub(super) widths: [usize; 2],
    /// Inputs, dimensionless.
    pub(super) inputs: Vec<f32>,
    /// Forces in units of `Cases::units_n`.
    pub(super) targets: Vec<f32>,
    /// Mask of the targets: 1 for a target that counts in the loss, 0 for a target that is ignored. Empty if all targets count.
    pub(super) counts: Vec<f32>,
}

impl Table {
    fn cases(&self) -> usize {
        self.inputs.len() / self.widths[0]
    }

    /// Share of the targets of `cases` that count in the loss.
    fn counted_share(&self, cases: &[usize]) -> f64 {
        if self.counts.is_empty() {
            return 1.0;
        }
        let outputs = self.widths[1];
        let counts = cases.iter().flat_map(|&case| &self.counts[case * outputs..(case + 1) * outputs]);
        counts.copied().map(f64::from).sum::<f64>() / (cases.len() * outputs) as f64
    }

    fn batch(&self, cases: &[usize], device: &Device) -> Batch {
        let gather = |from: &[f32], width: usize| {
            let numbers = cases.iter().flat_map(|&case| &from[case * width..(case + 1) * width]).copied();
            Tensor::from_data(TensorData::new(numbers.collect::<Vec<f32>>(), [cases.len(), width]), device)
        };
        let [inputs, outputs] = self.widths;
        Batch {
            inputs: gather(&self.inputs, inputs),
            targets: gather(&self.targets, outputs),
            counts: (!self.counts.is_empty()).then(|| gather(&self.counts, outputs)),
        }
    }
}

/// Some cases of a table as tensors.
struct Batch {
    inputs: Tensor<2>,
    targets: Tensor<2>,
    counts: Option<Tensor<2>>,
}

/// Weights of all layers as plain numbers in row-major order (inputs x outputs), as in the library burn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Weights {
    /// The dense layers; a tanh follows each layer except the last.
    pub(super) layers: Vec<LayerWeights>,
    /// Weights of the linear branch, inputs x outputs. `None` without a linear branch.
    pub(super) skip: Option<Vec<f32>>,
}

/// Weights and bias of one dense layer; the weights are in row-major order, inputs x outputs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LayerWeights {
    /// Number of inputs.
    pub(super) inputs: usize,
    /// Number of outputs.
    pub(super) outputs: usize,
    pub(super) weights: Vec<f32>,
    pub(super) bias: Vec<f32>,
}

/// A dense layer as tensors: the weights (inputs x outputs) and the bias.
#[derive(Debug)]
struct Dense {
    weight: Parameter<2>,
    bias: Parameter<1>,
}

/// [`Weights`] as tensors.
#[derive(Debug)]
struct Perceptron {
    layers: Vec<Dense>,
    skip: Option<Parameter<2>>,
}

impl Perceptron {
    fn new(weights: &Weights, device: &Device) -> Perceptron {
        let dense = |layer: &LayerWeights| Dense {
            weight: Parameter::new(&layer.weights, [layer.inputs, layer.outputs], device),
            bias: Parameter::new(&layer.bias, [layer.outputs], device),
        };
        let outputs = weights.layers.last().map_or(0, |last| last.outputs);
        let skip = weights.skip.as_ref();
        let skip = skip.map(|skip| Parameter::new(skip, [skip.len() / outputs.max(1), outputs], device));
        Perceptron { layers: weights.layers.iter().map(dense).collect(), skip }
    }

    fn forward(&self, inputs: Tensor<2>) -> Tensor<2> {
        let beside = self.skip.as_ref().map(|skip| inputs.clone().matmul(skip.value()));
        let mut signal = inputs;
        for (k, layer) in self.layers.iter().enumerate() {
            signal = linear(signal, layer.weight.value(), Some(layer.bias.value()));
            if k + 1 < self.layers.len() {
                signal = signal.tanh();
            }
        }
        match beside {
            Some(beside) => signal + beside,
            None => signal,
        }
    }

    /// Squared error of each target, cases x outputs. Zero for targets that do not count.
    fn squared_errors(&self, batch: Batch) -> Tensor<2> {
        let mut error = self.forward(batch.inputs) - batch.targets;
        if let Some(counts) = batch.counts {
            error = error * counts;
        }
        error.clone() * error
    }

    fn step(&mut self, mut gradients: Gradients, step: &Step) -> Result<(), TrainError> {
        for Dense { weight, bias } in &mut self.layers {
            weight.step(&mut gradients, step)?;
            bias.step(&mut gradients, step)?;
        }
        self.skip.as_mut().map_or(Ok(()), |skip| skip.step(&mut gradients, step))
    }

    fn weights(&self) -> Result<Weights, TrainError> {
        let layer = |dense: &Dense| {
            let (weight, bias) = (dense.weight.value(), dense.bias.value());
            let [inputs, outputs] = weight.dims();
            Ok(LayerWeights { inputs, outputs, weights: numbers(weight)?, bias: numbers(bias)? })
        };
        Ok(Weights {
            layers: self.layers.iter().map(layer).collect::<Result<_, TrainError>>()?,
            skip: self.skip.as_ref().map(|skip| numbers(skip.value())).transpose()?,
        })
    }
}

/// Losses of one epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Number of the epoch, from 1.
    pub number: usize,
    /// Mean squared error of the epoch's first batch, averaged over the targets that count. Forces are in units of the linear fit's residual; if
    /// there is no linear fit, in units of their standard deviation.
    pub training_loss: f64,
    /// Mean squared error of the validation set, in the units of `training_loss`.
    pub validation_loss: f64,
}

/// Trains from `start`; returns the weights with the smallest loss on `validation`, and the number of the epoch that gave them. `training` returns
/// the table of an epoch, with a new noise sample for each epoch; `rng` shuffles the cases.
pub(super) fn descend(
    recipe: &TrainingRecipe,
    start: &Weights,
    training: &dyn Fn(usize) -> Table,
    validation: &Table,
    mut rng: ChaCha8Rng,
    progress: &mut dyn FnMut(Epoch),
) -> Result<(Weights, usize), TrainError> {
    let TrainingRecipe { epochs, batch, learning_rate, patience, .. } = *recipe;
    let device = Device::flex().autodiff();
    let mut model = Perceptron::new(start, &device);
    let mut best = (mean_loss(start, validation)?, start.clone(), 0);
    let mut order: Vec<usize> = (0..recipe.count).collect();
    let steps = epochs * order.len().div_ceil(batch);
    let mut step = 0;
    for number in 1..=epochs {
        let table = training(number);
        order.shuffle(&mut rng);
        let mut training_loss = None;
        for cases in order.chunks(batch) {
            let cosine = 0.5 * (1.0 + (PI * step as f64 / steps as f64).cos());
            let loss = model.squared_errors(table.batch(cases, &device)).mean();
            step += 1;
            let rate = learning_rate * cosine.max(LEAST_RATE_SHARE);
            model.step(loss.backward(), &Step::new(step, rate))?;
            if training_loss.is_none() {
                let loss = numbers(loss)?.first().copied();
                training_loss = loss.map(|loss| f64::from(loss) / table.counted_share(cases));
            }
        }
        let weights = model.weights()?;
        let validation_loss = mean_loss(&weights, validation)?;
        progress(Epoch { number, training_loss: training_loss.unwrap_or(0.0), validation_loss });
        if validation_loss < best.0 {
            best = (validation_loss, weights, number);
        } else if number - best.2 >= patience {
            break;
        }
    }
    Ok((best.1, best.2))
}

/// Mean squared error, averaged over the outputs.
fn mean_loss(weights: &Weights, table: &Table) -> Result<f64, TrainError> {
    let errors = squared_errors(weights, table)?;
    Ok(errors.iter().sum::<f64>() / errors.len() as f64)
}

/// Mean squared error of each output over the cases in which the output counts.
pub(super) fn squared_errors(weights: &Weights, table: &Table) -> Result<Vec<f64>, TrainError> {
    let device = Device::flex();
    let model = Perceptron::new(weights, &device);
    let cases: Vec<usize> = (0..table.cases()).collect();
    let errors = numbers(model.squared_errors(table.batch(&cases, &device)))?;
    let outputs = table.widths[1];
    let mean = |i: usize| {
        let sum: f64 = errors.iter().skip(i).step_by(outputs).copied().map(f64::from).sum();
        let counted: f64 = match table.counts.is_empty() {
            true => cases.len() as f64,
            false => table.counts.iter().skip(i).step_by(outputs).copied().map(f64::from).sum(),
        };
        sum / counted.max(1.0)
    };
    Ok((0..outputs).map(mean).collect())
}
