//! Time in which a network computes forces from the displacements of one frame, on one core. The time is compared with forward passes of the same
//! network in the library burn and in plain nalgebra. The forward passes start from scaled inputs; finray's time includes the scaling, in f64.

use burn_tensor::{Device, Tensor, TensorData, activation};
use criterion::{Criterion, criterion_group, criterion_main};
use finray_bench::paper;
use finray_model::finger::NodeId;
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::network::{
    ContactSet, Dense, FORMAT, Fingerprint, Inputs, Instructions, Network, NetworkCard, NetworkEstimator, Origin,
    Scaling, TestError,
};
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::{Kinematics, Vector};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::hint::black_box;

/// A network with random weights for the paper's finger and the node pair (19, 20); the time does not depend on the weights.
fn network(hidden: &[usize]) -> Network {
    let finger = paper();
    let markers: Vec<NodeId> = finger.free_nodes().collect();
    let contacts: Vec<Contact> =
        [19, 20].map(|node| Contact { position: ContactPosition::Node(NodeId(node)), angle_deg: 0.0 }).to_vec();
    let (n, m) = (2 * markers.len(), contacts.len());
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut random = |scale: f64| rng.random_range(-scale..scale);
    let inputs = Inputs {
        mean: (0..n).map(|_| random(1.0)).collect(),
        projection: DMatrix::from_fn(n, n, |_, _| random(0.3)),
        variances: vec![1.0; n],
        largest: vec![4.0; n],
    };
    let widths: Vec<usize> = [n].into_iter().chain(hidden.iter().copied()).chain([m]).collect();
    let mut dense = |pair: &[usize]| Dense {
        inputs: pair[0],
        outputs: pair[1],
        weights: (0..pair[0] * pair[1]).map(|_| random(1.7 / (pair[0] as f64).sqrt()) as f32).collect(),
        bias: (0..pair[1]).map(|_| random(0.5) as f32).collect(),
    };
    let layers = widths.windows(2).map(&mut dense).collect();
    let skip = (0..m * n).map(|_| random(1.0) as f32).collect();
    let card = NetworkCard {
        format: FORMAT,
        finger: Fingerprint::of(&finger),
        markers,
        contacts,
        contact_set: ContactSet::Fixed,
        scaling: Scaling::Principal,
        noise_mm: 0.067,
        prior_n: 2.9,
        origin: Origin {
            kinematics: Kinematics::Corotational,
            elements_per_member: 4,
            samples: 20_000,
            force_range_n: [0.0, 5.0],
            largest_total_n: 10.0,
            direction_spread_deg: 0.0,
            modulus_spread: 0.0,
            hidden_markers: 0,
            seed: 1,
            epochs: 1,
        },
        test_errors: vec![TestError { rms_n: 0.02, clean_rms_n: 0.01 }; m],
        test_samples: 1,
    };
    Network::new(card, inputs, layers, skip, None).expect("parts that fit")
}

fn ours(criterion: &mut Criterion, network: &Network, name: &str) {
    let marker = |&node: &NodeId| Marker { node, displacement: Vector::new(0.5, -0.5), weight: 1.0 };
    let measurement = Measurement::new(&paper(), network.card.markers.iter().map(marker)).expect("markers");
    let coordinates = measurement.coordinate_count();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let frame: Vec<f64> = (0..coordinates).map(|_| rng.random_range(-1.0..1.0)).collect();
    let mut forces_n = [0.0; 2];
    for (instructions, kind) in [(Instructions::Detected, "detected"), (Instructions::Portable, "portable")] {
        let contacts = &network.card.contacts;
        let mut estimator =
            NetworkEstimator::with_instructions(network, &paper(), contacts, &measurement, instructions)
                .expect("its own");
        criterion.bench_function(&format!("network/{name}/one_frame/{kind}"), |bencher| {
            bencher.iter(|| estimator.forces(black_box(&frame), black_box(&mut forces_n)));
        });
        // The time of `estimate` includes standard deviations and the check whether the frame must be refused. The frame is the mean of the training
        // displacements, hence within the range of the training cases.
        let mean = network.inputs.mean.chunks(2).map(|mean| Vector::new(mean[0], mean[1]));
        let mean = network.card.markers.iter().zip(mean);
        let markers = mean.map(|(&node, displacement)| Marker { node, displacement, weight: 1.0 });
        let mean = Measurement::new(&paper(), markers).expect("markers");
        criterion.bench_function(&format!("network/{name}/estimate/{kind}"), |bencher| {
            bencher.iter(|| estimator.estimate(black_box(&mean), Some(0.067)));
        });
    }
}

fn burn(criterion: &mut Criterion, network: &Network, name: &str) {
    let device = Device::flex();
    let matrix =
        |numbers: &[f32], shape: [usize; 2]| Tensor::<2>::from_data(TensorData::new(numbers.to_vec(), shape), &device);
    let layers: Vec<[Tensor<2>; 2]> = network
        .layers
        .iter()
        .map(|layer| {
            let weights = DMatrix::from_column_slice(layer.inputs, layer.outputs, &layer.weights).transpose();
            // Linear layers of the library burn expect weights with one row per input.
            [matrix(weights.as_slice(), [layer.inputs, layer.outputs]), matrix(&layer.bias, [1, layer.outputs])]
        })
        .collect();
    let width = network.inputs.count();
    let skip = matrix(&network.skip, [network.contact_count(), width]).transpose();
    let inputs = vec![0.5_f32; width];
    criterion.bench_function(&format!("network/{name}/one_frame/burn"), |bencher| {
        bencher.iter(|| {
            let z = matrix(black_box(&inputs), [1, width]);
            let mut h = z.clone();
            for (k, [weights, bias]) in layers.iter().enumerate() {
                h = h.matmul(weights.clone()) + bias.clone();
                if k + 1 < layers.len() {
                    h = activation::tanh(h);
                }
            }
            (h + z.matmul(skip.clone())).into_data()
        });
    });
}

fn nalgebra(criterion: &mut Criterion, network: &Network, name: &str) {
    let layers: Vec<(DMatrix<f32>, DVector<f32>)> = network
        .layers
        .iter()
        .map(|layer| {
            let weights = DMatrix::from_row_slice(layer.outputs, layer.inputs, &layer.weights);
            (weights, DVector::from_column_slice(&layer.bias))
        })
        .collect();
    let width = network.inputs.count();
    let skip = DMatrix::from_row_slice(network.contact_count(), width, &network.skip);
    let z = DVector::from_element(width, 0.5_f32);
    criterion.bench_function(&format!("network/{name}/one_frame/nalgebra"), |bencher| {
        bencher.iter(|| {
            let z = black_box(&z);
            let mut h = z.clone();
            for (k, (weights, bias)) in layers.iter().enumerate() {
                h = weights * h + bias;
                if k + 1 < layers.len() {
                    h.apply(|sum| *sum = sum.tanh());
                }
            }
            h + &skip * z
        });
    });
}

fn networks(criterion: &mut Criterion) {
    for hidden in [vec![150, 200, 150], vec![32, 32]] {
        let network = network(&hidden);
        let widths: Vec<String> = hidden.iter().map(usize::to_string).collect();
        let name = format!("46-{}-2", widths.join("-"));
        ours(criterion, &network, &name);
        burn(criterion, &network, &name);
        nalgebra(criterion, &network, &name);
    }
}

criterion_group!(benches, networks);
criterion_main!(benches);
