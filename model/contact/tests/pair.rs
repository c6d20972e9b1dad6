//! Tests of a contact: derivatives against finite differences, and balance of forces and moments.

use finray_contact::carrier::{Carrier, Mount};
use finray_contact::pair::{Meeting, Pair, PairPose, UNKNOWNS};
use finray_model::Vector;
use finray_model::element::Beam;
use finray_model::gripper::Placement;
use proptest::prelude::*;

prop_compose! {
    fn vectors(size: f64)(x in -1.0..1.0, y in -1.0..1.0) -> Vector {
        Vector::new(x, y) * size
    }
}

/// Positions of the two nodes of a carrier, mm.
const NODES: [Vector; 2] = [Vector::new(70.0, 12.0), Vector::new(80.0, 10.0)];

fn mount(i: usize) -> Mount {
    Mount { node: i, rotation: i, position: NODES[i], clamped: false }
}

prop_compose! {
    /// The axis of an element between arms, or a line fixed to the first node.
    fn carriers()(is_beam in any::<bool>(), arm in vectors(1.0), other in vectors(1.0), along in vectors(3.0), sway_factor in 0.5..1.0)
        -> Carrier {
        let between = NODES[1] + other - NODES[0] - arm;
        let (direction, length_mm) = (between.normalize(), between.norm());
        let beam = Beam { direction, length_mm, axial_rigidity_n: 1.0, bending_rigidity_nmm2: 1.0, sway_factor, axis_mm: [0.0; 2] };
        match is_beam {
            true => Carrier::Beam { mounts: [mount(0), mount(1)], arms: [arm, other], beam },
            false => Carrier::Rigid { mount: Some(mount(0)), from: arm, along: along + Vector::new(5.0, 0.0) },
        }
    }
}

prop_compose! {
    /// A pair, and the poses of finger and object at two instants. A corner lies above its foot on a piece.
    fn meetings()(
        carrier in carriers(),
        kind in 0..3_usize,
        xi in 0.0..1.0,
        corner in vectors(12.0),
        angle in 0.0..std::f64::consts::TAU,
        radius_mm in 0.5..2.0,
        disc_mm in 0.0..20.0,
        is_left in any::<bool>(),
        poses in (poses(), poses()),
    ) -> (Pair, PairPose, PairPose) {
        let (sin, cos): (f64, f64) = f64::sin_cos(angle);
        let (outward, side) = (Vector::new(cos, sin), if is_left { 1.0 } else { -1.0 });
        let (mut now, before) = poses;
        let meeting = match kind {
            0 => Meeting::BallAndCorner { corner },
            1 => Meeting::BallAndSide { on_side: corner, outward },
            _ => Meeting::PieceAndCorner { corner: Vector::zeros() },
        };
        // On the concave side of a bent element, the centre of a large disc would be farthest from its foot instead of nearest.
        let disc_mm = disc_mm * [1.0, 0.0, 0.05][kind];
        let pair = Pair { carrier, xi, radius_mm, disc_mm, side, meeting };
        if kind == 2 {
            let [foot, outward] = pair.foot(&now);
            let at = foot + outward * (radius_mm + disc_mm);
            (now.object[0], now.object[1]) = (at.x, at.y);
        }
        (pair, now, before)
    }
}

prop_compose! {
    fn poses()(
        origin in vectors(30.0),
        angle_rad in -3.0..3.0,
        mirrored in any::<bool>(),
        first in vectors(10.0),
        second in vectors(1.0),
        turns in (-0.5..0.5, -0.2..0.2),
        at in vectors(40.0),
        turn in -3.0..3.0,
    ) -> PairPose {
        PairPose {
            finger: Placement { origin, angle_rad, mirrored },
            nodes: [first.x, first.y, turns.0, first.x + second.x, first.y + second.y, turns.0 + turns.1],
            object: [at.x + 60.0, at.y, turn],
        }
    }
}

/// The poses of finger and object after a change of one unknown.
fn moved(pose: &PairPose, unknown: usize, by: f64) -> PairPose {
    let mut pose = *pose;
    *(if unknown < 6 { &mut pose.nodes[unknown] } else { &mut pose.object[unknown - 6] }) += by;
    pose
}

proptest! {
    /// Derivatives agree with central differences. The error of the differences is the square of the step relative to the lengths in the contact,
    /// plus rounding.
    #[test]
    fn derivatives_are_those_of_differences((pair, now, before) in meetings()) {
        const STEP: f64 = 1e-5;
        const TOLERANCE: f64 = 1e-5;
        let at = pair.tangent(&now, &before);
        for unknown in 0..UNKNOWNS {
            let poses = [-STEP, STEP].map(|by| moved(&now, unknown, by));
            let slope = |of: &dyn Fn(&PairPose) -> f64| (of(&poses[1]) - of(&poses[0])) / (2.0 * STEP);
            let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * (1.0 + a.abs().max(b.abs()));
            let touching = |pose: &PairPose| pair.touching(pose, &before);
            prop_assert!(near(slope(&|pose| touching(pose).gap_mm), at.pull[0][unknown]), "the gap's are the pull along the normal");
            prop_assert!(near(slope(&|pose| touching(pose).slip_mm), at.slip_by[unknown]), "slip");
            for axis in 0..2 {
                for i in 0..UNKNOWNS {
                    let pull = slope(&|pose| pair.tangent(pose, &before).pull[axis][i]);
                    prop_assert!(near(pull, at.pull_by[unknown][axis][i]), "pull {axis} {i}: {pull}");
                }
            }
        }
    }

    /// Action and reaction: the forces on finger and object are opposite, along and across the normal, and their moments about the origin cancel.
    #[test]
    fn forces_on_finger_and_object_are_opposite((pair, now, _) in meetings()) {
        let at = pair.touching(&now, &now);
        let across = Vector::new(-at.normal.y, at.normal.x);
        for (pull, direction) in pair.tangent(&now, &now).pull.iter().zip([at.normal, across]) {
            let on_nodes = [0, 3].map(|i| now.finger.axes() * Vector::new(pull[i], pull[i + 1]));
            let on_object = Vector::new(pull[6], pull[7]);
            prop_assert!((on_nodes[0] + on_nodes[1] - direction).norm() < 1e-12 && (on_object + direction).norm() < 1e-12);
            let sense = if now.finger.mirrored { -1.0 } else { 1.0 };
            let of_node = |i: usize| {
                let node = now.finger.outwards(NODES[i] + Vector::new(now.nodes[3 * i], now.nodes[3 * i + 1]));
                node.perp(&on_nodes[i]) + sense * pull[3 * i + 2]
            };
            let about_origin =
                of_node(0) + of_node(1) + Vector::new(now.object[0], now.object[1]).perp(&on_object) + pull[8];
            prop_assert!(about_origin.abs() < 1e-8, "{about_origin}");
        }
        prop_assert!(at.slip_mm.abs() < 1e-9, "nothing moved");
    }
}
