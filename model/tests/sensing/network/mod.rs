//! Tests of the sensing network: forces compared with the `burn` library (`forward`), estimates under noise (`estimator`) and with hidden markers
//! (`hidden`), files (`file`), and the fingerprint of the network's finger (`fingerprint`). This file builds networks with random weights.

use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::network::{
    ContactSet, Dense, FORMAT, Fingerprint, Inputs, Instructions, Network, NetworkCard, NetworkEstimator, Origin,
    Scaling, TestError,
};
use finray_model::{Kinematics, NodeId, Vector};
use finray_tests::{CAMERA_NOISE_MM, at_nodes, paper};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

mod estimator;
mod file;
mod fingerprint;
mod forward;
mod hidden;

/// Largest difference of forces, N, between instruction sets, which round and add in a different order.
const BETWEEN_INSTRUCTIONS_N: f64 = 5e-6;

/// A network with random weights for the paper's finger. `hidden` contains the widths of the hidden layers; `directions` is the number of principal
/// directions.
fn random_network(
    seed: u64,
    contacts: &[usize],
    contact_set: ContactSet,
    hidden: &[usize],
    directions: usize,
) -> Network {
    let finger = paper();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let markers: Vec<NodeId> = finger.free_nodes().collect();
    let (n, m) = (2 * markers.len(), contacts.len());
    let noise_mm = CAMERA_NOISE_MM;
    let mut random = |scale: f64| rng.random_range(-scale..scale);
    let v = DMatrix::from_fn(n, n, |_, _| random(1.0)).qr().q();
    let variances: Vec<f64> = (0..directions).map(|i| 25.0 * 0.5_f64.powi(i as i32)).collect();
    let spread: Vec<f64> = variances.iter().map(|variance| (variance + noise_mm * noise_mm).sqrt()).collect();
    let inputs = Inputs {
        mean: (0..n).map(|_| random(3.0)).collect(),
        projection: DMatrix::from_fn(directions, n, |row, column| v[(column, row)] / spread[row]),
        variances,
        largest: vec![4.0; directions],
    };
    let any_of = contact_set == ContactSet::AnyOf;
    let first = directions + if any_of { 2 * m } else { 0 };
    let widths: Vec<usize> = [first].into_iter().chain(hidden.iter().copied()).chain([m]).collect();
    let mut dense = |pair: &[usize]| Dense {
        inputs: pair[0],
        outputs: pair[1],
        weights: (0..pair[0] * pair[1]).map(|_| random(1.7 / (pair[0] as f64).sqrt()) as f32).collect(),
        bias: (0..pair[1]).map(|_| random(0.5) as f32).collect(),
    };
    let layers = widths.windows(2).map(&mut dense).collect();
    let skip = if any_of { Vec::new() } else { (0..m * directions).map(|_| random(1.0) as f32).collect() };
    let compliance = any_of.then(|| DMatrix::from_fn(n, m, |_, _| random(2.0)));
    let card = NetworkCard {
        format: FORMAT,
        finger: Fingerprint::of(&finger),
        markers,
        contacts: at_nodes(contacts),
        contact_set,
        scaling: Scaling::Principal,
        noise_mm,
        prior_n: 2.9,
        origin: Origin {
            kinematics: Kinematics::Corotational,
            elements_per_member: 4,
            samples: 1000,
            // The range is wide, because random weights may lead to forces of any size.
            force_range_n: [-1e3, 1e3],
            largest_total_n: 10.0,
            direction_spread_deg: 0.0,
            modulus_spread: 0.0,
            hidden_markers: 0,
            seed,
            epochs: 1,
        },
        test_errors: vec![TestError { rms_n: 0.02, clean_rms_n: 0.01 }; m],
        test_samples: 100,
    };
    Network::new(card, inputs, layers, skip, compliance).expect("parts that fit")
}

/// A shape that the training might have contained.
fn random_shape(network: &Network, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let z = DVector::from_fn(network.inputs.count(), |_, _| rng.random_range(-2.0..2.0));
    // For an input z of the network, the shape relative to the mean is P^T (P P^T)^-1 z, where P is the projection. P P^T is diagonal, because the
    // rows of P are orthogonal.
    let rows = &network.inputs.projection;
    let scaled = DVector::from_fn(z.len(), |i, _| z[i] / rows.row(i).norm_squared());
    (rows.transpose() * scaled).iter().zip(&network.inputs.mean).map(|(x, mean)| x + mean).collect()
}

fn measured(nodes: &[NodeId], displacements: &[f64]) -> Measurement {
    let marker = |(&node, u): (&NodeId, &[f64])| Marker { node, displacement: Vector::new(u[0], u[1]), weight: 1.0 };
    Measurement::new(&paper(), nodes.iter().zip(displacements.chunks(2)).map(marker)).expect("markers of the finger")
}

fn estimator(network: &Network, contacts: &[usize], instructions: Instructions) -> NetworkEstimator {
    let all = measured(&network.card.markers, &network.inputs.mean);
    NetworkEstimator::with_instructions(network, &paper(), &at_nodes(contacts), &all, instructions)
        .expect("a fitting network")
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}
