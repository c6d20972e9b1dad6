//! Training of sensing networks: tiny ones that train in a second must sense nearly as well as the noise allows, say
//! truly how well they do, and be the same every time.

use finray_model::compliance::Compliance;
use finray_model::measurement::Measurement;
use finray_model::mesh::FingerShape;
use finray_model::samples::{SampleRecipe, Samples, SamplesError, Stream};
use finray_model::sensing::network::{ContactSet, Network, NetworkEstimator, Scaling};
use finray_model::sensing::{Contact, ContactPlace, SensingError};
use finray_model::train::{Epoch, TrainError, TrainingRecipe, train};
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector, statics};
use finray_tests::paper;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Standard deviation of the camera's coordinates, mm.
const NOISE_MM: f64 = 0.067;
/// Seed of the samples that networks are tested on; they are trained on others.
const FRESH_SEED: u64 = 99;
/// Random deviations allowed, in standard errors: among some hundred figures one beyond them is met once in a hundred runs.
const STANDARD_ERRORS: f64 = 4.0;
/// Tiny networks are measured at 1.2 to 1.6 times the Cramer-Rao bound; the rest is for other machines' rounding, which
/// training magnifies.
const OVER_BOUND: f64 = 2.0;
/// They err by a twentieth or less of what the linear finger does, measured over all contacts below.
const OF_LINEAR: f64 = 0.1;
/// Losses that training finds in single precision against the same from forces in N, relative.
const SINGLE_PRECISION: f64 = 1e-3;

fn at_nodes(nodes: &[usize]) -> Vec<Contact> {
    nodes.iter().map(|&node| Contact { place: ContactPlace::Node(NodeId(node)), angle_deg: 0.0 }).collect()
}

/// Large rotations and noise, as small as serves.
fn tiny(nodes: &[usize], count: usize, width: usize, epochs: usize) -> TrainingRecipe {
    TrainingRecipe {
        count,
        hidden_layers: vec![width],
        epochs,
        batch: 64,
        learning_rate: 1e-2,
        ..TrainingRecipe::nonlinear(at_nodes(nodes), NOISE_MM)
    }
}

fn trained(recipe: &TrainingRecipe) -> Network {
    train(&paper(), recipe, &mut |_| {}).expect("a possible recipe")
}

/// Trains, and keeps what progress reports.
fn watched(recipe: &TrainingRecipe) -> (Network, Vec<Epoch>) {
    let mut epochs = Vec::new();
    let network = train(&paper(), recipe, &mut |epoch| epochs.push(epoch)).expect("a possible recipe");
    (network, epochs)
}

fn fresh(recipe: &SampleRecipe, count: usize) -> Samples {
    recipe.draw(&paper(), count, FRESH_SEED, Stream::Test).expect("carried")
}

/// Displacements with noise from random numbers that no training has.
fn noisy(samples: &Samples, noise_mm: f64) -> DMatrix<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(FRESH_SEED);
    samples.displacements.map(|u| u + noise_mm * rng.sample::<f64, _>(StandardNormal))
}

/// Squared errors of one force, N^2, over the cases in which its contact touches.
#[derive(Debug)]
struct Squares(Vec<f64>);

impl Squares {
    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    fn rms(&self) -> f64 {
        self.mean().sqrt()
    }

    /// Standard deviation of one square.
    fn scatter(&self) -> f64 {
        let mean = self.mean();
        (self.0.iter().map(|square| (square - mean).powi(2)).sum::<f64>() / self.0.len() as f64).sqrt()
    }
}

/// Errors of forces (contacts x cases, N) by contact.
fn squares(samples: &Samples, forces_n: &DMatrix<f64>) -> Vec<Squares> {
    let of = |row: usize| {
        let cases = (0..samples.count()).filter(|&case| samples.touching[case][row]);
        Squares(cases.map(|case| (forces_n[(row, case)] - samples.forces[(row, case)]).powi(2)).collect())
    };
    (0..samples.forces.nrows()).map(of).collect()
}

/// Forces that the network's estimator senses, N; zero where a contact does not touch.
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

