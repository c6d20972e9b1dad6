//! The sensing network: its file, its identity, and its evaluation against burn's.

use burn_tensor::{Device, Tensor, TensorData, activation};
use finray_model::finger::{FingerDescription, Joints, Part, RibPlaces, Strip, Zone};
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::network::{
    ContactSet, Dense, FORMAT, Fingerprint, Inputs, Instructions, Network, NetworkCard, NetworkError, NetworkEstimator,
    Origin, Scaling, TestError,
};
use finray_model::sensing::{Contact, ContactPlace, SensingError, Warning};
use finray_model::{Finger, Kinematics, NodeId, Scene, Vector};
use finray_tests::{cases, paper};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Our forces against burn's, which adds in another order and takes another tanh: 1e-5 of the 5 N of training.
const AGAINST_BURN_N: f64 = 5e-5;
/// The same sums on other instructions: they round and add in another order.
const BETWEEN_INSTRUCTIONS_N: f64 = 5e-6;
/// What is computed in f64 both times.
const ROUNDING: f64 = 1e-9;
/// A derivative in f64 against a difference of f32 forces over a step of 1e-2.
const DERIVATIVE: f64 = 2e-3;

fn at_node(node: usize) -> Contact {
    Contact { place: ContactPlace::Node(NodeId(node)), angle_deg: 0.0 }
}

