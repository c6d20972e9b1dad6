//! The ladder solver, which eliminates blocks along the ladder of plates and ribs, compared with the general sparse solver.

use finray_model::frame::FrameLoad;
use finray_model::statics::Statics;
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{
    KINEMATICS, built_finger_with_zones, cases, contact_node, force_for_deflection, motions_apart, paper,
};
use proptest::prelude::*;

/// Relative error of a linear prediction, as a multiple of the relative change of the loads. Slender fingers near buckling respond most nonlinearly.
const SECOND_ORDER: f64 = 100.0;
/// Largest difference of a displacement, as a share of the largest displacement, for meshes of up to about 684 nodes.
const AGREEMENT: f64 = 1e-8;

proptest! {
    #![proptest_config(cases(192))]

    /// Tested on any finger and mesh, with hinges, rigid links, arms and zones. Loads are a force and a moment on a key node, a force at a position
    /// along the plate, and a force and a moment on a node inside a member.
    #[test]
    fn agrees_with_the_sparse_path(
        finger in built_finger_with_zones(),
        elements in prop_oneof![4 => 1..6_usize, 1 => 20..30_usize],
        at in [0.0..1.0, 0.05..1.0],
        angle in -80.0..80.0,
        share in 0.002..0.02,
        moment in -20.0..20.0,
    ) {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        let node = contact_node(&finger, at[0]);
        let force = force_for_deflection(&finger, node, angle, share);
        // A small part of the load acts on a node that refinement adds inside a plate or rib.
        let inside = FrameLoad::Node { node: mesh.frame().node_count() - 1, force: force * 0.1, moment_nmm: 0.1 * moment };
        let loads: Vec<FrameLoad> = [
            Load::Node { node, force: force * 0.6, moment_nmm: moment * force.norm() },
            Load::at_position(at[1] * finger.description().front_length_mm, force * 0.3),
        ]
        .iter()
        .map(|load| mesh.frame_load(load).expect("on the finger"))
        .chain((elements > 1).then_some(inside))
        .collect();
        for kinematics in KINEMATICS {
            let ladder = Statics::ladder(&mesh, kinematics).equilibrium(&loads);
            let sparse = Statics::sparse(mesh.frame(), kinematics).equilibrium(&loads);
            prop_assert_eq!(ladder.is_ok(), sparse.is_ok(), "{:?} {:?}", ladder.err(), sparse.err());
            let (Ok(ladder), Ok(sparse)) = (ladder, sparse) else { return Err(TestCaseError::reject("no equilibrium")) };
            let apart = motions_apart(&ladder.motion, &sparse.motion);
            prop_assert!(apart <= AGREEMENT, "{kinematics:?}: {apart}");
            let largest = sparse.motion.largest_displacement();
            for (a, b) in ladder.motion.rotations.iter().zip(&sparse.motion.rotations) {
                prop_assert!((a - b).abs() <= AGREEMENT * largest.max(1.0));
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(96))]

    /// A correction after a change of the loads leads to the equilibrium under the changed loads: for the linear finger with any change, and for the
    /// co-rotational finger with a small change, up to terms of second order. The markers move as predicted. Loads act on nodes and inside elements.
    #[test]
    fn changed_loads_need_no_new_tangent(
        finger in built_finger_with_zones(),
        elements in 1..6_usize,
        at in [0.0..1.0, 0.05..1.0, 0.05..1.0],
        angle in -80.0..80.0,
        share in 0.002..0.02,
        moment in -20.0..20.0,
    ) {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        let node = contact_node(&finger, at[0]);
        let force = force_for_deflection(&finger, node, angle, share);
        let front_mm = finger.description().front_length_mm;
        let loads = |at_node: f64, s_mm: f64, along: f64| -> Vec<FrameLoad> {
            let on_node = Load::Node { node, force: force * at_node, moment_nmm: moment * at_node * force.norm() };
            let inside = Load::at_position(s_mm, force * along);
            [on_node, inside].iter().map(|load| mesh.frame_load(load).expect("on the finger")).collect()
        };
        let change = 1e-4;
        let before = loads(0.6, at[1] * front_mm, 0.3);
        let cases = [
            (Kinematics::Linear, loads(-0.2, at[2] * front_mm, 0.5), AGREEMENT),
            (Kinematics::Corotational, loads(0.6 + change, (at[1] * (1.0 - change)).max(0.05) * front_mm, 0.3 - change), SECOND_ORDER * change),
        ];
        for (kinematics, after, tolerance) in cases {
            let mut statics = Statics::ladder(&mesh, kinematics);
            let [start, expected] = [&before, &after].map(|loads| statics.equilibrium(loads));
            let (Ok(start), Ok(expected)) = (start, expected) else { return Err(TestCaseError::reject("no equilibrium")) };
            let mut motion = start.motion.clone();
            prop_assert!(statics.linearise(&motion, &before));
            statics.corrected_under(&mut motion, &before, &after).expect("a finite correction");
            let moved_mm = motions_apart(&start.motion, &expected.motion) * expected.motion.largest_displacement();
            let apart_mm = motions_apart(&motion, &expected.motion) * expected.motion.largest_displacement();
            let rounding_mm = AGREEMENT * expected.motion.largest_displacement();
            prop_assert!(apart_mm <= tolerance * moved_mm + rounding_mm, "{kinematics:?}: {apart_mm} of {moved_mm} mm");
            let mut predicted = vec![Vector::zeros(); finger.key_node_count()];
            statics.equations().corrected_markers(&start.motion, &mut predicted);
            for key_node in 1..=finger.key_node_count() {
                let marker = mesh.marker_node(NodeId(key_node));
                let marker_moved = motion.displacements[marker] - start.motion.displacements[marker];
                let apart_mm = (predicted[key_node - 1] - marker_moved).norm();
                prop_assert!(apart_mm <= tolerance * moved_mm + rounding_mm, "{kinematics:?}, marker {key_node}: {apart_mm} of {moved_mm} mm");
            }
        }
    }
}

/// Tested on the two meshes that the paper uses for its finger, for every contact node.
#[test]
fn agrees_on_the_papers_meshes() {
    let finger = paper();
    for nodes in [25, 684] {
        let mesh = Mesh::with_nodes(&finger, nodes).expect("the paper's meshes");
        let mut iterations = [0, 0];
        for node in finger.contact_nodes() {
            let load = mesh.frame_load(&Load::at_node(node, finger.direction(-20.0) * 2.0)).expect("a contact node");
            for kinematics in KINEMATICS {
                let ladder = Statics::ladder(&mesh, kinematics).equilibrium(&[load]).expect("2 N are carried");
                let sparse = Statics::sparse(mesh.frame(), kinematics).equilibrium(&[load]).expect("2 N are carried");
                let apart = motions_apart(&ladder.motion, &sparse.motion);
                assert!(apart <= AGREEMENT, "{nodes} nodes, load at {node}, {kinematics:?}: {apart}");
                if kinematics != Kinematics::Linear {
                    iterations[0] += ladder.iterations;
                    iterations[1] += sparse.iterations;
                }
            }
        }
        // The ladder solver's tangent contains extrapolated forces, which save iterations; the sparse solver's is exact.
        assert!(10 * iterations[0] <= 9 * iterations[1], "{nodes} nodes: {iterations:?}");
    }
}
