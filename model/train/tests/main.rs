//! Training of tiny networks within a second. Tiny networks sense nearly as well as noise allows and state their accuracy correctly (`accuracy`).
//! Their training proceeds as configured (`descent`) and follows the recipe (`recipe`). Load cases are drawn in `samples`.

use finray_model::measurement::Measurement;
use finray_model::sensing::Contact;
use finray_model::sensing::network::{Network, NetworkEstimator};
use finray_model::{Kinematics, Mesh, NodeId, statics};
use finray_tests::{CAMERA_NOISE_MM, at_nodes, paper};
use finray_train::samples::{SampleRecipe, Samples, Stream};
use finray_train::{Epoch, TrainingRecipe, train};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

mod accuracy;
mod descent;
mod recipe;
mod samples;

/// Seed of the samples on which networks are tested; the training samples have other seeds.
const FRESH_SEED: u64 = 99;
/// Tolerance between results of training in single precision and the same results in double precision: relative for losses, N for forces.
const SINGLE_PRECISION: f64 = 1e-3;

/// The smallest co-rotational recipe with noise that gives accurate networks.
fn tiny(nodes: &[usize], count: usize, width: usize, epochs: usize) -> TrainingRecipe {
    TrainingRecipe {
        count,
        hidden_layers: vec![width],
        epochs,
        batch: 64,
        learning_rate: 1e-2,
        ..TrainingRecipe::nonlinear(at_nodes(nodes), CAMERA_NOISE_MM)
    }
}

fn trained(recipe: &TrainingRecipe) -> Network {
    train(&paper(), recipe, &mut |_| {}).expect("a possible recipe")
}

/// Trains a network, and also returns the reported epochs.
fn watched(recipe: &TrainingRecipe) -> (Network, Vec<Epoch>) {
    let mut epochs = Vec::new();
    let network = train(&paper(), recipe, &mut |epoch| epochs.push(epoch)).expect("a possible recipe");
    (network, epochs)
}

fn fresh(recipe: &SampleRecipe, count: usize) -> Samples {
    recipe.draw(&paper(), count, FRESH_SEED, Stream::Test).expect("carried")
}

/// Displacements with noise. The random numbers of the added noise are not used in training.
fn noisy_shapes(samples: &Samples, noise_mm: f64) -> DMatrix<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(FRESH_SEED);
    samples.displacements.map(|u| u + noise_mm * rng.sample::<f64, _>(StandardNormal))
}

/// Squared errors of one force, N^2, over the cases in which a force acts at its contact.
#[derive(Debug)]
struct Squares(Vec<f64>);

impl Squares {
    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    fn rms(&self) -> f64 {
        self.mean().sqrt()
    }

    /// Standard deviation of a single squared error.
    fn scatter(&self) -> f64 {
        let mean = self.mean();
        (self.0.iter().map(|square| (square - mean).powi(2)).sum::<f64>() / self.0.len() as f64).sqrt()
    }
}

/// Squared errors of the forces `forces_n` (contacts x cases, N), grouped by contact.
fn squares(samples: &Samples, forces_n: &DMatrix<f64>) -> Vec<Squares> {
    let of = |row: usize| {
        let cases = (0..samples.count()).filter(|&case| samples.touching[case][row]);
        Squares(cases.map(|case| (forces_n[(row, case)] - samples.forces[(row, case)]).powi(2)).collect())
    };
    (0..samples.forces.nrows()).map(of).collect()
}

/// Forces that the network's estimator senses, N; zero for contacts at which no force acts.
fn sensed(network: &Network, samples: &Samples, displacements: &DMatrix<f64>) -> DMatrix<f64> {
    let finger = paper();
    let unloaded = statics::solve(&Mesh::key_nodes(&finger), &[], Kinematics::Linear).expect("at rest");
    let hidden: Vec<NodeId> = finger.free_nodes().filter(|node| !samples.markers.contains(node)).collect();
    let markers = Measurement::of_shape(&finger, &unloaded).without(&hidden);
    let mut forces_n = DMatrix::zeros(samples.forces.nrows(), samples.count());
    for case in 0..samples.count() {
        let touching: Vec<usize> = (0..forces_n.nrows()).filter(|&i| samples.touching[case][i]).collect();
        let contacts: Vec<Contact> = touching.iter().map(|&i| network.card.contacts[i]).collect();
        let mut estimator = NetworkEstimator::new(network, &finger, &contacts, &markers).expect("trained for them");
        let mut found_n = vec![0.0; touching.len()];
        estimator.forces(displacements.column(case).as_slice(), &mut found_n).expect("a frame");
        touching.iter().zip(found_n).for_each(|(&i, force_n)| forces_n[(i, case)] = force_n);
    }
    forces_n
}
