//! Tests of a contact: derivatives against finite differences, and balance of forces and moments.

use finray_lattice::energy::BodyMotion;
use finray_lattice::grasp::contact::{Pair, PairPose, Unknowns};
use finray_model::Vector;
use finray_model::gripper::Placement;
use proptest::prelude::*;

prop_compose! {
    fn vectors(size: f64)(x in -1.0..1.0, y in -1.0..1.0) -> Vector {
        Vector::new(x, y) * size
    }
}

fn pairs() -> impl Strategy<Value = Pair> {
    (0..3, vectors(3.0), vectors(12.0), 0.0..std::f64::consts::TAU, 0.5..2.0, 0.0..20.0).prop_map(
        |(kind, centre, corner, angle, ball_mm, disc_mm)| {
            let (sin, cos): (f64, f64) = f64::sin_cos(angle);
            let outward = Vector::new(cos, sin);
            match kind {
                0 => Pair::BallAndCorner { centre, corner, radii_mm: [ball_mm, disc_mm] },
                1 => Pair::BallAndSide { centre, on_side: corner, outward, radius_mm: ball_mm },
                _ => Pair::PieceAndCorner { on_piece: centre, outward, corner, radii_mm: [ball_mm, disc_mm] },
            }
        },
    )
}

prop_compose! {
    fn stands()(
        origin in vectors(30.0),
        angle_rad in -3.0..3.0,
        mirrored in any::<bool>(),
        displacement in vectors(10.0),
        rotation in -0.5..0.5,
        at in vectors(40.0),
        turn in -3.0..3.0,
    ) -> PairPose {
        PairPose {
            finger: Placement { origin, angle_rad, mirrored },
            body: BodyMotion { displacement, rotation },
            object: [at.x + 60.0, at.y, turn],
        }
    }
}

const REST: Vector = Vector::new(70.0, 12.0);

/// The poses of finger and object after a change of one unknown.
fn moved(stand: &PairPose, unknown: usize, by: f64) -> PairPose {
    let mut stand = *stand;
    match unknown {
        0 => stand.body.displacement.x += by,
        1 => stand.body.displacement.y += by,
        2 => stand.body.rotation += by,
        i => stand.object[i - 3] += by,
    }
    stand
}

proptest! {
    /// Derivatives agree with central differences. The error of the differences is the square of the step relative to the lengths in the contact,
    /// plus rounding.
    #[test]
    fn derivatives_are_those_of_differences(pair in pairs(), now in stands(), before in stands()) {
        const STEP: f64 = 1e-5;
        const TOLERANCE: f64 = 1e-5;
        let at = pair.tangent(REST, &now, &before);
        for unknown in 0..6 {
            let stands = [-STEP, STEP].map(|by| moved(&now, unknown, by));
            let slope = |of: &dyn Fn(&PairPose) -> f64| (of(&stands[1]) - of(&stands[0])) / (2.0 * STEP);
            let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * (1.0 + a.abs().max(b.abs()));
            let touching = |stand: &PairPose| pair.touching(REST, stand, &before);
            prop_assert!(near(slope(&|s| touching(s).gap_mm), at.pull[0][unknown]), "the gap's are the pull along the normal");
            prop_assert!(near(slope(&|s| touching(s).slip_mm), at.slip_by[unknown]), "slip");
            for axis in 0..2 {
                for i in 0..6 {
                    let pull = slope(&|s| pair.tangent(REST, s, &before).pull[axis][i]);
                    prop_assert!(near(pull, at.pull_by[unknown][axis][i]), "pull {axis} {i}");
                }
            }
        }
    }

    /// Action and reaction: the forces on finger and object are opposite, along and across the normal, and their moments about the origin cancel.
    #[test]
    fn forces_on_finger_and_object_are_opposite(pair in pairs(), now in stands()) {
        let at = pair.touching(REST, &now, &now);
        let across = Vector::new(-at.normal.y, at.normal.x);
        for (pull, direction) in pair.tangent(REST, &now, &now).pull.iter().zip([at.normal, across]) {
            let pull: &Unknowns = pull;
            let on_finger = now.finger.axes() * Vector::new(pull[0], pull[1]);
            let on_object = Vector::new(pull[3], pull[4]);
            prop_assert!((on_finger - direction).norm() < 1e-12 && (on_object + direction).norm() < 1e-12);
            let body = now.finger.outwards(REST + now.body.displacement);
            let sense = if now.finger.mirrored { -1.0 } else { 1.0 };
            let about_origin = body.perp(&on_finger) + sense * pull[2]
                + Vector::new(now.object[0], now.object[1]).perp(&on_object) + pull[5];
            prop_assert!(about_origin.abs() < 1e-9, "{about_origin}");
        }
        prop_assert!(at.slip_mm.abs() < 1e-9, "nothing moved");
    }
}