/// Forces that the linear finger explains the displacements by, N: least squares, or with a prior ridge.
fn linear_forces(recipe: &SampleRecipe, samples: &Samples, displacements: &DMatrix<f64>, ridge: f64) -> DMatrix<f64> {
    let finger = paper();
    let loads: Vec<Load> = recipe.contacts.iter().map(|contact| contact.unit_load(&finger)).collect();
    let compliance = Compliance::new(&finger, &loads).expect("contact nodes");
    let matrix = DMatrix::from_fn(displacements.nrows(), loads.len(), |row, load| {
        compliance.displacement(samples.markers[row / 2], load)[row % 2]
    });
    let mut forces_n = DMatrix::zeros(loads.len(), samples.count());
    for case in 0..samples.count() {
        let touching: Vec<usize> = (0..loads.len()).filter(|&i| samples.touching[case][i]).collect();
        let c = matrix.select_columns(&touching);
        let normal = c.transpose() * &c + DMatrix::identity(touching.len(), touching.len()) * ridge * ridge;
        let found_n = normal.cholesky().expect("contacts apart").solve(&(c.transpose() * displacements.column(case)));
        touching.iter().zip(found_n.iter()).for_each(|(&i, force_n)| forces_n[(i, case)] = *force_n);
    }
    forces_n
}

