//! Training is reproducible, starts from least squares, stops when patience ends, and keeps the best weights.

use super::{SINGLE_PRECISION, fresh, sensed, squares, tiny, trained, watched};
use finray_model::sensing::network::Network;
use finray_tests::{CAMERA_NOISE_MM, paper};
use finray_train::samples::{Samples, Stream};
use finray_train::{Epoch, TrainingRecipe};
use nalgebra::{DMatrix, DVector};

/// The same recipe gives the same bytes on any number of threads; another seed gives other bytes.
#[test]
fn the_same_seed_gives_the_same_bytes() {
    let mut recipe = tiny(&[16, 20], 300, 8, 4);
    let on = |recipe: &TrainingRecipe, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| trained(recipe).to_bytes().expect("a file"))
    };
    for any_of in [false, true] {
        recipe.samples.any_of = any_of;
        let one = on(&recipe, 1);
        assert!(one == on(&recipe, 1) && one == on(&recipe, 3));
        // The file contains the seed and therefore differs in any case; the weights must differ as well.
        let other = TrainingRecipe { seed: recipe.seed + 1, ..recipe.clone() };
        let other = Network::from_bytes(&on(&other, 1)).expect("a network");
        let one = Network::from_bytes(&one).expect("a network");
        assert_ne!(one.layers, other.layers);
        assert_ne!(one.inputs.mean, other.inputs.mean);
    }
}

/// A recipe with noise-free cases of one contact. The validation loss of this recipe is the mean squared error divided by the variance of the forces.
fn restless() -> TrainingRecipe {
    TrainingRecipe {
        noise_mm: 0.0,
        linear_branch: false,
        batch: 16,
        learning_rate: 0.05,
        patience: 3,
        ..tiny(&[19], 300, 8, 200)
    }
}

/// Training ends as soon as the stated number of consecutive epochs brought no improvement, and not earlier.
#[test]
fn training_stops_when_patience_ends() {
    for patience in [1, 3] {
        let (_, epochs) = watched(&TrainingRecipe { patience, ..restless() });
        let mut best = (f64::INFINITY, 0);
        for (k, epoch) in epochs.iter().enumerate() {
            assert_eq!(epoch.number, k + 1);
            if epoch.validation_loss < best.0 {
                best = (epoch.validation_loss, epoch.number);
            }
            let is_last = k + 1 == epochs.len();
            assert_eq!(epoch.number - best.1 >= patience, is_last, "{epoch:?} of {}, best {best:?}", epochs.len());
        }
    }
}

/// Training keeps the weights of the best epoch, not of the last epoch.
#[test]
fn the_best_weights_are_kept() {
    let recipe = restless();
    let (network, epochs) = watched(&recipe);
    let best = epochs.iter().min_by(|a, b| a.validation_loss.total_cmp(&b.validation_loss)).expect("trained");
    let last = epochs.last().expect("trained");
    assert!(last.validation_loss > 1.1 * best.validation_loss, "{last:?} is as good as {best:?}");
    assert_eq!(network.card.origin.epochs, best.number);
    let draw = |count, stream| recipe.samples.draw(&paper(), count, recipe.seed, stream).expect("carried");
    let variance = draw(recipe.count, Stream::Training).forces.row(0).variance();
    let validation = draw(recipe.count / 5, Stream::Validation);
    let loss = squares(&validation, &sensed(&network, &validation, &validation.displacements))[0].mean() / variance;
    assert!((loss / best.validation_loss - 1.0).abs() <= SINGLE_PRECISION, "{loss}, reported {best:?}");
}

/// If every step increases the loss, training keeps the initial network: a linear regression on the training cases, with the effect of noise in
/// closed form.
#[test]
fn harmful_steps_leave_least_squares() {
    let recipe = TrainingRecipe { learning_rate: 100.0, patience: 2, ..tiny(&[16, 20], 500, 8, 20) };
    let (network, epochs) = watched(&recipe);
    assert_eq!((network.card.origin.epochs, epochs.len()), (0, 2), "{epochs:?}");

    let training = recipe.samples.draw(&paper(), recipe.count, recipe.seed, Stream::Training).expect("carried");
    let mean = DVector::from_column_slice(&network.inputs.mean);
    let inputs = |samples: &Samples| {
        let mut z = samples.displacements.clone();
        z.column_iter_mut().for_each(|mut column| column -= &mean);
        &network.inputs.projection * z
    };
    let z = inputs(&training);
    let cases = training.count() as f64;
    let noise = DMatrix::from_fn(z.nrows(), z.nrows(), |i, j| match i == j {
        true => (CAMERA_NOISE_MM * network.inputs.projection.row(i).norm()).powi(2),
        false => 0.0,
    });
    let mean_n = training.forces.column_mean();
    let normal = &z * z.transpose() / cases + noise;
    let moments =
        &z * (training.forces.transpose() - DVector::repeat(training.count(), 1.0) * mean_n.transpose()) / cases;
    let gain = normal.lu().solve(&moments).expect("whitened inputs");
    let samples = fresh(&recipe.samples, 100);
    let expected_n = gain.transpose() * inputs(&samples) + &mean_n * DVector::repeat(100, 1.0).transpose();
    let off_n = (sensed(&network, &samples, &samples.displacements) - expected_n).amax();
    assert!(off_n <= SINGLE_PRECISION, "{off_n} N");
}

/// Training loss and validation loss are in the same units, also if only some outputs count. At the start, training loss and validation loss agree up
/// to sampling error: the mean square of 500 validation cases has a standard error of about a twentieth.
#[test]
fn losses_are_in_the_same_units() {
    for any_of in [false, true] {
        let mut recipe = TrainingRecipe { batch: 2500, learning_rate: 1e-9, ..tiny(&[16, 18, 20], 2500, 8, 1) };
        recipe.samples.any_of = any_of;
        let Epoch { training_loss, validation_loss, .. } = watched(&recipe).1[0];
        assert!((training_loss / validation_loss - 1.0).abs() <= 0.2, "{training_loss}, {validation_loss}");
    }
}
