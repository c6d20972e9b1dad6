//! Random load cases: repeatable on any number of threads, in the ranges that were asked for, and with the shapes that
//! the finger takes under them.

use finray_model::frame::FrameLoad;
use finray_model::measurement::{Marker, Measurement};
use finray_model::mesh::LoadError;
use finray_model::samples::{SampleRecipe, Samples, SamplesError, Stream};
use finray_model::sensing::{Contact, ContactPlace, LinearEstimator, Prior, SensingError};
use finray_model::statics::Statics;
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::paper;
use rand::Rng;
use std::collections::{HashMap, HashSet};

/// Random deviations allowed, in standard errors: among some hundred figures one beyond them is met once in a hundred runs.
const STANDARD_ERRORS: f64 = 4.0;
/// The ladder against the general sparse path, as a share of the largest displacement.
const BETWEEN_PATHS: f64 = 1e-8;
/// The same linear solution by other products.
const ROUNDING: f64 = 1e-9;
/// Largest chi-squares by degrees of freedom that are still chance: one of ten thousand draws exceeds them.
const CHI_SQUARE_6: f64 = 27.9;
const CHI_SQUARE_11: f64 = 37.4;

fn at_node(node: usize, angle_deg: f64) -> Contact {
    Contact { place: ContactPlace::Node(NodeId(node)), angle_deg }
}

/// Normal forces at some nodes of the linear finger.
fn linear(nodes: impl IntoIterator<Item = usize>) -> SampleRecipe {
    SampleRecipe::paper(nodes.into_iter().map(|node| at_node(node, 0.0)).collect(), Kinematics::Linear)
}

fn draw(recipe: &SampleRecipe, count: usize) -> Samples {
    recipe.draw(&paper(), count, 1, Stream::Test).expect("forces that the finger carries")
}

/// Checks the mean of some numbers and their standard deviation against those that they were drawn with.
fn assert_normal(numbers: &[f64], mean: f64, deviation: f64) {
    let count = numbers.len() as f64;
    let found = numbers.iter().sum::<f64>() / count;
    let scatter = (numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    assert!((found - mean).abs() <= STANDARD_ERRORS * deviation / count.sqrt(), "mean {found}, not {mean}");
    let relative = STANDARD_ERRORS / (2.0 * count).sqrt();
    assert!((scatter / deviation - 1.0).abs() <= relative, "standard deviation {scatter}, not {deviation}");
}

fn chi_square(counts: impl IntoIterator<Item = (usize, f64)>) -> f64 {
    counts.into_iter().map(|(found, expected)| (found as f64 - expected).powi(2) / expected).sum()
}

/// Everything that can be random at once; many of these forces are not carried, so that draws are repeated too.
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

/// No case of one seed and stream is met in another, and no purpose shares its random numbers with another.
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

/// Sec. IV-A of the paper: 0 to 5 N a node, 0 to 10 N in all.
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
        // Twelve forces exceed 10 N unless their mean is below a third of what is expected: all are scaled to 0..10 N.
        let (numbers, largest) = match contacts {
            1 | 2 => (samples.forces.row(0).iter().copied().collect(), 5.0),
            12 => (sums, 10.0),
            _ => continue,
        };
        assert_evenly_spread(&numbers, largest);
    }
}

/// Numbers spread evenly from zero have the mean 1/2 and the variance 1/12 of the range, and its square; the largest of
/// thousands comes within a hundredth.
fn assert_evenly_spread(numbers: &[f64], largest: f64) {
    let (mean, deviation) = (largest / 2.0, largest / f64::sqrt(12.0));
    assert_normal(numbers, mean, deviation);
    assert!(numbers.iter().any(|x| *x > 0.99 * largest) && numbers.iter().any(|x| *x < 0.01 * largest));
}