/// Cramer-Rao bound of each force, root mean square over the cases, N: noise^2 (J^T J)^-1 with J the derivatives of the
/// large-rotation finger's displacements by the forces, from differences.
fn bounds_n(recipe: &SampleRecipe, samples: &Samples, noise_mm: f64) -> Vec<f64> {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, recipe.elements);
    let step_n = 1e-3;
    let shape = |forces_n: &DVector<f64>| -> FingerShape {
        let load = |(contact, force_n): (&Contact, &f64)| contact.load(&finger, *force_n);
        let loads: Vec<Load> = recipe.contacts.iter().zip(forces_n.iter()).map(load).collect();
        statics::solve(&mesh, &loads, recipe.kinematics).expect("carried")
    };
    let mut variances = vec![0.0; recipe.contacts.len()];
    for forces in samples.forces.column_iter() {
        let columns: Vec<DVector<f64>> = (0..forces.len())
            .map(|i| {
                let step = DVector::from_fn(forces.len(), |j, _| if i == j { step_n } else { 0.0 });
                let (more, less) = (shape(&(forces + &step)), shape(&(forces - &step)));
                let rate = |node: &NodeId| -> Vector {
                    (more.motion(*node).displacement - less.motion(*node).displacement) / (2.0 * step_n)
                };
                let rates = samples.markers.iter().map(rate).flat_map(|rate| [rate.x, rate.y]);
                DVector::from_iterator(2 * samples.markers.len(), rates)
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let covariance = (jacobian.transpose() * jacobian).try_inverse().expect("forces are told apart");
        (0..forces.len()).for_each(|i| variances[i] += covariance[(i, i)] * noise_mm * noise_mm);
    }
    variances.iter().map(|sum| (sum / samples.count() as f64).sqrt()).collect()
}

/// A second's training senses large rotations under noise: near the bound, and far better than the linear finger.
#[test]
fn tiny_networks_sense_the_nonlinear_finger() {
    for nodes in [&[19][..], &[16, 20], &[19, 20]] {
        let recipe = tiny(nodes, 2000, 16, 60);
        let network = trained(&recipe);
        let samples = fresh(&recipe.samples, 500);
        let displacements = noisy(&samples, NOISE_MM);
        let found = squares(&samples, &sensed(&network, &samples, &displacements));
        let linear = squares(&samples, &linear_forces(&recipe.samples, &samples, &displacements, 0.0));
        let bounds = bounds_n(&recipe.samples, &samples, NOISE_MM);
        for ((found, linear), bound) in found.iter().zip(&linear).zip(bounds) {
            let (found, linear) = (found.rms(), linear.rms());
            assert!(found <= OVER_BOUND * bound, "{nodes:?}: {found} N, bound {bound} N");
            assert!(found <= OF_LINEAR * linear, "{nodes:?}: {found} N, linear {linear} N");
        }
    }
}

/// The paper's recipe, smaller: inputs that are coordinates, no linear branch, the linear finger without noise.
#[test]
fn coordinates_serve_as_inputs() {
    let recipe = TrainingRecipe {
        count: 1000,
        hidden_layers: vec![16, 16],
        epochs: 60,
        batch: 64,
        learning_rate: 1e-2,
        ..TrainingRecipe::paper(at_nodes(&[19]))
    };
    let network = trained(&recipe);
    let samples = fresh(&recipe.samples, 500);
    let found = squares(&samples, &sensed(&network, &samples, &samples.displacements))[0].rms();
    // Measured: 0.024 N of 0 to 5 N.
    assert!(found <= 0.06, "{found} N");
}

/// A network for any of three contacts mends the ridge forces of those that touch, with noise and without.
#[test]
fn any_contacts_may_touch() {
    let mut recipe = tiny(&[16, 18, 20], 2000, 16, 60);
    recipe.samples.any_of = true;
    let network = trained(&recipe);
    assert_eq!(network.card.contact_set, ContactSet::AnyOf);
    let samples = fresh(&recipe.samples, 1000);
    let ridge = NOISE_MM / network.card.prior_n;
    for noise_mm in [0.0, NOISE_MM] {
        let displacements = noisy(&samples, noise_mm);
        let found = squares(&samples, &sensed(&network, &samples, &displacements));
        let start = squares(&samples, &linear_forces(&recipe.samples, &samples, &displacements, ridge));
        for (found, start) in found.iter().zip(&start) {
            let (found, start) = (found.rms(), start.rms());
            assert!(found <= OF_LINEAR * start, "{found} N, ridge {start} N");
        }
        assert_stated(&network, &found, noise_mm);
    }
}

/// Checks errors on fresh samples against those that the network states, with what chance allows for both.
fn assert_stated(network: &Network, found: &[Squares], noise_mm: f64) {
    for (found, stated) in found.iter().zip(&network.card.test_errors) {
        let stated_n = if noise_mm == 0.0 { stated.clean_rms_n } else { stated.rms_n };
        let cases = 1.0 / found.0.len() as f64 + 1.0 / network.card.test_samples as f64;
        let chance = STANDARD_ERRORS * found.scatter() * cases.sqrt();
        assert!((stated_n.powi(2) - found.mean()).abs() <= chance, "{stated_n} N stated, {} N found", found.rms());
    }
}

/// What the card says of the error is what the estimator has on samples of another seed.
#[test]
fn stated_errors_are_those_of_fresh_samples() {
    for (nodes, scaling) in [(&[19][..], Scaling::Principal), (&[16, 20], Scaling::Largest)] {
        let recipe = TrainingRecipe { scaling, ..tiny(nodes, 3000, 8, 10) };
        let network = trained(&recipe);
        let samples = fresh(&recipe.samples, 3000);
        for noise_mm in [0.0, NOISE_MM] {
            let displacements = noisy(&samples, noise_mm);
            assert_stated(&network, &squares(&samples, &sensed(&network, &samples, &displacements)), noise_mm);
        }
    }
}

/// The same recipe gives the same bytes on any number of threads, another seed others.
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
        // The seed is written down: what it changes are the weights.
        let other = TrainingRecipe { seed: recipe.seed + 1, ..recipe.clone() };
        let other = Network::from_bytes(&on(&other, 1)).expect("a network");
        let one = Network::from_bytes(&one).expect("a network");
        assert_ne!(one.layers, other.layers);
        assert_ne!(one.inputs.mean, other.inputs.mean);
    }
}

/// Noise-free cases of one contact, whose validation loss is the error in units of the forces' spread.
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

/// Training ends once so many epochs in a row were no better, and not before.
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

/// The weights of the best epoch are those that are kept, not those of the last.
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

/// Steps that only do harm leave the start: linear regression on the training cases, the noise's part in closed form.
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
        true => (NOISE_MM * network.inputs.projection.row(i).norm()).powi(2),
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

/// Both losses of progress are in the same units, also where only some outputs count: at the start they agree within
/// chance, which leaves the mean square of 500 validation cases to a twentieth.
#[test]
fn losses_are_in_the_same_units() {
    for any_of in [false, true] {
        let mut recipe = TrainingRecipe { batch: 2500, learning_rate: 1e-9, ..tiny(&[16, 18, 20], 2500, 8, 1) };
        recipe.samples.any_of = any_of;
        let Epoch { training_loss, validation_loss, .. } = watched(&recipe).1[0];
        assert!((training_loss / validation_loss - 1.0).abs() <= 0.2, "{training_loss}, {validation_loss}");
    }
}

