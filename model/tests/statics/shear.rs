//! Beams with shear deformation, compared with closed forms, and fingers of such beams on different meshes.

use finray_model::finger::FingerDescription;
use finray_model::frame::{FrameLoad, FrameMotion, PlaneFrame, Section};
use finray_model::statics::Statics;
use finray_model::validity::{SHEAR_CORRECTION, Validity};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{
    KINEMATICS, built_finger_with_zones, cases, contact_node, force_for_deflection, motions_apart, paper, shapes_apart,
};
use proptest::prelude::*;

/// Largest difference between the ladder solver and the general sparse solver, as a share of the largest displacement.
const AGREEMENT: f64 = 1e-8;
/// Rounding error of linear solutions, relative.
const ROUNDING: f64 = 1e-9;
const LENGTH_MM: f64 = 12.0;
const FORCE_N: f64 = 0.3;
const SECTION: Section =
    Section { axial_rigidity_n: 1500.0, bending_rigidity_nmm2: 400.0, shear_flexibility: 4.0, axis_mm: [0.0; 2] };
const SHEAR_RIGIDITY_N: f64 = SECTION.axial_rigidity_n / SECTION.shear_flexibility;

/// A beam along a slanted line, divided into equal elements and clamped at its first end. If `both` is true, the last node is also clamped.
fn beam(elements: usize, both: bool) -> (PlaneFrame, Vector) {
    let along = Vector::new(0.6, 0.8);
    let mut frame = PlaneFrame::default();
    let nodes: Vec<_> =
        (0..=elements).map(|i| frame.add_node(along * (LENGTH_MM * i as f64 / elements as f64))).collect();
    for pair in nodes.windows(2) {
        frame.add_beam(pair[0], pair[1], SECTION);
    }
    frame.support(nodes[0], [true; 3]);
    frame.support(nodes[elements], [both; 3]);
    (frame, Vector::new(-along.y, along.x))
}

fn linear(frame: &PlaneFrame, load: FrameLoad) -> FrameMotion {
    Statics::sparse(frame, Kinematics::Linear).equilibrium(&[load]).expect("an equilibrium").motion
}

/// Cantilever with a force F at its end: deflection F L^3 / (3 EI) + F L / (kappa G A), rotation F L^2 / (2 EI).
#[test]
fn a_cantilever_with_shear_has_its_closed_form() {
    let rigidity = SECTION.bending_rigidity_nmm2;
    let deflection = FORCE_N * LENGTH_MM.powi(3) / (3.0 * rigidity) + FORCE_N * LENGTH_MM / SHEAR_RIGIDITY_N;
    for elements in [1, 2, 7] {
        let (frame, across) = beam(elements, false);
        let motion = linear(&frame, FrameLoad::Node { node: elements, force: across * FORCE_N, moment_nmm: 0.0 });
        let found = motion.displacements[elements];
        assert!((found - across * deflection).norm() < ROUNDING * deflection, "{elements} elements: {found}");
        let rotation = motion.rotations[frame.rotation_of(elements)];
        assert!((rotation / (FORCE_N * LENGTH_MM.powi(2) / (2.0 * rigidity)) - 1.0).abs() < ROUNDING);
    }
}

/// Beam clamped at both ends with a force F at the middle. At the distance x from an end, up to the middle, the deflection is
/// F x^2 (3 L - 4 x) / (48 EI) + F x / (2 kappa G A). With an odd number of elements, the force acts between nodes.
#[test]
fn a_clamped_beam_with_shear_has_its_closed_form() {
    let deflection = |x: f64| {
        FORCE_N * x * x * (3.0 * LENGTH_MM - 4.0 * x) / (48.0 * SECTION.bending_rigidity_nmm2)
            + FORCE_N * x / (2.0 * SHEAR_RIGIDITY_N)
    };
    for elements in [2, 3, 6, 7] {
        let (frame, across) = beam(elements, true);
        let force = across * FORCE_N;
        let load = match elements % 2 {
            0 => FrameLoad::Node { node: elements / 2, force, moment_nmm: 0.0 },
            _ => FrameLoad::Interior { member: elements / 2, xi: 0.5, force },
        };
        let motion = linear(&frame, load);
        for node in 1..elements {
            let x = LENGTH_MM * node.min(elements - node) as f64 / elements as f64;
            let found = motion.displacements[node].dot(&across);
            assert!((found / deflection(x) - 1.0).abs() < ROUNDING, "{elements} elements, node {node}: {found}");
        }
    }
}

/// A force acts off the middle of a clamped beam. The nodal loads that replace a force between nodes differ from those of a slender beam. The finer
/// mesh has a node at the force.
#[test]
fn a_force_between_nodes_acts_as_on_a_finer_mesh() {
    let (coarse, across) = beam(2, true);
    let (fine, _) = beam(10, true);
    let force = across * FORCE_N;
    let between = linear(&coarse, FrameLoad::Interior { member: 0, xi: 0.4, force });
    let at_node = linear(&fine, FrameLoad::Node { node: 2, force, moment_nmm: 0.0 });
    let apart = between.displacements[1] - at_node.displacements[5];
    assert!(apart.norm() < ROUNDING * at_node.largest_displacement(), "{apart}");
}

