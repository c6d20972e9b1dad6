//! The solution is invariant under position and rotation of the scene, units, and order of nodes.

use finray_model::finger::{FingerDescription, Joints, Part, Plate, RibPositions};
use finray_model::frame::{BeamEnd, FrameLoad, FrameMotion, PlaneFrame};
use finray_model::statics::{Statics, solve, solve_frame};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{KINEMATICS, built_finger_with_zones, cases, contact_node, finger, force_for_deflection, largest};
use nalgebra::Rotation2;
use proptest::prelude::*;

/// Rounding error between two solutions of the same finger, as a share of the largest displacement.
const ROUNDING: f64 = 1e-8;

/// The finger's frame without arms and zones, built by hand from its key nodes. The frame is rotated by an angle, and its nodes are added in another
/// order. Returns the frame, and the indices of the frame's nodes for each key node and for the joints of each rib.
fn built_by_hand(finger: &Finger, turn: Rotation2<f64>, order: &[usize]) -> (PlaneFrame, Vec<usize>, Vec<[usize; 2]>) {
    let mut frame = PlaneFrame::default();
    let count = finger.key_node_count();
    let mut index = vec![0; count + 1];
    let mut sequence: Vec<usize> = (1..=count).collect();
    sequence.sort_by_key(|node| order[node % order.len()].wrapping_mul(node * 7919) % 1009);
    for node in sequence {
        index[node] = frame.add_node(turn * finger.position(NodeId(node)));
    }
    for node in finger.clamped_nodes() {
        frame.support(index[node.0], [true; 3]);
    }
    let description = finger.description();
    let hinged = description.ribs.joints == Joints::Hinged;
    // Joints of the ribs, front and back, are separate nodes that are linked to the key nodes.
    let joints: Vec<[usize; 2]> = (0..finger.rib_count())
        .map(|rib| finger.rib_nodes(rib).map(|node| frame.add_node(turn * finger.hinge(node))))
        .collect();
    for (rib, &[front_joint, back_joint]) in joints.iter().enumerate() {
        let [front, back] = finger.rib_nodes(rib).map(|node| index[node.0]);
        frame.link_rigidly(front, front_joint, false);
        if description.ribs.strip.is_none() {
            // In this frame, the front node of each rigid rib is the master; in the mesh, the back node is the master.
            frame.link_rigidly(front_joint, back_joint, hinged);
            frame.link_rigidly(back_joint, back, false);
        } else {
            frame.link_rigidly(back, back_joint, false);
        }
    }
    for plate in [Plate::Front, Plate::Back] {
        let section = finger.section(Part::from(plate)).expect("plates have a section");
        for pair in finger.plate_nodes(plate).windows(2) {
            frame.add_beam(index[pair[1].0], index[pair[0].0], section);
        }
    }
    if let Some(section) = finger.section(Part::Ribs) {
        for rib in (0..finger.rib_count()).rev() {
            let ends = joints[rib].map(|joint| {
                let end = frame.clamped_end(joint);
                if hinged { BeamEnd { rotation: frame.add_rotation(), ..end } } else { end }
            });
            frame.add_member(ends, section);
        }
    }
    (frame, index, joints)
}

fn without_arms(finger: &Finger) -> Finger {
    let mut description =
        FingerDescription { rod_arm_mm: 0.0, rigid_ends: Default::default(), ..finger.description().clone() };
    (description.rib_arm_mm, description.clamp_arm_mm) = (None, None);
    description.ribs.clip_mm = [0.0; 2];
    description.zones.clear();
    Finger::new(description).expect("still possible")
}

