//! On all instruction sets, forces of a network equal the forces that the `burn` library computes. Input outside the range of the training is
//! refused.

use super::{BETWEEN_INSTRUCTIONS_N, estimator, largest_difference, measured, random_network, random_shape};
use burn_tensor::{Device, Tensor, TensorData, activation};
use finray_model::sensing::Contact;
use finray_model::sensing::network::{ContactSet, Instructions, Network, NetworkError, NetworkEstimator};
use finray_model::{Finger, NodeId};
use finray_tests::{at_node, at_position, cases, paper};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// Largest difference from the forces of the `burn` library: 1e-5 of the largest training force of 5 N. `burn` adds numbers in another order and uses
/// another tanh.
const AGAINST_BURN_N: f64 = 5e-5;

/// Forces that the `burn` library computes from the inputs of the first layer, including the skip branch.
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

proptest! {
    #![proptest_config(cases(24))]

    /// For any widths of the layers, forces equal those of the `burn` library, even if a width does not fill a SIMD register. Tested with the
    /// instructions that the processor supports and with portable instructions, for single and many frames, and for any order of the contacts.
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
        for shape in &shapes {
            let expected_n = burn_forces(&network, inputs_of(&network, shape));
            let (mut one_n, mut portable_n, mut backwards_n) =
                (vec![0.0; contacts], vec![0.0; contacts], vec![0.0; contacts]);
            detected.forces(shape, &mut one_n).expect("a whole frame");
            portable.forces(shape, &mut portable_n).expect("a whole frame");
            backwards.forces(shape, &mut backwards_n).expect("a whole frame");
            backwards_n.reverse();
            prop_assert!(largest_difference(&one_n, &expected_n) <= AGAINST_BURN_N, "{one_n:?} against {expected_n:?}");
            for other in [&portable_n, &backwards_n] {
                prop_assert!(largest_difference(&one_n, other) <= BETWEEN_INSTRUCTIONS_N, "{one_n:?}, {other:?}");
            }
        }
    }

    /// The network serves any subset of twelve contacts. Forces at the loaded contacts are the sum of ridge forces and a correction, here computed by
    /// the `burn` library.
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
}

/// For the layer widths of the paper, forces equal those of the `burn` library.
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
fn what_is_not_a_number_gives_no_force() {
    let network = random_network(1, &[19, 20], ContactSet::Fixed, &[30, 20], 46);
    for instructions in [Instructions::Detected, Instructions::Portable] {
        let mut estimator = estimator(&network, &[19, 20], instructions);
        let mut shapes = [random_shape(&network, 1), random_shape(&network, 2)].concat();
        shapes[50] = f64::NAN;
        let mut forces_n = [0.0; 2];
        estimator.forces(&shapes[..46], &mut forces_n).expect("a frame");
        assert!(forces_n.iter().all(|force_n| force_n.is_finite()));
        estimator.forces(&shapes[46..], &mut forces_n).expect("a frame");
        assert!(forces_n.iter().all(|force_n| force_n.is_nan()));
        assert!(estimator.forces(&shapes, &mut forces_n).is_err());
    }
}

#[test]
fn other_fingers_contacts_and_markers_are_refused() {
    let network = random_network(1, &[19, 20], ContactSet::Fixed, &[3], 4);
    let all = measured(&network.card.markers, &network.inputs.mean);
    let new =
        |finger: &Finger, contacts: &[Contact]| NetworkEstimator::new(&network, finger, contacts, &all).map(|_| ());
    let stiffer = paper().with_modulus_factor(1.1).expect("a finger");
    assert!(matches!(new(&stiffer, &[at_node(19, 0.0), at_node(20, 0.0)]), Err(NetworkError::AnotherFinger { .. })));
    let tilted = Contact { angle_deg: 10.0, ..at_node(20, 0.0) };
    for contacts in [vec![at_node(19, 0.0)], vec![at_node(19, 0.0), at_node(21, 0.0)], vec![at_node(19, 0.0), tilted]] {
        let error = new(&paper(), &contacts).expect_err("other contacts");
        assert!(error.to_string().contains("exactly the contacts 19@0, 20@0"), "{error}");
    }
    // A contact given by the position of a node equals a contact given by the node's number.
    let position_mm = paper().front_position_mm(NodeId(19)).expect("on the front plate");
    assert_eq!(new(&paper(), &[at_position(position_mm, 0.0), at_node(20, 0.0)]), Ok(()));
    let any = random_network(1, &[18, 19, 20], ContactSet::AnyOf, &[3], 4);
    assert!(NetworkEstimator::new(&any, &paper(), &[at_node(20, 0.0)], &all).is_ok());
    let error = NetworkEstimator::new(&any, &paper(), &[at_node(14, 0.0)], &all).expect_err("not among them");
    assert!(error.to_string().contains("any of the contacts 18@0, 19@0, 20@0, not for 14@0"), "{error}");
}