fn with_shear(finger: &Finger) -> Finger {
    let description = finger.description().clone();
    Finger::new(FingerDescription {
        shear_correction: SHEAR_CORRECTION,
        rod_arm_mm: 1.0,
        rib_arm_mm: Some(1.4),
        clamp_arm_mm: Some(0.3),
        fillets: None,
        poissons_ratio: 0.45,
        side_faces: None,
        ..description
    })
    .expect("a finger")
}

/// Linear displacements and strains do not depend on the number of elements. One force acts between the clamp and the first node, where it causes the
/// largest strain.
#[test]
fn linear_fingers_with_shear_do_not_depend_on_the_mesh() {
    let finger = with_shear(&paper());
    let at_node = Load::at_node(contact_node(&finger, 0.4), finger.direction(30.0));
    let between = Load::at_position(4.5, finger.direction(-20.0));
    for loads in [[at_node, between], [between; 2]] {
        let solved = [1, 3, 8].map(|elements| {
            let mesh = Mesh::with_elements_per_member(&finger, elements);
            let loads = loads.map(|load| mesh.frame_load(&load).expect("on the finger"));
            let motion = Statics::ladder(&mesh, Kinematics::Linear).equilibrium(&loads).expect("carried").motion;
            let validity = Validity::of(&mesh, &motion, Kinematics::Linear, &loads);
            assert_eq!((validity.shear_share, validity.shear_at), (0.0, None), "no shear is neglected");
            (mesh.shape(&motion), validity.strains.iter().map(|strain| strain.strain).collect::<Vec<_>>())
        });
        let (reference, strains) = &solved[0];
        for (shape, fine_strains) in &solved[1..] {
            assert!(shapes_apart(shape, reference) < ROUNDING);
            for (a, b) in strains.iter().zip(fine_strains) {
                assert!((a / b - 1.0).abs() < ROUNDING, "{strains:?} {fine_strains:?}");
            }
        }
    }
}

/// Co-rotational displacements converge with the number of elements, and the ladder solver agrees with the general sparse solver.
#[test]
fn corotational_fingers_with_shear_converge() {
    let finger = with_shear(&paper());
    let load = Load::at_node(NodeId(19), finger.direction(20.0) * 3.0);
    let shapes = [2, 4, 8, 16].map(|elements| {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        let load = [mesh.frame_load(&load).expect("on the finger")];
        let ladder = Statics::ladder(&mesh, Kinematics::Corotational).equilibrium(&load).expect("carried");
        let sparse = Statics::sparse(mesh.frame(), Kinematics::Corotational).equilibrium(&load).expect("carried");
        assert!(motions_apart(&ladder.motion, &sparse.motion) < AGREEMENT);
        mesh.shape(&ladder.motion)
    });
    let apart = |i: usize| shapes_apart(&shapes[i], &shapes[3]);
    let [coarse, middle, fine] = [0, 1, 2].map(apart);
    assert!(fine < 1e-4 && middle < 0.4 * coarse && fine < 0.4 * middle, "{coarse} {middle} {fine}");
}

proptest! {
    #![proptest_config(cases(48))]

    /// On random fingers with shear deformation, the ladder solver, which condenses members, agrees with the general sparse solver. Loads act at and
    /// between nodes.
    #[test]
    fn the_ladder_agrees_with_the_sparse_path(
        finger in built_finger_with_zones(),
        shear_correction in 0.3..1.0,
        elements in 1..6_usize,
        at in [0.0..1.0, 0.05..1.0],
        angle in -80.0..80.0,
        share in 0.002..0.01,
    ) {
        let finger = Finger::new(FingerDescription { shear_correction, ..finger.description().clone() }).expect("a finger");
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        let node = contact_node(&finger, at[0]);
        let force = force_for_deflection(&finger, node, angle, share);
        let loads = [
            Load::at_node(node, force * 0.6),
            Load::at_position(at[1] * finger.description().front_length_mm, force * 0.3),
        ];
        let loads = loads.map(|load| mesh.frame_load(&load).expect("on the finger"));
        for kinematics in KINEMATICS {
            let ladder = Statics::ladder(&mesh, kinematics).equilibrium(&loads);
            let sparse = Statics::sparse(mesh.frame(), kinematics).equilibrium(&loads);
            let (Ok(ladder), Ok(sparse)) = (ladder, sparse) else { return Err(TestCaseError::reject("no equilibrium")) };
            let apart = motions_apart(&ladder.motion, &sparse.motion);
            prop_assert!(apart <= AGREEMENT, "{kinematics:?}: {apart}");
        }
    }
}
