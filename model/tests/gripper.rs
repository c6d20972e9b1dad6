//! Compares the gripper's linkage with its equations, finite differences, its inverse and its mirror image.

use finray_model::camera::Pose;
use finray_model::gripper::{Assembly, Gripper, GripperDescription, LinkageErrors, LinkagePose};
use finray_model::{Finger, Scene, Vector};
use proptest::prelude::*;
use std::f64::consts::PI;

fn finger() -> Finger {
    Scene::from_toml(finray_fixtures::PAPER_SCENE).unwrap().finger
}

prop_compose! {
    /// Linkages that can be assembled at motor angle 0, in both assembly modes, with the nut above or below the fixed joint.
    fn linkages()(
        rocker in 5.0..80.0,
        link in 5.0..80.0,
        reach in 0.02..0.98,
        towards in 0.02..0.98,
        is_below in any::<bool>(),
        is_inner in any::<bool>(),
        screw_pitch_mm in 0.5..10.0,
    ) -> GripperDescription {
        let [rocker, link, reach, towards]: [f64; 4] = [rocker, link, reach, towards];
        let shortest = (rocker - link).abs();
        let apart = shortest + reach * (rocker + link - shortest);
        let (sin, cos) = (towards * PI / 2.0).sin_cos();
        GripperDescription {
            screw_pitch_mm,
            slider_mm: if is_below { -apart * sin } else { apart * sin },
            link_mm: [rocker, link],
            fixed_joint_mm: apart * cos,
            assembly: if is_inner { Assembly::Inner } else { Assembly::Outer },
        }
    }
}

/// An outer linkage with a screw of 4 mm pitch. Lengths are in mm.
fn linkage(slider_mm: f64, link_mm: [f64; 2], fixed_joint_mm: f64) -> GripperDescription {
    GripperDescription { screw_pitch_mm: 4.0, slider_mm, link_mm, fixed_joint_mm, assembly: Assembly::Outer }
}

/// Motor angle at a given share of the range of motor angles that the linkage can reach.
fn within(gripper: &Gripper, share: f64) -> f64 {
    let [from_deg, to_deg] = gripper.reach_deg();
    from_deg + share * (to_deg - from_deg)
}

/// Two positions of the joint between rocker and link: one computed from the rocker, one computed from the link.
fn joints(description: &GripperDescription, pose: &LinkagePose) -> [Vector; 2] {
    let [rocker, link] = description.link_mm;
    let nut = Vector::new(description.fixed_joint_mm, pose.slider_mm);
    [
        Vector::new(-pose.phi1_rad.cos(), pose.phi1_rad.sin()) * rocker,
        nut - Vector::new(pose.phi2_rad.cos(), pose.phi2_rad.sin()) * link,
    ]
}

