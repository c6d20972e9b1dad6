//! Random forces and contacts of training samples.

use super::{assert_normal, draw, linear};
use finray_model::{Kinematics, NodeId};
use finray_tests::{at_node, paper};
use finray_train::samples::{SampleRecipe, Stream};
use rand::Rng;
use std::collections::{HashMap, HashSet};

/// Limits of chi-square for 6 and 11 degrees of freedom. By chance, one of ten thousand draws exceeds each limit.
const CHI_SQUARE_6: f64 = 27.9;
const CHI_SQUARE_11: f64 = 37.4;

fn chi_square(counts: impl IntoIterator<Item = (usize, f64)>) -> f64 {
    counts.into_iter().map(|(found, expected)| (found as f64 - expected).powi(2) / expected).sum()
}

/// A recipe in which all quantities are random. The finger has no equilibrium under many of these forces, so some draws are repeated.
fn all_spread() -> SampleRecipe {
    SampleRecipe {
        any_of: true,
        elements: 1,
        largest_force_n: 40.0,
        largest_sum_n: 60.0,
        direction_spread_deg: 10.0,
        modulus_spread: 0.05,
        hidden: vec![NodeId(5), NodeId(19)],
        ..SampleRecipe::paper([14, 19, 22].map(|node| at_node(node, 5.0)).to_vec(), Kinematics::Corotational)
    }
}

#[test]
fn any_number_of_threads_draws_the_same() {
    let (recipe, finger) = (all_spread(), paper());
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| recipe.draw(&finger, 60, 7, Stream::Training).expect("some are carried"))
    };
    let one = on(1);
    assert!(one.not_carried > 0, "no draw was repeated");
    assert!(one == on(2) && one == on(3));
}

#[test]
fn the_first_of_a_longer_draw_are_the_same() {
    let (few, many) = (draw(&all_spread(), 15), draw(&all_spread(), 40));
    assert_eq!(few.forces, many.forces.columns(0, 15));
    assert_eq!(few.displacements, many.displacements.columns(0, 15));
    assert_eq!(few.touching, many.touching[..15]);
    assert_eq!((few.count(), few.markers), (15, many.markers));
}

/// No case occurs with two different seeds or streams, and no two purposes share random numbers.
#[test]
fn seeds_and_streams_share_nothing() {
    let (recipe, finger) = (linear([19, 20]), paper());
    let mut forces = HashSet::new();
    for seed in [0, 1, 2, u64::MAX] {
        for stream in [Stream::Training, Stream::Validation, Stream::Test] {
            let samples = recipe.draw(&finger, 50, seed, stream).expect("carried");
            for case in samples.forces.column_iter() {
                assert!(forces.insert([case[0].to_bits(), case[1].to_bits()]), "seed {seed}, {stream:?}");
            }
        }
    }
    let cases = [Stream::Training, Stream::Validation, Stream::Test];
    let noise = [Stream::TrainingNoise, Stream::ValidationNoise, Stream::TestNoise];
    let mut numbers = HashSet::new();
    for stream in cases.into_iter().chain(noise).chain([Stream::Weights]) {
        for index in [0, 1, 2, 1000, (1 << 60) - 1] {
            assert!(numbers.insert(stream.rng(3, index).next_u64()), "{stream:?}, part {index}");
        }
    }
}

/// Ranges of sec. IV-A of the paper: 0 to 5 N per node, 0 to 10 N in total.
#[test]
fn forces_are_in_the_papers_range() {
    let count = 3000;
    for nodes in [19..=19, 19..=20, 18..=20, 13..=24] {
        let contacts = nodes.clone().count();
        let samples = draw(&linear(nodes), count);
        assert_eq!((samples.forces.shape(), samples.not_carried), ((contacts, count), 0));
        assert!(samples.forces.iter().all(|force_n| (0.0..5.0).contains(force_n)));
        assert!(samples.touching.iter().all(|touching| *touching == vec![true; contacts]));
        let sums: Vec<f64> = samples.forces.column_iter().map(|case| case.sum()).collect();
        assert!(sums.iter().all(|sum_n| *sum_n < 10.0));
        // The sum of twelve forces exceeds 10 N unless their mean is below a third of its expected value. In practice, all cases of twelve forces are
        // therefore scaled, so that their sum lies in 0..10 N.
        let (numbers, largest) = match contacts {
            1 | 2 => (samples.forces.row(0).iter().copied().collect(), 5.0),
            12 => (sums, 10.0),
            _ => continue,
        };
        assert_evenly_spread(&numbers, largest);
    }
}

/// Checks for a uniform distribution from zero to `largest`: the mean is half of the range, and the variance is 1/12 of the squared range. The
/// extremes of thousands of numbers lie within a hundredth of the limits.
fn assert_evenly_spread(numbers: &[f64], largest: f64) {
    let (mean, deviation) = (largest / 2.0, largest / f64::sqrt(12.0));
    assert_normal(numbers, mean, deviation);
    assert!(numbers.iter().any(|x| *x > 0.99 * largest) && numbers.iter().any(|x| *x < 0.01 * largest));
}

/// All numbers of loaded contacts are equally frequent, and all subsets with the same number of contacts are equally frequent.
#[test]
fn every_number_of_contacts_touches_as_often() {
    let count = 3600;
    let samples = draw(&SampleRecipe { any_of: true, ..linear(13..=24) }, count);
    let mut by_number = [0; 13];
    for (touching, forces) in samples.touching.iter().zip(samples.forces.column_iter()) {
        by_number[touching.iter().filter(|touches| **touches).count()] += 1;
        for (touches, force_n) in touching.iter().zip(forces.iter()) {
            // A drawn force is zero with a probability of 2^-52.
            assert_eq!(*touches, *force_n > 0.0, "{force_n}");
        }
        assert!(forces.sum() < 10.0);
    }
    assert_eq!(by_number[0], 0);
    let uneven = chi_square(by_number[1..].iter().map(|&found| (found, count as f64 / 12.0)));
    assert!(uneven < CHI_SQUARE_11, "{uneven}: {by_number:?}");

    let samples = draw(&SampleRecipe { any_of: true, ..linear([16, 18, 20]) }, count);
    let mut by_subset: HashMap<&[bool], usize> = HashMap::new();
    samples.touching.iter().for_each(|touching| *by_subset.entry(touching).or_default() += 1);
    assert_eq!(by_subset.len(), 7);
    let expected = |subset: &[bool]| match subset.iter().filter(|touches| **touches).count() {
        3 => count as f64 / 3.0,
        _ => count as f64 / 9.0,
    };
    let uneven = chi_square(by_subset.iter().map(|(subset, &found)| (found, expected(subset))));
    assert!(uneven < CHI_SQUARE_6, "{uneven}: {by_subset:?}");
}
