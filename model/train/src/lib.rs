//! Training of sensing networks with burn.
//!
//! Random load cases ([`crate::samples`]) become inputs and target forces (`cases`). A linear branch starts from least squares (`regression`), and
//! the layers parallel to it start from random weights. Adam trains both (`descent`). The same recipe and seed give the same weights on the same
//! machine.

mod adam;
mod any_of;
mod cases;
mod descent;
mod recipe;
mod regression;

pub mod samples;

pub use descent::Epoch;
pub use recipe::TrainingRecipe;

use crate::samples::{Samples, SamplesError, Stream};
use cases::Cases;
use descent::{LayerWeights, Weights, descend};
use finray_model::finger::Finger;
use finray_model::sensing::network::{
    ContactSet, Dense, FORMAT, Fingerprint, Network, NetworkCard, NetworkError, Origin, TestError,
};
use rand::RngExt;

/// Reason why no network was trained.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrainError {
    /// A value of the recipe is invalid, or samples could not be drawn.
    #[error(transparent)]
    Samples(#[from] SamplesError),
    /// The trained network is invalid because numbers overflowed.
    #[error("the trained network is unusable: {0}")]
    Network(#[from] NetworkError),
    /// The training library failed.
    #[error("the training library failed: {0}")]
    Backend(String),
}

/// Trains a network for a finger; calls `progress` after each epoch.
///
/// # Errors
/// [`TrainError`] for a recipe that is invalid for this finger, samples that cannot be drawn, or a failed training.
pub fn train(finger: &Finger, recipe: &TrainingRecipe, progress: &mut dyn FnMut(Epoch)) -> Result<Network, TrainError> {
    recipe.check(finger)?;
    let held_out = recipe.held_out();
    let draw = |count: usize, stream: Stream| recipe.samples.draw(finger, count, recipe.seed, stream);
    let training = draw(recipe.count, Stream::Training)?;
    let cases = Cases::new(finger, recipe, &training)?;
    let validation =
        cases.table(&draw(held_out, Stream::Validation)?, Some(Stream::ValidationNoise.rng(recipe.seed, 0)));
    let start = first_weights(recipe, &cases, &training);
    let noisy = |epoch| cases.table(&training, Some(Stream::TrainingNoise.rng(recipe.seed, epoch as u64)));
    let rng = Stream::Weights.rng(recipe.seed, 1);
    let (weights, epochs) = descend(recipe, &start, &noisy, &validation, rng, progress)?;
    let test = draw(held_out, Stream::Test)?;
    let test_errors = test_errors(&cases, &test, &weights, recipe.seed)?;
    let card = NetworkCard {
        format: FORMAT,
        finger: Fingerprint::of(finger),
        markers: training.markers.clone(),
        contacts: recipe.samples.contacts.clone(),
        contact_set: if recipe.samples.any_of { ContactSet::AnyOf } else { ContactSet::Fixed },
        scaling: recipe.scaling,
        noise_mm: recipe.noise_mm,
        prior_n: recipe.prior_n(),
        origin: Origin {
            kinematics: recipe.samples.kinematics,
            elements_per_member: recipe.samples.elements,
            samples: recipe.count,
            force_range_n: [0.0, recipe.samples.largest_force_n],
            largest_total_n: recipe.samples.largest_sum_n,
            direction_spread_deg: recipe.samples.direction_spread_deg,
            modulus_spread: recipe.samples.modulus_spread,
            hidden_markers: finger.marked_nodes().len() - training.markers.len(),
            seed: recipe.seed,
            epochs,
        },
        test_errors,
        test_samples: held_out,
    };
    let (layers, skip) = in_newtons(&weights, &cases);
    let inputs = cases.inputs(&training);
    Ok(Network::new(card, inputs, layers, skip, cases.compliance().cloned())?)
}

/// Initial weights: uniformly random between -1 / sqrt(inputs) and 1 / sqrt(inputs), as in most frameworks. If a linear estimate is added to the
/// output of the layers, training starts from this estimate: the last layer has zero weights and the bias of [`Cases::first_bias`].
fn first_weights(recipe: &TrainingRecipe, cases: &Cases, training: &Samples) -> Weights {
    let mut rng = Stream::Weights.rng(recipe.seed, 0);
    let contacts = recipe.samples.contacts.len();
    let outputs = recipe.hidden_layers.iter().copied().chain([contacts]);
    let mut inputs = cases.input_count();
    let mut layers: Vec<LayerWeights> = Vec::new();
    for outputs in outputs {
        let limit = 1.0 / (inputs as f32).sqrt();
        let mut uniform = |count: usize| (0..count).map(|_| rng.random_range(-limit..limit)).collect::<Vec<f32>>();
        let (weights, bias) = (uniform(inputs * outputs), uniform(outputs));
        layers.push(LayerWeights { inputs, outputs, weights, bias });
        inputs = outputs;
    }
    if let Some(last) = layers.last_mut().filter(|_| cases.starts_from_least_squares()) {
        last.weights.fill(0.0);
        last.bias = cases.first_bias(training);
    }
    Weights { layers, skip: cases.first_skip() }
}

/// Layers and linear branch, with weights in row-major order (outputs x inputs) and outputs scaled from units of force to N.
fn in_newtons(weights: &Weights, cases: &Cases) -> (Vec<Dense>, Vec<f32>) {
    let units = &cases.units_n;
    let last = weights.layers.len() - 1;
    let unit = |layer: usize, output: usize| if layer == last { units[output] as f32 } else { 1.0 };
    let dense = |(k, layer): (usize, &LayerWeights)| Dense {
        inputs: layer.inputs,
        outputs: layer.outputs,
        weights: (0..layer.outputs)
            .flat_map(|row| (0..layer.inputs).map(move |column| (row, column)))
            .map(|(row, column)| layer.weights[column * layer.outputs + row] * unit(k, row))
            .collect(),
        bias: layer.bias.iter().enumerate().map(|(row, bias)| bias * unit(k, row)).collect(),
    };
    let by_rows = |skip: &Vec<f32>| {
        let contacts = units.len();
        let rows = (0..contacts).flat_map(|row| skip.iter().skip(row).step_by(contacts).map(move |w| (row, w)));
        rows.map(|(row, w)| w * units[row] as f32).collect()
    };
    (weights.layers.iter().enumerate().map(dense).collect(), weights.skip.as_ref().map(by_rows).unwrap_or_default())
}

/// Root mean square errors on cases that were not used in training, N.
fn test_errors(cases: &Cases, test: &Samples, weights: &Weights, seed: u64) -> Result<Vec<TestError>, TrainError> {
    let noisy = descent::squared_errors(weights, &cases.table(test, Some(Stream::TestNoise.rng(seed, 0))))?;
    let clean = descent::squared_errors(weights, &cases.table(test, None))?;
    let units = &cases.units_n;
    let rms = |squares: &[f64], i: usize| units[i] * squares[i].sqrt();
    Ok((0..units.len()).map(|i| TestError { rms_n: rms(&noisy, i), clean_rms_n: rms(&clean, i) }).collect())
}
