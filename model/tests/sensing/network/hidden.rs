//! Networks with hidden markers, where the visible markers still identify the forces.

use super::{BETWEEN_INSTRUCTIONS_N, estimator, largest_difference, measured, random_network, random_shape};
use finray_model::NodeId;
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::network::{ContactSet, Instructions, NetworkError, NetworkEstimator, Scaling, TestError};
use finray_tests::{CAMERA_NOISE_MM, at_nodes, paper};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// If the visible markers determine the few principal directions, the estimator fills in the hidden markers. Sigmas grow with the number of hidden
/// markers.
#[test]
fn hidden_markers_are_filled_in() {
    let network = random_network(5, &[17, 20], ContactSet::Fixed, &[20], 10);
    let contacts = at_nodes(&[17, 20]);
    let shape = random_shape(&network, 6);
    let all = measured(&network.card.markers, &shape);
    let full = estimator(&network, &[17, 20], Instructions::Detected)
        .estimate(&all, Some(CAMERA_NOISE_MM))
        .expect("all markers");
    let mut wider = full.sigmas_n.clone();
    for hidden in [3_usize, 8, 12] {
        let seen = all.clone().without(&network.card.markers[..hidden]);
        let mut estimator = NetworkEstimator::new(&network, &paper(), &contacts, &seen).expect("some markers");
        let estimate = estimator.estimate(&seen, Some(CAMERA_NOISE_MM)).expect("some markers");
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
    // The estimator expects the markers in the order of the measurement for which it was built.
    let reversed: Vec<Marker> = all.markers().iter().rev().copied().collect();
    let reversed = Measurement::new(&paper(), reversed).expect("markers");
    let mut estimator = NetworkEstimator::new(&network, &paper(), &contacts, &reversed).expect("all markers");
    let estimate = estimator.estimate(&reversed, Some(CAMERA_NOISE_MM)).expect("all markers");
    assert!(largest_difference(&estimate.forces_n, &full.forces_n) <= BETWEEN_INSTRUCTIONS_N);
    assert_eq!(estimator.estimate(&all, None), Err(NetworkError::OtherMarkers));

    let mut coordinates = network;
    coordinates.card.scaling = Scaling::Spread;
    let refused = NetworkEstimator::new(&coordinates, &paper(), &contacts, &all.without(&[NodeId(5)])).map(|_| ());
    assert_eq!(refused, Err(NetworkError::HiddenMarkers { expected: 23, found: 22 }));
}

/// With fewer measured coordinates than principal directions, forces are uncertain, and sigmas state the uncertainty. Shapes are drawn from the
/// distribution that the network assumes. The errors of a linear network then scatter as its sigmas state.
#[test]
fn sigmas_tell_what_hidden_markers_leave_open() {
    const DRAWS: usize = 1000;
    /// Four standard errors, 4 / sqrt(2000), of the root mean square of 1000 errors, each divided by its standard deviation.
    const SCATTER: f64 = 0.09;
    let mut network = random_network(5, &[17, 20], ContactSet::Fixed, &[], 10);
    network.card.test_errors = vec![TestError { rms_n: 0.0, clean_rms_n: 0.0 }; 2];
    network.inputs.largest = vec![10.0; 10];
    let contacts = at_nodes(&[17, 20]);
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
