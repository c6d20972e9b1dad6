//! Random fingers.

use finray_model::Finger;
use finray_model::finger::{
    BracketLengths, FingerDescription, Joints, MarkerPoints, Part, Plate, RibDescription, RibPositions, RigidEnds,
    Strip, Zone,
};
use proptest::prelude::*;

fn strip() -> impl Strategy<Value = Strip> {
    (0.5..3.0, 5.0..500.0).prop_map(|(thickness_mm, youngs_modulus_mpa)| Strip {
        thickness_mm,
        tip_thickness_mm: None,
        youngs_modulus_mpa,
    })
}

/// Up to seven ribs with unequal gaps, rigid or hinged joints, and deformable or undeformable strips.
fn ribs() -> impl Strategy<Value = (usize, Vec<[f64; 2]>, Joints, Option<Strip>)> {
    (
        0..8_usize,
        prop::collection::vec([0.3..1.0, 0.3..1.0], 8),
        prop_oneof![Just(Joints::Rigid), Just(Joints::Hinged)],
        prop::option::weighted(0.7, strip()),
    )
}

/// Brackets, clips and rigid plate ends, each in a third of the fingers, and markers on junctions or hinges. Lengths of brackets are shares of the
/// base width; lengths of clips and plate ends are shares of the front plate's length.
fn rigid_parts() -> impl Strategy<Value = ([f64; 2], [f64; 2], [RigidEnds; 2], MarkerPoints)> {
    let brackets = prop_oneof![2 => Just([0.0; 2]), 1 => [0.0..0.08, 0.0..0.08]];
    let clips = prop_oneof![2 => Just([0.0; 2]), 1 => [0.0..0.04, 0.0..0.04]];
    let ends = prop_oneof![2 => Just([0.0; 4]), 1 => [0.0..0.05, 0.0..0.05, 0.0..0.05, 0.0..0.05]];
    let ends = ends.prop_map(|[a, b, c, d]| [[a, b], [c, d]].map(|[base_mm, tip_mm]| RigidEnds { base_mm, tip_mm }));
    (brackets, clips, ends, prop_oneof![Just(MarkerPoints::Junctions), Just(MarkerPoints::Hinges)])
}

/// Fingers of [`finger`], some of them with undeformable brackets, clips or plate ends.
pub fn built_finger() -> impl Strategy<Value = Finger> {
    built(finger())
}

/// Fingers of [`finger_with_zones`], some of them with undeformable brackets, clips or plate ends.
pub fn built_finger_with_zones() -> impl Strategy<Value = Finger> {
    built(finger_with_zones())
}

fn built(fingers: impl Strategy<Value = Finger>) -> impl Strategy<Value = Finger> {
    (fingers, rigid_parts()).prop_filter_map(
        "no room for rigid parts",
        |(finger, (brackets, clips, ends, markers_on))| {
            let mut description = FingerDescription { markers_on, ..finger.description().clone() };
            let (base_mm, front_mm) = (description.base_width_mm, description.front_length_mm);
            // Fingers with clips or rigid ends also differ in the arms of ribs, and in the arms at the clamp.
            description.rib_arm_mm = (clips != [0.0; 2]).then_some(0.7 * description.rod_arm_mm);
            description.clamp_arm_mm = (ends[0].tip_mm > 0.0).then_some(0.3 * description.rod_arm_mm);
            description.ribs.bracket_mm = BracketLengths::Alike(brackets.map(|share| share * base_mm));
            description.ribs.clip_mm = clips.map(|share| share * front_mm);
            description.rigid_ends = ends.map(|RigidEnds { base_mm, tip_mm }| RigidEnds {
                base_mm: base_mm * front_mm,
                tip_mm: tip_mm * front_mm,
            });
            Finger::new(description).ok()
        },
    )
}

/// Fingers with plates and ribs of every kind. They have no zones, and no rigid parts except the arms of rods.
pub fn finger() -> impl Strategy<Value = Finger> {
    let sizes = (40.0..90.0, 80.0..200.0, 0.85..1.2, 8.0..40.0);
    let extras = (prop_oneof![Just(0.0), 0.005..0.02], prop_oneof![Just(0.0), 0.1..0.49]);
    (sizes, extras, strip(), strip(), ribs()).prop_filter_map(
        "an impossible finger",
        |(sizes, extras, front, back, ribs)| {
            let (base_width_mm, front_length_mm, ratio, depth_mm) = sizes;
            let back_length_mm = front_length_mm * ratio;
            let (count, gaps, joints, strip) = ribs;
            // Random gaps between ribs are scaled to positions that increase from base to tip.
            let position = |plate: usize, length: f64, rib: usize| {
                let until = |n: usize| gaps[..n].iter().map(|gap| gap[plate]).sum::<f64>();
                length * until(rib + 1) / until(count + 1)
            };
            let positions =
                (0..count).map(|rib| [position(0, front_length_mm, rib), position(1, back_length_mm, rib)]).collect();
            let description = FingerDescription {
                base_width_mm,
                front_length_mm,
                back_length_mm,
                depth_mm,
                rod_arm_mm: extras.0 * front_length_mm,
                rib_arm_mm: None,
                clamp_arm_mm: None,
                fillets: None,
                poissons_ratio: extras.1,
                side_faces: None,
                shear_correction: 0.0,
                front,
                back,
                rigid_ends: Default::default(),
                ribs: RibDescription {
                    thicknesses_mm: None,
                    fillets_mm: None,
                    positions: RibPositions::Positions(positions),
                    joints,
                    bracket_mm: BracketLengths::NONE,
                    clip_mm: [0.0; 2],
                    strip,
                },
                zones: Vec::new(),
                markers_on: MarkerPoints::Junctions,
            };
            Finger::new(description).ok()
        },
    )
}

/// Fingers with up to two zones of another modulus, on plates or ribs.
pub fn finger_with_zones() -> impl Strategy<Value = Finger> {
    let zone = (prop_oneof![Just(Part::Front), Just(Part::Back), Just(Part::Ribs)], 0.0..0.7, 0.05..0.3, 0.1..3.0);
    (finger(), prop::collection::vec(zone, 0..3)).prop_filter_map("an impossible zone", |(finger, zones)| {
        let length = finger.plate_length_mm(Plate::Front).min(finger.plate_length_mm(Plate::Back));
        let mut description = finger.description().clone();
        description.zones = zones
            .into_iter()
            .map(|(part, from, long, modulus_factor)| Zone {
                part,
                from_mm: from * length,
                to_mm: (from + long) * length,
                modulus_factor,
            })
            .collect();
        Finger::new(description).ok()
    })
}