/// A network of random weights for the paper's finger: `hidden` layers, `directions` principal directions.
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
    let noise_mm: f64 = 0.067;
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
        contacts: contacts.iter().map(|&node| at_node(node)).collect(),
        contact_set,
        scaling: Scaling::Principal,
        noise_mm,
        prior_n: 2.9,
        origin: Origin {
            kinematics: Kinematics::Corotational,
            elements_per_member: 4,
            samples: 1000,
            // Random weights give any forces.
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

/// A shape that the training might have held.
fn random_shape(network: &Network, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let z = DVector::from_fn(network.inputs.count(), |_, _| rng.random_range(-2.0..2.0));
    // The rows are orthogonal: P^T (P P^T)^-1 z.
    let rows = &network.inputs.projection;
    let scaled = DVector::from_fn(z.len(), |i, _| z[i] / rows.row(i).norm_squared());
    (rows.transpose() * scaled).iter().zip(&network.inputs.mean).map(|(x, mean)| x + mean).collect()
}

fn measured(nodes: &[NodeId], displacements: &[f64]) -> Measurement {
    let marker = |(&node, u): (&NodeId, &[f64])| Marker { node, displacement: Vector::new(u[0], u[1]), weight: 1.0 };
    Measurement::new(&paper(), nodes.iter().zip(displacements.chunks(2)).map(marker)).expect("markers of the finger")
}

fn estimator(network: &Network, contacts: &[usize], instructions: Instructions) -> NetworkEstimator {
    let contacts: Vec<Contact> = contacts.iter().map(|&node| at_node(node)).collect();
    let all = measured(&network.card.markers, &network.inputs.mean);
    NetworkEstimator::with_instructions(network, &paper(), &contacts, &all, instructions).expect("a fitting network")
}

/// burn's forces for the inputs of the first layer, and what skips to the outputs.
fn burn_forces(network: &Network, inputs: Vec<f64>) -> Vec<f64> {
    let device = Device::flex();
    let matrix =
        |numbers: Vec<f32>, shape: [usize; 2]| Tensor::<2>::from_data(TensorData::new(numbers, shape), &device);
    let inputs = inputs.into_iter().map(|z| z as f32).collect::<Vec<f32>>();
    let width = inputs.len();
    let z = matrix(inputs, [1, width]);
    let mut h = z.clone();
    for (k, layer) in network.layers.iter().enumerate() {
        let weights = matrix(layer.weights.clone(), [layer.outputs, layer.inputs]).transpose();
        h = h.matmul(weights) + matrix(layer.bias.clone(), [1, layer.outputs]);
        if k + 1 < network.layers.len() {
            h = activation::tanh(h);
        }
    }
    if !network.skip.is_empty() {
        h = h + z.matmul(matrix(network.skip.clone(), [network.contact_count(), width]).transpose());
    }
    h.into_data().try_to_vec::<f32>().expect("f32").into_iter().map(f64::from).collect()
}

fn inputs_of(network: &Network, displacements: &[f64]) -> Vec<f64> {
    let from_mean = DVector::from_column_slice(displacements) - DVector::from_column_slice(&network.inputs.mean);
    (&network.inputs.projection * from_mean).iter().copied().collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

proptest! {
    #![proptest_config(cases(24))]

    /// Any widths, also those that fill no register: burn's forces, on detected and on portable instructions, one by one
    /// and many at once, in any order of the contacts.
    #[test]
    fn forces_are_those_of_burn(
        seed in any::<u64>(),
        hidden in prop::collection::vec(1..70_usize, 0..4),
        directions in 1..=46_usize,
        contacts in 1..=12_usize,
        frames in 1..40_usize,
    ) {
        let nodes: Vec<usize> = (13..13 + contacts).collect();
        let network = random_network(seed, &nodes, ContactSet::Fixed, &hidden, directions);
        let shapes: Vec<Vec<f64>> = (0..frames as u64).map(|k| random_shape(&network, seed ^ k)).collect();
        let reversed: Vec<usize> = nodes.iter().rev().copied().collect();
        let mut detected = estimator(&network, &nodes, Instructions::Detected);
        let mut portable = estimator(&network, &nodes, Instructions::Portable);
        let mut backwards = estimator(&network, &reversed, Instructions::Detected);
        let mut many_n = vec![0.0; frames * contacts];
        detected.forces_of_many(&shapes.concat(), &mut many_n).expect("whole frames");
        let mut many_portable_n = vec![0.0; frames * contacts];
        portable.forces_of_many(&shapes.concat(), &mut many_portable_n).expect("whole frames");
        for (k, shape) in shapes.iter().enumerate() {
            let expected_n = burn_forces(&network, inputs_of(&network, shape));
            let (mut one_n, mut portable_n, mut backwards_n) =
                (vec![0.0; contacts], vec![0.0; contacts], vec![0.0; contacts]);
            detected.forces(shape, &mut one_n).expect("a whole frame");
            portable.forces(shape, &mut portable_n).expect("a whole frame");
            backwards.forces(shape, &mut backwards_n).expect("a whole frame");
            backwards_n.reverse();
            let frame = k * contacts..(k + 1) * contacts;
            prop_assert!(largest_difference(&one_n, &expected_n) <= AGAINST_BURN_N, "{one_n:?} against {expected_n:?}");
            for other in [&portable_n, &backwards_n, &many_n[frame.clone()].to_vec(), &many_portable_n[frame].to_vec()] {
                prop_assert!(largest_difference(&one_n, other) <= BETWEEN_INSTRUCTIONS_N, "{one_n:?}, {other:?}");
            }
        }
    }

    /// Of a network for any of twelve contacts, the forces of those that touch are ridge forces and burn's correction.
    #[test]
    fn any_contacts_may_touch(seed in any::<u64>(), touching in prop::sample::subsequence((13..=24).collect::<Vec<usize>>(), 1..=12)) {
        let nodes: Vec<usize> = (13..=24).collect();
        let network = random_network(seed, &nodes, ContactSet::AnyOf, &[40, 30], 30);
        let shape = random_shape(&network, seed);
        let mut forces_n = vec![0.0; touching.len()];
        estimator(&network, &touching, Instructions::Detected).forces(&shape, &mut forces_n).expect("a whole frame");

        let columns: Vec<usize> = touching.iter().map(|node| node - 13).collect();
        let compliance = network.compliance.as_ref().expect("any may touch").select_columns(&columns);
        let ratio = network.card.noise_mm / network.card.prior_n;
        let normal = compliance.transpose() * &compliance + DMatrix::identity(columns.len(), columns.len()) * ratio * ratio;
        let ridge_n = normal.cholesky().expect("positive definite").solve(&(compliance.transpose() * DVector::from_column_slice(&shape)));
        let (mut mask, mut ridge_inputs) = (vec![0.0; 12], vec![0.0; 12]);
        for (k, &column) in columns.iter().enumerate() {
            mask[column] = 1.0;
            ridge_inputs[column] = ridge_n[k] / network.card.prior_n;
        }
        let corrections_n = burn_forces(&network, [inputs_of(&network, &shape), mask, ridge_inputs].concat());
        let expected_n: Vec<f64> = columns.iter().enumerate().map(|(k, &column)| ridge_n[k] + corrections_n[column]).collect();
        prop_assert!(largest_difference(&forces_n, &expected_n) <= AGAINST_BURN_N, "{forces_n:?} against {expected_n:?}");
    }

    /// Files with any bytes changed are refused, and none of them stops the program.
    #[test]
    fn garbled_files_are_refused(changes in prop::collection::vec((any::<prop::sample::Index>(), 1..=255_u8), 1..4)) {
        let bytes = random_network(1, &[19, 20], ContactSet::Fixed, &[3], 4).to_bytes().expect("a file");
        let mut garbled = bytes.clone();
        for (place, change) in changes {
            garbled[place.index(bytes.len())] ^= change;
        }
        prop_assume!(garbled != bytes);
        prop_assert!(Network::from_bytes(&garbled).is_err());
    }
}

/// The widths of the paper.
#[test]
fn forces_of_the_papers_network_are_those_of_burn() {
    let network = random_network(2, &[19, 20], ContactSet::Fixed, &[150, 200, 150], 46);
    let shape = random_shape(&network, 2);
    let expected_n = burn_forces(&network, inputs_of(&network, &shape));
    for instructions in [Instructions::Detected, Instructions::Portable] {
        let mut forces_n = [0.0; 2];
        estimator(&network, &[19, 20], instructions).forces(&shape, &mut forces_n).expect("a frame");
        assert!(largest_difference(&forces_n, &expected_n) <= AGAINST_BURN_N, "{forces_n:?} against {expected_n:?}");
    }
}

#[test]
fn a_file_reads_back_and_is_the_same_every_time() {
    for contact_set in [ContactSet::Fixed, ContactSet::AnyOf] {
        let network = random_network(3, &[16, 20], contact_set, &[7, 5], 9);
        let bytes = network.to_bytes().expect("a file");
        assert_eq!(Network::from_bytes(&bytes).as_ref(), Ok(&network));
        assert_eq!(network.clone().to_bytes().as_ref(), Ok(&bytes));
    }
}

#[test]
fn truncated_files_and_every_changed_byte_are_refused() {
    let bytes = random_network(1, &[19], ContactSet::Fixed, &[2], 2).to_bytes().expect("a file");
    for length in 0..bytes.len() {
        assert!(Network::from_bytes(&bytes[..length]).is_err(), "cut to {length} bytes");
    }
    for place in 0..bytes.len() {
        let mut garbled = bytes.clone();
        garbled[place] ^= 0x10;
        assert!(Network::from_bytes(&garbled).is_err(), "byte {place} changed");
    }
}

#[test]
fn messages_name_what_is_wrong() {
    let network = random_network(1, &[19, 20], ContactSet::Fixed, &[3], 4);
    let mut not_finite = network.clone();
    not_finite.layers[0].weights[5] = f32::NAN;
    let message = not_finite.to_bytes().expect_err("NaN").to_string();
    assert!(message.contains("layers.0.weight") && message.contains("index 5"), "{message}");

    let mut misfit = network.clone();
    misfit.layers[1].inputs = 4;
    let message = misfit.check().expect_err("a misfit").to_string();
    assert!(message.contains("layers.1.weight") && message.contains("[2, 3]"), "{message}");

    let mut newer = network.clone();
    newer.card.format = FORMAT + 1;
    assert_eq!(newer.check(), Err(NetworkError::Format { expected: FORMAT, found: u64::from(FORMAT) + 1 }));

    let tensors =
        [("mean", safetensors::tensor::TensorView::new(safetensors::Dtype::F32, vec![1], &[0; 4]).expect("a view"))];
    let other = safetensors::serialize(tensors, None).expect("a file");
    assert!(matches!(Network::from_bytes(&other), Err(NetworkError::Missing(what)) if what.contains("finray_network")));
}

#[test]
fn what_is_not_a_number_gives_no_force() {
    let network = random_network(1, &[19, 20], ContactSet::Fixed, &[30, 20], 46);
    for instructions in [Instructions::Detected, Instructions::Portable] {
        let mut estimator = estimator(&network, &[19, 20], instructions);
        let mut shapes = [random_shape(&network, 1), random_shape(&network, 2)].concat();
        shapes[50] = f64::NAN;
        let mut forces_n = [0.0; 4];
        estimator.forces_of_many(&shapes, &mut forces_n).expect("two frames");
        assert!(forces_n[..2].iter().all(|force_n| force_n.is_finite()) && forces_n[2..].iter().all(|f| f.is_nan()));
        estimator.forces(&shapes[46..], &mut forces_n[..2]).expect("a frame");
        assert!(forces_n.iter().all(|force_n| force_n.is_nan()));
        assert!(estimator.forces(&shapes, &mut forces_n[..2]).is_err());
        assert!(estimator.forces_of_many(&shapes[1..], &mut forces_n).is_err());
    }
}

#[test]
fn other_fingers_contacts_and_markers_are_refused() {
    let network = random_network(1, &[19, 20], ContactSet::Fixed, &[3], 4);
    let all = measured(&network.card.markers, &network.inputs.mean);
    let new =
        |finger: &Finger, contacts: &[Contact]| NetworkEstimator::new(&network, finger, contacts, &all).map(|_| ());
    let stiffer = paper().with_modulus_factor(1.1).expect("a finger");
    assert!(matches!(new(&stiffer, &[at_node(19), at_node(20)]), Err(NetworkError::AnotherFinger { .. })));
    let tilted = Contact { angle_deg: 10.0, ..at_node(20) };
    for contacts in [vec![at_node(19)], vec![at_node(19), at_node(21)], vec![at_node(19), tilted]] {
        let error = new(&paper(), &contacts).expect_err("other contacts");
        assert!(error.to_string().contains("exactly 19@0, 20@0"), "{error}");
    }
    // The node by its place is the same contact.
    let place_mm = paper().front_place_mm(NodeId(19)).expect("on the front plate");
    assert_eq!(new(&paper(), &[Contact { place: ContactPlace::Place(place_mm), angle_deg: 0.0 }, at_node(20)]), Ok(()));
    let any = random_network(1, &[18, 19, 20], ContactSet::AnyOf, &[3], 4);
    assert!(NetworkEstimator::new(&any, &paper(), &[at_node(20)], &all).is_ok());
    let error = NetworkEstimator::new(&any, &paper(), &[at_node(14)], &all).expect_err("not among them");
    assert!(error.to_string().contains("any of 18@0, 19@0, 20@0, not for 14@0"), "{error}");
}

#[test]
fn sigmas_are_noise_through_the_derivatives_and_the_networks_own_error() {
    for contact_set in [ContactSet::Fixed, ContactSet::AnyOf] {
        let mut network = random_network(5, &[17, 20], contact_set, &[20, 10], 30);
        // Neither part of the sum is lost in the other.
        let (noise_mm, clean_rms_n) = (0.1, 0.3);
        network.card.test_errors = vec![TestError { rms_n: 0.3, clean_rms_n }; 2];
        let mut estimator = estimator(&network, &[17, 20], Instructions::Detected);
        let shape = random_shape(&network, 6);
        let estimate = estimator
            .estimate(&measured(&network.card.markers, &shape), Some(noise_mm))
            .expect("a shape as in training");
        let step_mm = 1e-2;
        let mut squares = [0.0; 2];
        for k in 0..shape.len() {
            let mut forces_n = [[0.0; 2]; 2];
            for (forces_n, sign) in forces_n.iter_mut().zip([-0.5, 0.5]) {
                let mut shifted = shape.clone();
                shifted[k] += sign * step_mm;
                estimator.forces(&shifted, forces_n).expect("a frame");
            }
            for (i, square) in squares.iter_mut().enumerate() {
                *square += ((forces_n[1][i] - forces_n[0][i]) / step_mm * noise_mm).powi(2);
            }
        }
        for (sigma_n, square) in estimate.sigmas_n.iter().zip(squares) {
            let expected_n = f64::sqrt(square + clean_rms_n * clean_rms_n);
            assert!((sigma_n / expected_n - 1.0).abs() <= DERIVATIVE, "{sigma_n} against {expected_n}");
        }
        assert!(estimate.residual_rms_mm <= ROUNDING, "{}", estimate.residual_rms_mm);
    }
}

#[test]
fn noise_that_the_residual_contradicts_is_not_believed() {
    let network = random_network(5, &[17, 20], ContactSet::Fixed, &[20], 10);
    let mut estimator = estimator(&network, &[17, 20], Instructions::Detected);
    let shape = random_shape(&network, 6);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let noisy: Vec<f64> = shape.iter().map(|x| x + rng.random_range(-0.5..0.5)).collect();
    let measurement = measured(&network.card.markers, &noisy);
    let unknown = estimator.estimate(&measurement, None).expect("noise alone");
    // 36 coordinates of uniform noise between -0.5 and 0.5, of standard deviation 0.29.
    assert!((0.2..0.4).contains(&unknown.noise_mm), "{}", unknown.noise_mm);
    let contradicted = estimator.estimate(&measurement, Some(0.067)).expect("noise alone");
    assert!(matches!(contradicted.warning, Some(Warning::Residual(_))));
    assert_eq!((&contradicted.forces_n, contradicted.residual_rms_mm), (&unknown.forces_n, unknown.residual_rms_mm));
    // Where nothing was stated the residual is all that is known of the noise: Student's t for 36 degrees of freedom, 2.0281, over 1.9600.
    let wider = unknown.noise_mm / contradicted.noise_mm;
    assert!((wider - 2.0281 / 1.959_96).abs() < 1e-4, "{wider}");
    let believed = estimator.estimate(&measurement, Some(0.25)).expect("noise alone");
    assert_eq!((believed.noise_mm, believed.warning), (0.25, None));
}

#[test]
fn strange_shapes_are_refused() {
    let network = random_network(5, &[17, 20], ContactSet::Fixed, &[20], 10);
    let mut estimator = estimator(&network, &[17, 20], Instructions::Detected);
    let shape = random_shape(&network, 6);
    let far: Vec<f64> = shape.iter().zip(&network.inputs.mean).map(|(x, mean)| mean + 10.0 * (x - mean)).collect();
    let refused = estimator.estimate(&measured(&network.card.markers, &far), Some(0.067));
    assert!(matches!(refused, Err(NetworkError::OutsideTraining { .. })), "{refused:?}");
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let noisy: Vec<f64> = shape.iter().map(|x| x + rng.random_range(-9.0..9.0)).collect();
    let refused = estimator.estimate(&measured(&network.card.markers, &noisy), Some(0.067));
    assert!(matches!(refused, Err(NetworkError::Sensing(SensingError::Unexplained { .. }))), "{refused:?}");
    let mut weighted: Vec<Marker> = measured(&network.card.markers, &shape).markers().to_vec();
    weighted[3].weight = 0.5;
    let refused = estimator.estimate(&Measurement::new(&paper(), weighted).expect("markers"), Some(0.067));
    assert!(matches!(refused, Err(NetworkError::Weighted { .. })), "{refused:?}");
}

/// Directions few enough that half of the markers tell them: hidden markers are filled in, and sigmas grow.
#[test]
fn hidden_markers_are_filled_in() {
    let network = random_network(5, &[17, 20], ContactSet::Fixed, &[20], 10);
    let contacts = [at_node(17), at_node(20)];
    let shape = random_shape(&network, 6);
    let all = measured(&network.card.markers, &shape);
    let full = estimator(&network, &[17, 20], Instructions::Detected).estimate(&all, Some(0.067)).expect("all markers");
    let mut wider = full.sigmas_n.clone();
    for hidden in [3_usize, 8, 12] {
        let seen = all.clone().without(&network.card.markers[..hidden]);
        let mut estimator = NetworkEstimator::new(&network, &paper(), &contacts, &seen).expect("some markers");
        let estimate = estimator.estimate(&seen, Some(0.067)).expect("some markers");
        for i in 0..2 {
            let error_n = (estimate.forces_n[i] - full.forces_n[i]).abs();
            assert!(
                error_n <= 4.0 * estimate.sigmas_n[i],
                "{hidden} hidden: {error_n} N off, sigma {}",
                estimate.sigmas_n[i]
            );
            assert!(estimate.sigmas_n[i] > wider[i], "{hidden} hidden");
        }
        wider = estimate.sigmas_n;
    }
    // The order of the markers is that of the measurement.
    let reversed: Vec<Marker> = all.markers().iter().rev().copied().collect();
    let reversed = Measurement::new(&paper(), reversed).expect("markers");
    let mut estimator = NetworkEstimator::new(&network, &paper(), &contacts, &reversed).expect("all markers");
    let estimate = estimator.estimate(&reversed, Some(0.067)).expect("all markers");
    assert!(largest_difference(&estimate.forces_n, &full.forces_n) <= BETWEEN_INSTRUCTIONS_N);
    assert_eq!(estimator.estimate(&all, None), Err(NetworkError::OtherMarkers));

    let mut coordinates = network;
    coordinates.card.scaling = Scaling::Spread;
    let refused = NetworkEstimator::new(&coordinates, &paper(), &contacts, &all.without(&[NodeId(5)])).map(|_| ());
    assert_eq!(refused, Err(NetworkError::HiddenMarkers { expected: 23, found: 22 }));
}

/// With fewer seen coordinates than directions much stays open, and sigmas say how much: over shapes drawn as the network
/// supposes, a linear one is off by its sigmas.
#[test]
fn sigmas_tell_what_hidden_markers_leave_open() {
    const DRAWS: usize = 1000;
    /// The ratio of 1000 errors to their standard deviation scatters by 1 / sqrt(2000); four times that.
    const SCATTER: f64 = 0.09;
    let mut network = random_network(5, &[17, 20], ContactSet::Fixed, &[], 10);
    network.card.test_errors = vec![TestError { rms_n: 0.0, clean_rms_n: 0.0 }; 2];
    network.inputs.largest = vec![10.0; 10];
    let contacts = [at_node(17), at_node(20)];
    let noise_mm = network.card.noise_mm;
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut whole = estimator(&network, &[17, 20], Instructions::Detected);
    let hidden = &network.card.markers[..20];
    let markers = measured(&network.card.markers, &network.inputs.mean).without(hidden);
    let mut partial = NetworkEstimator::new(&network, &paper(), &contacts, &markers).expect("some markers");
    let mut squares = [0.0; 2];
    for _ in 0..DRAWS {
        let mut shape = network.inputs.mean.clone();
        for (row, variance) in network.inputs.projection.row_iter().zip(&network.inputs.variances) {
            let coefficient = variance.sqrt() * rng.sample::<f64, _>(StandardNormal);
            shape.iter_mut().zip((row / row.norm()).iter()).for_each(|(x, v)| *x += coefficient * v);
        }
        let mut forces_n = [0.0; 2];
        whole.forces(&shape, &mut forces_n).expect("a frame");
        let mut seen = measured(&network.card.markers, &shape).without(hidden);
        seen.add_noise(noise_mm, || rng.sample(StandardNormal));
        let estimate = partial.estimate(&seen, Some(noise_mm)).expect("some markers");
        for (i, square) in squares.iter_mut().enumerate() {
            *square += ((estimate.forces_n[i] - forces_n[i]) / estimate.sigmas_n[i]).powi(2);
        }
    }
    for square in squares {
        let ratio = f64::sqrt(square / DRAWS as f64);
        assert!((ratio - 1.0).abs() <= SCATTER, "errors are {ratio} times their sigmas");
    }
}

fn changed(change: impl Fn(&mut FingerDescription)) -> Fingerprint {
    let mut description = paper().description().clone();
    change(&mut description);
    Fingerprint::of(&Finger::new(description).expect("a finger"))
}

#[test]
fn a_fingerprint_is_that_of_the_numbers() {
    let fingerprint = Fingerprint::of(&paper());
    let place = |i: usize| 153.0 * i as f64 / 12.0;
    let by_hand = changed(|d| d.ribs.places = RibPlaces::Positions((1..=11).map(|i| [place(i), place(i)]).collect()));
    assert_eq!(by_hand, fingerprint);
    let third =
        changed(|d| d.ribs.places = RibPlaces::Positions((1..=11).map(|i| [51.0 * i as f64 / 4.0; 2]).collect()));
    assert_eq!(third, fingerprint);
    let renamed = finray_fixtures::PAPER_SCENE.replace("name = \"paper\"", "name = \"mine\"");
    assert_eq!(Fingerprint::of(&Scene::from_toml(&renamed).expect("a scene").finger), fingerprint);
    assert_eq!(fingerprint.to_string().parse(), Ok(fingerprint));
    assert!("0123".parse::<Fingerprint>().is_err());
    // Thickness and modulus count through EA and EI: E / (1 - nu^2) is what is compared.
    let plane_strain = changed(|d| {
        d.poissons_ratio = 0.4;
        let softer = |strip: &mut Strip| strip.youngs_modulus_mpa *= 1.0 - 0.16;
        softer(&mut d.front);
        softer(&mut d.back);
        d.ribs.strip.as_mut().into_iter().for_each(softer);
    });
    assert_eq!(plane_strain, fingerprint);
}

#[test]
fn every_number_counts_in_a_fingerprint() {
    let zone = |part, from_mm, to_mm, modulus_factor| Zone { part, from_mm, to_mm, modulus_factor };
    let a_bit = 1.0 + 1e-8;
    let ribs = |i: usize, j: usize| {
        move |d: &mut FingerDescription| {
            let mut places: Vec<[f64; 2]> = (1..=11).map(|k| [12.75 * k as f64; 2]).collect();
            places[i][j] *= 1.0 + 1e-8;
            d.ribs.places = RibPlaces::Positions(places);
        }
    };
    let fingers = [
        changed(|_| {}),
        changed(|d| d.base_width_mm *= a_bit),
        changed(|d| d.front_length_mm *= a_bit),
        changed(|d| d.back_length_mm *= a_bit),
        changed(|d| d.depth_mm *= a_bit),
        changed(|d| d.rod_arm_mm = 1e-3),
        changed(|d| d.poissons_ratio = 1e-3),
        changed(|d| d.front.thickness_mm *= a_bit),
        changed(|d| d.front.youngs_modulus_mpa *= a_bit),
        changed(|d| d.back.thickness_mm *= a_bit),
        changed(|d| d.back.youngs_modulus_mpa *= a_bit),
        changed(|d| d.ribs.strip.as_mut().expect("elastic ribs").thickness_mm *= a_bit),
        changed(|d| d.ribs.strip.as_mut().expect("elastic ribs").youngs_modulus_mpa *= a_bit),
        changed(|d| d.ribs.strip = None),
        changed(|d| d.ribs.joints = Joints::Hinged),
        changed(|d| d.ribs.places = RibPlaces::Count(10)),
        changed(ribs(4, 0)),
        changed(ribs(4, 1)),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Back, 10.0, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Ribs, 10.0, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0 * a_bit, 20.0, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0 * a_bit, 0.5)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0, 0.5 * a_bit)]),
        changed(|d| d.zones = vec![zone(Part::Front, 10.0, 20.0, 0.5); 2]),
    ];
    for (i, one) in fingers.iter().enumerate() {
        for (j, other) in fingers.iter().enumerate().skip(i + 1) {
            assert_ne!(one, other, "{i} and {j}");
        }
    }
    let (a, b) = (zone(Part::Front, 10.0, 20.0, 0.5), zone(Part::Ribs, 30.0, 90.0, 2.0));
    assert_eq!(changed(|d| d.zones = vec![a, b]), changed(|d| d.zones = vec![b, a]));
}
