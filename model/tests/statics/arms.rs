//! Arms of rods, of ribs and at the clamp, compared with clips and rigid ends, which other programs have checked; an elastic axis beside the line of a
//! beam, compared with arms.

use finray_model::finger::{FingerDescription, RigidEnds};
use finray_model::frame::{BeamEnd, FrameLoad, PlaneFrame, Section};
use finray_model::statics::{solve, solve_frame};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{KINEMATICS, paper, shapes_apart};

const ARM_MM: f64 = 1.5;
const CLAMP_ARM_MM: f64 = 4.0;

/// The paper's finger with rods' arms, ribs' arms, arms at the clamp, and clips and rigid ends of `plate_mm`.
fn finger_with(arms_mm: (f64, Option<f64>, Option<f64>), plate_mm: f64, base_mm: f64) -> Finger {
    let mut description = paper().description().clone();
    (description.rod_arm_mm, description.rib_arm_mm, description.clamp_arm_mm) = arms_mm;
    description.ribs.clip_mm = [2.0 * plate_mm; 2];
    let rigid_ends = [RigidEnds { base_mm, tip_mm: plate_mm }; 2];
    Finger::new(FingerDescription { rigid_ends, ..description }).expect("a finger")
}

/// Both fingers have the same equilibria under forces on a node, on an arm between nodes, on the tip's arm and on the arm at the clamp.
fn assert_alike(one: &Finger, other: &Finger) {
    let force = one.direction(20.0) * 0.4;
    let along_mm = [1.0, 3.0, 76.5 + 0.7 * ARM_MM, 153.0 - 0.5 * ARM_MM];
    let loads =
        along_mm.map(|s_mm| Load::at_position(s_mm, force)).into_iter().chain([Load::at_node(NodeId(18), force)]);
    for (load, kinematics) in loads.flat_map(|load| KINEMATICS.map(|kinematics| (load, kinematics))) {
        let [one, other] = [one, other].map(|finger| {
            solve(&Mesh::with_elements_per_member(finger, 2), &[load], kinematics).expect("an equilibrium")
        });
        let apart = shapes_apart(&one, &other);
        assert!(apart == 0.0 || apart.is_nan() && one.largest_displacement_mm() == 0.0, "{load:?}: {apart}");
    }
}

#[test]
fn arms_at_the_clamp_are_rigid_ends_of_plates() {
    assert_alike(
        &finger_with((ARM_MM, None, Some(CLAMP_ARM_MM)), 0.0, 0.0),
        &finger_with((ARM_MM, None, None), 0.0, CLAMP_ARM_MM),
    );
}

/// The arm at the clamp may be shorter than the other arms, which rigid ends cannot state.
#[test]
fn arms_of_ribs_and_plates_are_separate() {
    let plates = finger_with((ARM_MM, Some(0.0), Some(0.0)), 0.0, 0.0);
    assert_alike(&plates, &finger_with((0.0, None, None), ARM_MM, 0.0));
    let ribs = finger_with((0.0, Some(ARM_MM), None), ARM_MM, ARM_MM);
    assert_alike(&ribs, &finger_with((ARM_MM, None, None), 0.0, 0.0));
}

/// Scenes without the two keys keep every bit.
#[test]
fn arms_of_ribs_and_at_the_clamp_are_rod_arms_by_default() {
    assert_alike(
        &finger_with((ARM_MM, Some(ARM_MM), Some(ARM_MM)), 0.0, 0.0),
        &finger_with((ARM_MM, None, None), 0.0, 0.0),
    );
}

/// A cantilever of 10 mm with the elastic axis beside its line, or on transverse arms: displacement and rotation of the free end.
fn cantilever(axis_mm: [f64; 2], arms_mm: [f64; 2], kinematics: Kinematics) -> [f64; 3] {
    let mut frame = PlaneFrame::default();
    let nodes = [0.0, 10.0].map(|x_mm| frame.add_node(Vector::new(x_mm, 0.0)));
    frame.support(nodes[0], [true; 3]);
    let ends = [0, 1].map(|i: usize| BeamEnd { arm: Vector::new(0.0, arms_mm[i]), ..frame.clamped_end(nodes[i]) });
    frame.add_member(ends, Section { axis_mm, shear_flexibility: 4.0, ..Section::rectangle(1.5, 20.0, 48.0) });
    let load = FrameLoad::Node { node: nodes[1], force: Vector::new(0.8, 0.03), moment_nmm: 0.05 };
    let motion = solve_frame(&frame, &[load], kinematics).expect("a cantilever");
    let moved = motion.displacements[nodes[1]];
    [moved.x, moved.y, motion.rotations[frame.rotation_of(nodes[1])]]
}

/// An elastic axis beside the line between the ends is a beam on transverse arms. Rotations are small here: arms swing, the axis does not.
#[test]
fn an_axis_beside_the_line_is_a_beam_on_transverse_arms() {
    let (offsets_mm, none) = ([3e-3, -1e-3], [0.0; 2]);
    for kinematics in KINEMATICS {
        let [plain, axis, arms] = [(none, none), (offsets_mm, none), (none, offsets_mm)]
            .map(|(axis, arms)| cantilever(axis, arms, kinematics));
        for i in 0..3 {
            let [change, expected] = [axis[i] - plain[i], arms[i] - plain[i]];
            assert!((change - expected).abs() < 0.01 * expected.abs(), "{kinematics:?}, {i}: {change}, {expected}");
        }
    }
}