/// As many cases touch one contact as two, or all; each subset of a number is met as often as the others.
#[test]
fn every_number_of_contacts_touches_as_often() {
    let count = 3600;
    let samples = draw(&SampleRecipe { any_of: true, ..linear(13..=24) }, count);
    let mut by_number = [0; 13];
    for (touching, forces) in samples.touching.iter().zip(samples.forces.column_iter()) {
        by_number[touching.iter().filter(|touches| **touches).count()] += 1;
        for (touches, force_n) in touching.iter().zip(forces.iter()) {
            // A force that touches is zero once in 2^52.
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

/// Displacements of the free nodes by the sparse path, mm: ux, uy of each.
fn solved(finger: &Finger, recipe: &SampleRecipe, forces_n: &[f64]) -> Vec<f64> {
    let mesh = Mesh::with_elements_per_member(finger, recipe.elements);
    let load = |(contact, &force_n): (&Contact, &f64)| {
        let force = finger.direction(contact.angle_deg) * force_n;
        let load = match contact.place {
            ContactPlace::Node(node) => Load::at_node(node, force),
            ContactPlace::Place(s_mm) => Load::at_place(s_mm, force),
        };
        mesh.frame_load(&load).expect("on the front plate")
    };
    let loads: Vec<FrameLoad> = recipe.contacts.iter().zip(forces_n).map(load).collect();
    let found = Statics::sparse(mesh.frame(), recipe.kinematics).equilibrium(&loads).expect("carried");
    let shape = mesh.shape(&found.motion);
    finger.free_nodes().map(|node| shape.motion(node).displacement).flat_map(|u| [u.x, u.y]).collect()
}

fn assert_close(found: impl IntoIterator<Item = f64>, expected: &[f64], tolerance: f64, what: &str) {
    let found: Vec<f64> = found.into_iter().collect();
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * largest, "{what}: {a} against {b}");
    }
}

/// The shapes are those of the sparse path, which shares no elimination with the ladder.
#[test]
fn shapes_are_those_of_the_finger() {
    let finger = paper();
    let contacts =
        vec![at_node(16, -20.0), at_node(20, 15.0), Contact { place: ContactPlace::Place(101.3), angle_deg: 0.0 }];
    for kinematics in [Kinematics::Linear, Kinematics::Corotational, Kinematics::CorotationalChord] {
        for any_of in [false, true] {
            let recipe = SampleRecipe { any_of, ..SampleRecipe::paper(contacts.clone(), kinematics) };
            let samples = draw(&recipe, 6);
            assert_eq!(samples.markers, finger.free_nodes().collect::<Vec<_>>());
            for (forces, shape) in samples.forces.column_iter().zip(samples.displacements.column_iter()) {
                let expected = solved(&finger, &recipe, forces.as_slice());
                assert_close(shape.iter().copied(), &expected, BETWEEN_PATHS, &format!("{kinematics:?}"));
            }
        }
    }
}

/// A hidden marker leaves out its two rows and changes nothing else. What is hidden twice or clamped is hidden once.
#[test]
fn hidden_markers_leave_out_their_rows() {
    let finger = paper();
    let all = linear([16, 20]);
    let hidden = SampleRecipe { hidden: [19, 2, 24, 2, 25].map(NodeId).to_vec(), ..all.clone() };
    let (seen, kept) = (draw(&all, 20), draw(&hidden, 20));
    assert_eq!(seen.forces, kept.forces);
    let markers: Vec<NodeId> = finger.free_nodes().filter(|node| ![2, 19, 24].contains(&node.0)).collect();
    assert_eq!((&kept.markers, &hidden.markers(&finger)), (&markers, &markers));
    let places = markers.iter().map(|node| seen.markers.iter().position(|other| other == node).expect("seen before"));
    let rows: Vec<usize> = places.flat_map(|place| [2 * place, 2 * place + 1]).collect();
    assert_eq!(kept.displacements, seen.displacements.select_rows(&rows));
}

/// The same random numbers give the same forces on fingers whose moduli scatter. The linear finger shows each case's
/// factor; with large rotations the shape is that of a finger described with it.
#[test]
fn moduli_scatter_as_stated() {
    let finger = paper();
    let (spread, count) = (0.08, 2000);
    let stiff = SampleRecipe { contacts: vec![at_node(17, 10.0), at_node(20, 0.0)], ..linear([]) };
    let soft = SampleRecipe { modulus_spread: spread, ..stiff.clone() };
    let (stiff, scattered) = (draw(&stiff, count), draw(&soft, count));
    assert_eq!(stiff.forces, scattered.forces);
    let mut logarithms = Vec::new();
    for (one, other) in stiff.displacements.column_iter().zip(scattered.displacements.column_iter()) {
        let factor = one.norm() / other.norm();
        assert_close((other * factor).iter().copied(), one.as_slice(), ROUNDING, "one factor for all");
        logarithms.push(factor.ln());
    }
    assert_normal(&logarithms, 0.0, spread);

    let large = SampleRecipe { kinematics: Kinematics::Corotational, elements: 2, ..soft };
    let samples = draw(&large, 5);
    assert_eq!(samples.not_carried, 0);
    for (case, logarithm) in logarithms[..5].iter().enumerate() {
        let described = finger.with_modulus_factor(logarithm.exp()).expect("a possible finger");
        let expected = solved(&described, &large, samples.forces.column(case).as_slice());
        assert_close(samples.displacements.column(case).iter().copied(), &expected, BETWEEN_PATHS, "stiffer finger");
    }
}

/// Two components of each force, sensed on the linear finger, give back its size and its direction.
#[test]
fn directions_scatter_as_stated() {
    let finger = paper();
    let (spread_deg, count) = (7.0, 2000);
    let contacts = vec![at_node(16, -20.0), at_node(21, 12.0)];
    let samples =
        draw(&SampleRecipe { contacts: contacts.clone(), direction_spread_deg: spread_deg, ..linear([]) }, count);
    let components = [at_node(16, 0.0), at_node(16, 90.0), at_node(21, 0.0), at_node(21, 90.0)];
    let measured = |case: usize| {
        let shape = samples.displacements.column(case);
        let markers = samples.markers.iter().enumerate().map(|(k, &node)| Marker {
            node,
            displacement: Vector::new(shape[2 * k], shape[2 * k + 1]),
            weight: 1.0,
        });
        Measurement::new(&finger, markers).expect("free nodes")
    };
    let estimator = LinearEstimator::new(&finger, &components, &measured(0)).expect("well-posed");
    let mut deviations_deg = [Vec::new(), Vec::new()];
    for case in 0..count {
        let found = estimator.estimate(&measured(case), None, Prior::None).forces_n;
        for (i, contact) in contacts.iter().enumerate() {
            let (inwards_n, towards_tip_n) = (found[2 * i], found[2 * i + 1]);
            let force_n = samples.forces[(i, case)];
            let error_n = (inwards_n.hypot(towards_tip_n) - force_n).abs();
            assert!(error_n <= BETWEEN_PATHS * samples.forces.column(case).sum(), "{error_n}");
            deviations_deg[i].push(towards_tip_n.atan2(inwards_n).to_degrees() - contact.angle_deg);
        }
    }
    deviations_deg.iter().for_each(|deviations| assert_normal(deviations, 0.0, spread_deg));
    // Each force has a direction of its own.
    let products = deviations_deg[0].iter().zip(&deviations_deg[1]).map(|(a, b)| a * b);
    let correlation = products.sum::<f64>() / (count as f64 * spread_deg * spread_deg);
    assert!(correlation.abs() <= STANDARD_ERRORS / (count as f64).sqrt(), "{correlation}");
}

/// A finger that carries none of the forces ends the draw with a message.
#[test]
fn forces_beyond_the_finger_are_refused() {
    // A million times what it carries: the chance that one of a hundred draws is carried is 1e-4.
    let range_n = 1e7;
    let contacts = vec![at_node(19, 0.0)];
    let too_large = SampleRecipe {
        largest_force_n: range_n,
        largest_sum_n: range_n,
        ..SampleRecipe::paper(contacts, Kinematics::Corotational)
    };
    let refused = too_large.draw(&paper(), 2, 1, Stream::Training).expect_err("beyond the finger");
    assert_eq!(refused, SamplesError::NoneCarried { draws: 100 });
    assert!(refused.to_string().contains("none of 100 random load cases"), "{refused}");
}

#[test]
fn wrong_contacts_are_refused() {
    let finger = paper();
    let refused = |contacts: &[Contact]| {
        let recipe = SampleRecipe { contacts: contacts.to_vec(), ..linear([]) };
        match recipe.draw(&finger, 5, 1, Stream::Training) {
            Err(SamplesError::Contacts(error)) => error,
            other => panic!("{contacts:?}: {other:?}"),
        }
    };
    assert!(matches!(refused(&[]), SensingError::NoContact));
    assert!(matches!(refused(&[at_node(7, 0.0)]), SensingError::NotAContactNode { .. }));
    assert!(matches!(refused(&[at_node(25, 0.0)]), SensingError::Load(LoadError::NodeClamped { .. })));
    assert!(matches!(refused(&[at_node(26, 0.0)]), SensingError::Load(LoadError::NodeMissing { .. })));
    assert!(matches!(refused(&[at_node(19, f64::NAN)]), SensingError::AngleNotFinite { contact: 1 }));
    assert!(matches!(refused(&[at_node(19, 3.0), at_node(19, 3.0)]), SensingError::SameContact { .. }));
    let off_plate = Contact { place: ContactPlace::Place(200.0), angle_deg: 0.0 };
    assert!(matches!(refused(&[off_plate]), SensingError::Load(LoadError::PlaceOffPlate { .. })));
}

/// Ranges and spreads that are none.
#[test]
fn impossible_ranges_are_refused() {
    let finger = paper();
    let refused = |change: &dyn Fn(&mut SampleRecipe), wrong: &str| {
        let mut recipe = linear([19]);
        change(&mut recipe);
        match recipe.draw(&finger, 5, 1, Stream::Training) {
            Err(SamplesError::Recipe { key, .. }) => assert_eq!(key, wrong),
            other => panic!("{wrong}: {other:?}"),
        }
    };
    for force_n in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(&|recipe| recipe.largest_force_n = force_n, "largest_force_n");
        refused(&|recipe| recipe.largest_sum_n = force_n, "largest_sum_n");
    }
    for spread in [-1.0, f64::NAN, f64::INFINITY] {
        refused(&|recipe| recipe.direction_spread_deg = spread, "direction_spread_deg");
        refused(&|recipe| recipe.modulus_spread = spread, "modulus_spread");
    }
    refused(&|recipe| recipe.elements = 0, "elements");
}