proptest! {
    #![proptest_config(cases(96))]

    /// If the whole scene is rotated, the displacements rotate with it. The order of nodes and beams has no effect.
    #[test]
    fn turn_of_the_scene_and_order_of_nodes(
        finger in built_finger_with_zones(),
        at in 0.0..1.0,
        angle in -80.0..80.0,
        turn in -3.1..3.1,
        order in prop::collection::vec(1_usize..1000, 8),
    ) {
        let finger = without_arms(&finger);
        let turn = Rotation2::new(turn);
        let node = contact_node(&finger, at);
        let force = force_for_deflection(&finger, node, angle, 0.02);
        let mesh = Mesh::key_nodes(&finger);
        let (frame, index, joints) = built_by_hand(&finger, turn, &order);
        for kinematics in KINEMATICS {
            let straight = solve(&mesh, &[Load::at_node(node, force)], kinematics);
            let load = FrameLoad::Node { node: index[node.0], force: turn * force, moment_nmm: 0.0 };
            let turned = solve_frame(&frame, &[load], kinematics);
            prop_assert_eq!(straight.is_ok(), turned.is_ok(), "{:?} {:?} {:?} node {}", kinematics, straight.err(), turned.err(), node);
            let (Ok(straight), Ok(turned)) = (straight, turned) else {
                return Err(TestCaseError::reject("no equilibrium"));
            };
            for motion in straight.motions() {
                let there: Vector = turned.displacements[index[motion.node.0]];
                let expected: Vector = turn * motion.displacement;
                prop_assert!((there - expected).norm() <= ROUNDING * straight.largest_displacement_mm());
                let rotation = turned.rotations[frame.rotation_of(index[motion.node.0])];
                prop_assert!((rotation - motion.rotation).abs() <= ROUNDING);
            }
            for (rib, ends) in joints.iter().enumerate() {
                for (joint, node) in ends.iter().zip(finger.rib_nodes(rib)) {
                    let there: Vector = turned.displacements[*joint];
                    let expected: Vector = turn * straight.motion(node).hinge_displacement;
                    prop_assert!((there - expected).norm() <= ROUNDING * straight.largest_displacement_mm());
                }
            }
        }
    }

    /// With other units of length and force, the shape is the same in these units.
    #[test]
    fn units(finger in built_finger_with_zones(), at in 0.0..1.0, angle in -80.0..80.0, length in -3.0..3.0, force in -6.0..6.0) {
        let (length, force_unit) = (10_f64.powf(length), 10_f64.powf(force));
        let node = contact_node(&finger, at);
        let force = force_for_deflection(&finger, node, angle, 0.02);
        let scaled = scaled(finger.description(), length, force_unit);
        for kinematics in KINEMATICS {
            let ours = solve(&Mesh::key_nodes(&finger), &[Load::at_node(node, force)], kinematics);
            let theirs = solve(&Mesh::key_nodes(&scaled), &[Load::at_node(node, force * force_unit)], kinematics);
            prop_assert_eq!(ours.is_ok(), theirs.is_ok());
            let (Ok(ours), Ok(theirs)) = (ours, theirs) else { return Err(TestCaseError::reject("no equilibrium")) };
            for (a, b) in ours.motions().iter().zip(theirs.motions()) {
                let difference = (a.displacement - b.displacement / length).norm();
                prop_assert!(difference <= ROUNDING * ours.largest_displacement_mm());
                prop_assert!((a.rotation - b.rotation).abs() <= ROUNDING);
            }
        }
    }

    /// A rigid motion of the whole frame causes no strain, for rotations from 1e-9 rad to more than a full turn.
    #[test]
    fn rigid_rotation_costs_nothing(finger in finger(), exponent in -9.0..0.9, negative in any::<bool>(), shift in [-5.0..5.0, -5.0..5.0]) {
        let turn = 10_f64.powf(exponent) * if negative { -1.0 } else { 1.0 };
        let mesh = Mesh::with_elements_per_member(&finger, 2);
        let frame = mesh.frame();
        let mut motion = FrameMotion::at_rest(frame);
        let half = (0.5 * turn).sin();
        for (node, u) in motion.displacements.iter_mut().enumerate() {
            let p = frame.position(node);
            *u = Vector::new(-p.y, p.x) * turn.sin() - p * (2.0 * half * half) + Vector::new(shift[0], shift[1]);
        }
        motion.rotations.fill(turn);
        for kinematics in [Kinematics::Corotational, Kinematics::CorotationalChord] {
            let statics = Statics::sparse(frame, kinematics);
            let mut assembly = statics.equations().assembly().clone();
            assembly.evaluate(&motion, &[], 0.0);
            // The residual is compared with the forces that the same rotation would cause as a deformation.
            let stiffest = largest(assembly.stiffness().data());
            let residual = largest(assembly.residual());
            let size = finger.description().front_length_mm;
            prop_assert!(residual <= 1e-13 * stiffest * size.max(1.0), "{kinematics:?}: {residual}");
        }
    }
}

fn scaled(d: &FingerDescription, length: f64, force: f64) -> Finger {
    let mut d = d.clone();
    for size in
        [&mut d.base_width_mm, &mut d.front_length_mm, &mut d.back_length_mm, &mut d.depth_mm, &mut d.rod_arm_mm]
    {
        *size *= length;
    }
    for arm_mm in [&mut d.rib_arm_mm, &mut d.clamp_arm_mm].into_iter().flatten() {
        *arm_mm *= length;
    }
    let strips = [Some(&mut d.front), Some(&mut d.back), d.ribs.strip.as_mut()];
    for strip in strips.into_iter().flatten() {
        strip.thickness_mm *= length;
        strip.youngs_modulus_mpa *= force / (length * length);
    }
    d.ribs.bracket_mm.all_mut().as_flattened_mut().iter_mut().for_each(|bracket| *bracket *= length);
    d.ribs.clip_mm = d.ribs.clip_mm.map(|clip| clip * length);
    for ends in &mut d.rigid_ends {
        ends.base_mm *= length;
        ends.tip_mm *= length;
    }
    if let RibPositions::Positions(positions) = &mut d.ribs.positions {
        positions.iter_mut().flatten().for_each(|position| *position *= length);
    }
    for zone in &mut d.zones {
        zone.from_mm *= length;
        zone.to_mm *= length;
    }
    Finger::new(d).expect("a scaled finger is possible")
}
