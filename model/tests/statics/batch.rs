//! Equilibria of many loads in a batch equal those of single loads bit for bit, including refusals.

use super::fine_meshes::hard_fingers;
use finray_model::finger::Plate;
use finray_model::frame::FrameLoad;
use finray_model::statics::{Equilibrium, Statics, StaticsError, equilibria};
use finray_model::{Finger, Kinematics, Load, Mesh, Vector};
use finray_tests::{KINEMATICS, built_finger_with_zones, cases, contact_node, force_for_deflection, paper};
use proptest::prelude::*;

fn one_by_one<L: AsRef<[FrameLoad]>>(
    mesh: &Mesh,
    kinematics: Kinematics,
    loads: &[L],
) -> Vec<Result<Equilibrium, StaticsError>> {
    let mut statics = Statics::ladder(mesh, kinematics);
    loads.iter().map(|loads| statics.equilibrium(loads.as_ref())).collect()
}

/// Up to three loads: at a node with a moment, at a position, and on a node that refinement adds. `kinds` is their number.
fn load(mesh: &Mesh, at: [f64; 2], force: Vector, kinds: usize) -> Vec<FrameLoad> {
    let finger = mesh.finger();
    let node = contact_node(finger, at[0]);
    let on_node = Load::Node { node, force: force * 0.6, moment_nmm: 3.0 * force.norm() };
    let at_position = Load::at_position(at[1] * finger.plate_length_mm(Plate::Front), force * 0.4);
    let inside = FrameLoad::Node { node: mesh.frame().node_count() - 1, force: force * 0.1, moment_nmm: force.norm() };
    let is_refined = mesh.frame().node_count() > finger.key_node_count();
    let on_finger = [on_node, at_position].map(|load| mesh.frame_load(&load).expect("on the finger"));
    on_finger.into_iter().chain(is_refined.then_some(inside)).take(kinds).collect()
}

/// Checks that all results are equal. Prints the first pair that differs.
fn assert_same(batch: &[Result<Equilibrium, StaticsError>], single: &[Result<Equilibrium, StaticsError>]) {
    assert_eq!(batch.len(), single.len());
    for (index, (batch, single)) in batch.iter().zip(single).enumerate() {
        assert_eq!(batch, single, "load {index}");
    }
}

proptest! {
    #![proptest_config(cases(96))]

    /// Tested on any finger and mesh, with hinges, rigid links, arms, zones and loads of all kinds. The largest loads are refused.
    #[test]
    fn random_fingers_and_loads_agree(
        finger in built_finger_with_zones(),
        elements in prop_oneof![2 => Just(1_usize), 2 => 2..6_usize],
        drawn in prop::collection::vec(([0.0..1.0, 0.05..1.0], -80.0..80.0, -3.0..0.5, 0..4_usize), 0..11),
    ) {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        let of = |(at, angle, power, kinds): ([f64; 2], f64, f64, usize)| {
            let force = force_for_deflection(&finger, contact_node(&finger, at[0]), angle, 10_f64.powf(power));
            load(&mesh, at, force, kinds)
        };
        let loads: Vec<Vec<FrameLoad>> = drawn.into_iter().map(of).collect();
        for kinematics in KINEMATICS {
            assert_same(&equilibria(&mesh, kinematics, &loads), &one_by_one(&mesh, kinematics, &loads));
        }
    }
}

/// Normal forces at one node of the paper's finger, N: small forces, one force that needs several load steps, and refused forces.
fn forces(finger: &Finger, mesh: &Mesh, forces_n: &[f64]) -> Vec<[FrameLoad; 1]> {
    let node = contact_node(finger, 0.5);
    let load = |force_n: &f64| mesh.frame_load(&Load::at_node(node, finger.direction(0.0) * *force_n));
    forces_n.iter().map(|force_n| [load(force_n).expect("a contact node")]).collect()
}

#[test]
fn a_result_does_not_depend_on_the_batch() {
    let finger = paper();
    for mesh in [Mesh::key_nodes(&finger), Mesh::with_elements_per_member(&finger, 4)] {
        let forces_n = [0.5, 400.0, 3.0, 6.0, 7.0, 0.0, 1e6, 8.0, f64::NAN, 9.0, 10.0, -40.0, 11.0];
        let loads = forces(&finger, &mesh, &forces_n);
        let single = one_by_one(&mesh, Kinematics::Corotational, &loads);
        let steps: Vec<usize> = single.iter().flatten().map(|found| found.load_steps).collect();
        let refused = single.iter().filter(|found| matches!(found, Err(StaticsError::NoEquilibrium { .. }))).count();
        assert!(
            steps.contains(&1) && steps.iter().any(|steps| *steps > 1) && refused > 0,
            "{steps:?}, {refused} refused"
        );
        assert_eq!(single[8], Err(StaticsError::LoadNotFinite));
        // Tests batches with every number of loads, and a batch with the loads in reverse order.
        for count in 0..=loads.len() {
            assert_same(&equilibria(&mesh, Kinematics::Corotational, &loads[..count]), &single[..count]);
        }
        let reversed: Vec<_> = loads.iter().rev().collect();
        let mut batch = equilibria(&mesh, Kinematics::Corotational, &reversed);
        batch.reverse();
        assert_same(&batch, &single);
    }
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    // The batch has more loads than one thread solves at a time.
    let forces_n: Vec<f64> = (0..1000).map(|i| 0.05 * f64::from(i)).collect();
    let loads = forces(&finger, &mesh, &forces_n);
    let single = one_by_one(&mesh, Kinematics::Corotational, &loads);
    for threads in 1..=3 {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        assert_same(&pool.install(|| equilibria(&mesh, Kinematics::Corotational, &loads)), &single);
    }
}

/// A load that is refused at the first load step is refused for the same reason in the batch and alone. In this test, the mesh is so fine that its
/// tangent has no correct digits.
#[test]
fn a_mesh_that_is_too_fine_is_refused_alike() {
    let (finger, force_n) = hard_fingers().swap_remove(2);
    let mesh = Mesh::with_nodes(&finger, 15_000).expect("a mesh size");
    let loads = forces(&finger, &mesh, &[force_n, 2.0 * force_n]);
    let single = one_by_one(&mesh, Kinematics::Corotational, &loads);
    let for_rounding =
        |found: &Result<_, _>| matches!(found, Err(StaticsError::TooFewDigits { .. } | StaticsError::NotHeld));
    assert!(single.iter().any(for_rounding), "{:?}", single.iter().map(Result::is_ok).collect::<Vec<_>>());
    assert_same(&equilibria(&mesh, Kinematics::Corotational, &loads), &single);
}