/// The card tells the recipe; markers that are hidden twice, or clamped, are hidden once.
#[test]
fn the_card_tells_the_recipe() {
    let mut recipe = tiny(&[16, 20], 100, 4, 2);
    recipe.samples.hidden = [19, 2, 19, 25].map(NodeId).to_vec();
    recipe.samples.direction_spread_deg = 2.0;
    recipe.samples.modulus_spread = 0.01;
    recipe.seed = 5;
    let network = trained(&recipe);
    let card = &network.card;
    let seen: Vec<NodeId> = paper().free_nodes().filter(|node| ![2, 19].contains(&node.0)).collect();
    assert_eq!((&card.markers, card.origin.hidden_markers), (&seen, 2));
    assert_eq!((&card.contacts, card.contact_set), (&recipe.samples.contacts, ContactSet::Fixed));
    assert_eq!((card.noise_mm, card.scaling, card.test_samples), (NOISE_MM, Scaling::Principal, 20));
    let origin = card.origin;
    assert_eq!((origin.kinematics, origin.elements_per_member), (Kinematics::Corotational, 4));
    assert_eq!((origin.samples, origin.seed), (100, 5));
    assert_eq!((origin.force_range_n, origin.largest_total_n), ([0.0, 5.0], 10.0));
    assert_eq!((origin.direction_spread_deg, origin.modulus_spread), (2.0, 0.01));
    let samples = fresh(&recipe.samples, 5);
    assert!(sensed(&network, &samples, &samples.displacements).iter().all(|force_n| force_n.is_finite()));
}

#[test]
fn impossible_recipes_are_refused() {
    let finger = paper();
    let refused = |change: &dyn Fn(&mut TrainingRecipe)| {
        let mut recipe = tiny(&[19, 20], 10, 4, 1);
        change(&mut recipe);
        train(&finger, &recipe, &mut |_| {}).expect_err("an impossible recipe")
    };
    let names = |change: &dyn Fn(&mut TrainingRecipe), wrong: &str| match refused(change) {
        TrainError::Recipe { key, .. } => assert_eq!(key, wrong),
        other => panic!("{wrong}: {other:?}"),
    };
    for count in [0, 1] {
        names(&|recipe| recipe.count = count, "count");
    }
    for noise_mm in [f64::NAN, f64::INFINITY, -0.1] {
        names(&|recipe| recipe.noise_mm = noise_mm, "noise_mm");
    }
    for rate in [f64::NAN, f64::INFINITY, -1e-3, 0.0] {
        names(&|recipe| recipe.learning_rate = rate, "learning_rate");
    }
    names(&|recipe| recipe.hidden_layers = vec![8, 0], "hidden_layers");
    names(&|recipe| recipe.epochs = 0, "epochs, batch");
    names(&|recipe| recipe.batch = 0, "epochs, batch");
    names(&|recipe| recipe.samples.largest_force_n = f64::NAN, "largest_force_n");
    names(&|recipe| recipe.samples.modulus_spread = -1.0, "modulus_spread");
    // No marker left, and two coordinates for three forces.
    names(&|recipe| recipe.samples.hidden = paper().free_nodes().collect(), "hidden");
    let one_seen = |recipe: &mut TrainingRecipe| {
        recipe.samples.contacts = at_nodes(&[16, 18, 20]);
        recipe.samples.hidden = paper().free_nodes().filter(|node| node.0 != 15).collect();
    };
    names(&one_seen, "hidden");
    let message = refused(&|recipe| recipe.noise_mm = f64::NAN).to_string();
    assert_eq!(message, "noise_mm: expected mm, zero or more, found NaN");
    let elsewhere = refused(&|recipe| recipe.samples.contacts = at_nodes(&[7]));
    assert!(matches!(elsewhere, TrainError::Samples(SamplesError::Contacts(SensingError::NotAContactNode { .. }))));
}