proptest! {
    /// Poses satisfy eqs (6)-(9) to rounding.
    #[test]
    fn the_papers_equations_hold(description in linkages(), share in 0.001..0.999) {
        let gripper = Gripper::new(description).unwrap();
        let motor_deg = within(&gripper, share);
        let pose = gripper.pose(motor_deg).unwrap();
        let GripperDescription { screw_pitch_mm, slider_mm, link_mm: [rocker, link], fixed_joint_mm, .. } = description;
        let size = rocker + link;
        let (phi1, phi2) = (pose.phi1_rad, pose.phi2_rad);
        prop_assert!((pose.slider_mm - (slider_mm + motor_deg / 360.0 * screw_pitch_mm)).abs() <= 1e-12 * size);
        prop_assert!((link * phi2.cos() - rocker * phi1.cos() - fixed_joint_mm).abs() <= 1e-12 * size, "eq. (7)");
        prop_assert!((rocker * phi1.sin() + link * phi2.sin() - pose.slider_mm).abs() <= 1e-12 * size, "eq. (8)");
        for joint in joints(&description, &pose) {
            prop_assert!((joint - pose.base).norm() <= 1e-12 * size, "eq. (9)");
        }
    }

    /// The joint between rocker and link is farther from the screw's axis in the outer assembly than in the inner assembly. At every motor angle, the
    /// joint between rocker and link stays on the same side of the line from fixed joint to nut.
    #[test]
    fn the_assembly_is_kept(description in linkages(), share in 0.001..0.999) {
        let [outer, inner] = [Assembly::Outer, Assembly::Inner]
            .map(|assembly| Gripper::new(GripperDescription { assembly, ..description }).unwrap());
        let at_zero = |gripper: &Gripper| gripper.pose(0.0).unwrap();
        prop_assert!(at_zero(&outer).base.x < at_zero(&inner).base.x);
        for gripper in [outer, inner] {
            let side = |pose: LinkagePose| Vector::new(description.fixed_joint_mm, pose.slider_mm).perp(&pose.base).signum();
            prop_assert_eq!(side(gripper.pose(within(&gripper, share)).unwrap()), side(at_zero(&gripper)));
        }
    }

    /// The derivative of the opening equals central differences. The differences over two step sizes, 1e-5 of the reach and half of it, are combined
    /// so that errors of second order cancel (Richardson). The ends of the reach are excluded, because the opening has infinite curvature there.
    #[test]
    fn the_opening_has_the_derivative_of_differences(description in linkages(), share in 0.05..0.95) {
        let (gripper, finger) = (Gripper::new(description).unwrap(), finger());
        let motor_deg = within(&gripper, share);
        let [from_deg, to_deg] = gripper.reach_deg();
        let step_deg = 1e-5 * (to_deg - from_deg);
        let opening = |motor_deg: f64| gripper.opening_mm(&finger, &gripper.pose(motor_deg).unwrap());
        let over = |step_deg: f64| (opening(motor_deg + step_deg) - opening(motor_deg - step_deg)) / (2.0 * step_deg) * 360.0;
        let differences = (4.0 * over(0.5 * step_deg) - over(step_deg)) / 3.0;
        let derivative = gripper.opening_per_turn_mm(&finger, &gripper.pose(motor_deg).unwrap()).unwrap();
        // Rounding changes an opening of some 100 mm by a relative 1e-14; dividing by the step of 1e-5 of the reach magnifies this change.
        let rounding = 3e-12 / step_deg * 360.0;
        prop_assert!((differences - derivative).abs() <= 1e-6 * derivative.abs() + 1e-7 * description.screw_pitch_mm + rounding,
            "{differences} and {derivative}");
    }

    /// The motor angle found for an opening gives this opening. It is no farther from 0 than the motor angle from which the opening was computed.
    #[test]
    fn an_opening_leads_back_to_its_motor_angle(description in linkages(), share in 0.001..0.999) {
        let (gripper, finger) = (Gripper::new(description).unwrap(), finger());
        let motor_deg = within(&gripper, share);
        let opening = |motor_deg: f64| gripper.opening_mm(&finger, &gripper.pose(motor_deg).unwrap());
        let back_deg = gripper.motor_deg_for_opening(&finger, opening(motor_deg)).unwrap();
        prop_assert!((opening(back_deg) - opening(motor_deg)).abs() <= 1e-9 * (1.0 + opening(motor_deg).abs()));
        // Near the largest opening, the opening determines the motor angle only to the square root of the rounding error.
        prop_assert!(back_deg.abs() <= motor_deg.abs() * (1.0 + 1e-6) + 1e-3);
    }

    /// A linkage with the nut below the fixed joint is the mirror image of a linkage with the nut above it.
    #[test]
    fn below_is_the_mirror_image_of_above(description in linkages(), share in 0.001..0.999) {
        let slider_mm = -description.slider_mm;
        let [gripper, mirrored] =
            [description, GripperDescription { slider_mm, ..description }].map(|description| Gripper::new(description).unwrap());
        let motor_deg = within(&gripper, share);
        let [pose, image] = [gripper.pose(motor_deg), mirrored.pose(-motor_deg)].map(Option::unwrap);
        let size = description.link_mm[0] + description.link_mm[1];
        prop_assert!((pose.base.x - image.base.x).abs() <= 1e-12 * size && (pose.base.y + image.base.y).abs() <= 1e-12 * size);
        prop_assert!((pose.phi2_rad + image.phi2_rad).sin().abs() <= 1e-12 * size);
    }

    /// If the links do not let the nut pass the height of the fixed joint, no pose has the nut on the other side of this height.
    #[test]
    fn the_nut_stays_on_its_side_where_the_links_do_not_let_it_pass(description in linkages(), share in 0.001..0.999) {
        let gripper = Gripper::new(description).unwrap();
        let [rocker, link] = description.link_mm;
        let passes = (rocker - link).abs() < description.fixed_joint_mm;
        let there_mm = gripper.slider_mm(within(&gripper, share));
        let other_side_deg = (-there_mm - description.slider_mm) / description.screw_pitch_mm * 360.0;
        prop_assert_eq!(gripper.pose(other_side_deg).is_some(), passes);
    }

    /// Beyond the end of the reach there is no pose. At the end of the reach, rocker and link are collinear.
    #[test]
    fn the_reach_ends_where_the_links_lie_on_one_line(description in linkages()) {
        let gripper = Gripper::new(description).unwrap();
        let [from_deg, to_deg] = gripper.reach_deg();
        let beyond_deg = 1e-9 * (to_deg - from_deg);
        prop_assert!(gripper.pose(from_deg - beyond_deg).is_none() && gripper.pose(to_deg + beyond_deg).is_none());
        for share in [1e-9, 1.0 - 1e-9] {
            let pose = gripper.pose(within(&gripper, share)).unwrap();
            // The sine of the angle between rocker and link is the square root of the relative distance from the end of the reach, times ratios of
            // lengths up to 300.
            prop_assert!((pose.phi1_rad + pose.phi2_rad).sin().abs() <= 1e-2);
        }
    }
}

