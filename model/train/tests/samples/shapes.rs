//! Displacements of random load cases.

use super::{assert_normal, draw, linear};
use finray_model::frame::FrameLoad;
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::{Contact, ContactPosition, ForcePrior, LinearEstimator};
use finray_model::statics::Statics;
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{STANDARD_ERRORS, at_node, at_position, largest, paper};
use finray_train::samples::SampleRecipe;

/// Tolerance between ladder solver and sparse solver, as a share of the largest displacement.
const BETWEEN_PATHS: f64 = 1e-8;
/// Tolerance between two computations of the same linear solution that multiply in different orders.
const ROUNDING: f64 = 1e-9;

/// Displacements of the free nodes by the sparse solver, mm: ux and uy of each node.
fn solved(finger: &Finger, recipe: &SampleRecipe, forces_n: &[f64]) -> Vec<f64> {
    let mesh = Mesh::with_elements_per_member(finger, recipe.elements);
    let load = |(contact, &force_n): (&Contact, &f64)| {
        let force = finger.direction(contact.angle_deg) * force_n;
        let load = match contact.position {
            ContactPosition::Node(node) => Load::at_node(node, force),
            ContactPosition::At(s_mm) => Load::at_position(s_mm, force),
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
    let scale = largest(expected);
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * scale, "{what}: {a} against {b}");
    }
}

/// The shapes agree with the sparse solver, whose elimination is independent of the ladder solver.
#[test]
fn shapes_are_those_of_the_finger() {
    let finger = paper();
    let contacts = vec![at_node(16, -20.0), at_node(20, 15.0), at_position(101.3, 0.0)];
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

/// Hiding a marker removes its two rows and changes nothing else. A marker that appears twice in the list of hidden markers counts once; a clamped
/// marker does not count.
#[test]
fn hidden_markers_leave_out_their_rows() {
    let finger = paper();
    let all = linear([16, 20]);
    let hidden = SampleRecipe { hidden: [19, 2, 24, 2, 25].map(NodeId).to_vec(), ..all.clone() };
    let (seen, kept) = (draw(&all, 20), draw(&hidden, 20));
    assert_eq!(seen.forces, kept.forces);
    let markers: Vec<NodeId> = finger.free_nodes().filter(|node| ![2, 19, 24].contains(&node.0)).collect();
    assert_eq!((&kept.markers, &hidden.markers(&finger)), (&markers, &markers));
    let positions =
        markers.iter().map(|node| seen.markers.iter().position(|other| other == node).expect("seen before"));
    let rows: Vec<usize> = positions.flat_map(|position| [2 * position, 2 * position + 1]).collect();
    assert_eq!(kept.displacements, seen.displacements.select_rows(&rows));
}

/// Scatter of the moduli does not change the random forces. On the linear finger, the modulus factor of each case follows from its displacements. On
/// the co-rotational finger, the shape of each case equals the shape of a finger whose modulus is scaled by the factor of the case.
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

/// Sensing two components of each force on the linear finger recovers the force's magnitude and direction.
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
        let found = estimator.estimate(&measured(case), None, ForcePrior::None).forces_n;
        for (i, contact) in contacts.iter().enumerate() {
            let (inwards_n, towards_tip_n) = (found[2 * i], found[2 * i + 1]);
            let force_n = samples.forces[(i, case)];
            let error_n = (inwards_n.hypot(towards_tip_n) - force_n).abs();
            assert!(error_n <= BETWEEN_PATHS * samples.forces.column(case).sum(), "{error_n}");
            deviations_deg[i].push(towards_tip_n.atan2(inwards_n).to_degrees() - contact.angle_deg);
        }
    }
    deviations_deg.iter().for_each(|deviations| assert_normal(deviations, 0.0, spread_deg));
    // The directions of the two forces are independent.
    let products = deviations_deg[0].iter().zip(&deviations_deg[1]).map(|(a, b)| a * b);
    let correlation = products.sum::<f64>() / (count as f64 * spread_deg * spread_deg);
    assert!(correlation.abs() <= STANDARD_ERRORS / (count as f64).sqrt(), "{correlation}");
}