/// A rocker of 3 mm and a link of 4 mm at a right angle span a distance of 5 mm.
#[test]
fn a_right_triangle_has_the_angles_of_the_textbook() {
    let description = linkage(0.0, [3.0, 4.0], 5.0);
    let gripper = Gripper::new(description).unwrap();
    let pose = gripper.pose(0.0).unwrap();
    assert!((pose.base - Vector::new(1.8, 2.4)).norm() < 1e-14);
    assert!((pose.phi1_rad - 2.4_f64.atan2(-1.8)).abs() < 1e-14);
    assert!((pose.phi2_rad - (-2.4_f64).atan2(3.2)).abs() < 1e-14);
    // One turn lifts the nut by the pitch of 4 mm. Links of 3 mm and 4 mm do not reach the nut after 1.25 turns.
    assert!((gripper.slider_mm(360.0) - 4.0).abs() < 1e-14);
    assert!(gripper.pose(360.0 * 1.25).is_none());
    let end = gripper.pose(gripper.reach_deg()[1] * (1.0 - 1e-15)).unwrap();
    assert!(end.is_singular() && gripper.opening_per_turn_mm(&finger(), &end).is_none());
}

/// If the link is level, the finger is upright. The tip of an upright finger is above the middle of its base, and the distance of the base from the
/// screw's axis is the link's length.
#[test]
fn an_upright_finger_opens_by_twice_its_distance_from_the_axis() {
    let description = linkage(25.0, [25.0, 40.0], 40.0);
    let (gripper, finger) = (Gripper::new(description).unwrap(), finger());
    let pose = gripper.pose(0.0).unwrap();
    let tip = finger.position(finger.tip());
    assert!(pose.phi2_rad.abs() < 1e-14 && pose.base.x.abs() < 1e-14);
    assert!((pose.in_mechanism(tip) - Vector::new(tip.y, 25.0 + tip.x)).norm() < 1e-12);
    assert!((gripper.opening_mm(&finger, &pose) - 2.0 * (40.0 - tip.y)).abs() < 1e-12);
    // The front plate is on the side of the screw's axis.
    let [_, front_base] = finger.clamped_nodes();
    assert!(pose.in_mechanism(finger.position(front_base)).x > 0.0);
    // A higher nut leans the finger back, so the gripper opens.
    assert!(gripper.opening_per_turn_mm(&finger, &pose).unwrap() > 0.0);
}

#[test]
fn a_linkage_that_does_not_close_is_refused() {
    let description = linkage(20.0, [5.0, 10.0], 30.0);
    let impossible = Gripper::new(description).unwrap_err();
    assert_eq!((impossible.shortest_mm, impossible.longest_mm), (5.0, 15.0));
    assert!((impossible.apart_mm - 1300.0_f64.sqrt()).abs() < 1e-12);
}

/// The computed errors of the nodes equal the displacements of the nodes in linkages with a wrong motor angle or a wrong length. If the finger
/// rotates, the tip has the largest error.
#[test]
fn nodes_err_as_those_of_a_linkage_that_is_off() {
    let description = linkage(20.0, [25.0, 40.0], 30.0);
    const OFF: f64 = 1e-4;
    let (gripper, finger, motor_deg) = (Gripper::new(description).unwrap(), finger(), -300.0);
    let errors = LinkageErrors { motor_deg: 360.0 * OFF, backlash_mm: OFF * 12.0_f64.sqrt(), length_mm: OFF };
    let found = gripper.node_errors(&finger, motor_deg, &errors).unwrap();
    let nodes = |gripper: &Gripper, motor_deg: f64| -> Vec<Vector> {
        let [left, _] = gripper.fingers(&gripper.pose(motor_deg).unwrap());
        (1..=finger.key_node_count()).map(|node| left.outwards(finger.position(finray_model::NodeId(node)))).collect()
    };
    let there = nodes(&gripper, motor_deg);
    let off = |gripper: &Gripper, motor_deg: f64| {
        let moved = nodes(gripper, motor_deg).into_iter().zip(&there).map(|(now, then)| (now - then).norm());
        moved.fold(0.0, f64::max)
    };
    let with = |change: &dyn Fn(&mut GripperDescription)| {
        let mut changed = description;
        change(&mut changed);
        off(&Gripper::new(changed).unwrap(), motor_deg)
    };
    let pairs = [
        (found.motor_mm, off(&gripper, motor_deg + 360.0 * OFF)),
        (found.backlash_mm, off(&gripper, motor_deg + 360.0 * OFF / 4.0)),
        (found.rocker_mm, with(&|description| description.link_mm[0] += OFF)),
        (found.link_mm, with(&|description| description.link_mm[1] += OFF)),
        (found.fixed_joint_mm, with(&|description| description.fixed_joint_mm += OFF)),
    ];
    // The relative error of one-sided differences is their step divided by the lengths of the linkage.
    for (found, direct) in pairs {
        assert!((found / direct - 1.0).abs() < 1e-4, "{found} and {direct}");
    }
    // A change of the opening moves the tip of each finger across by half of this change.
    let per_turn = gripper.opening_per_turn_mm(&finger, &gripper.pose(motor_deg).unwrap()).unwrap();
    assert!(found.motor_mm >= 0.5 * per_turn.abs() * OFF * (1.0 - 1e-6));
}

/// Checks eqs (9) and (10) of the paper for a finger on the gripper in front of the gripper's camera. A point given in the finger's frame has the
/// same pixel as this point given in the gripper's frame. A point above the plane in the frame of a mirrored finger is below the plane in the
/// gripper's frame.
#[test]
fn a_finger_on_the_gripper_is_seen_by_its_camera() {
    let gripper = Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE).unwrap().gripper.unwrap();
    let camera = Pose::new([2.9, 0.2, -0.1], [3.0, 95.0, 200.0]);
    for finger in gripper.fingers(&gripper.pose(-300.0).unwrap()) {
        let before = camera.of_placed_finger(&finger);
        for (point, up_mm) in
            [(Vector::new(0.0, 0.0), 0.0), (Vector::new(12.0, -3.0), 2.0), (Vector::new(-4.0, 150.0), -1.5)]
        {
            let sign = if finger.mirrored { -1.0 } else { 1.0 };
            let there = camera.to_camera(&finger.outwards(point).push(sign * up_mm));
            assert!((before.to_camera(&point.push(up_mm)) - there).norm() < 1e-12 * there.norm());
        }
        assert!((before.rotation.matrix().determinant() - 1.0).abs() < 1e-12);
    }
}
