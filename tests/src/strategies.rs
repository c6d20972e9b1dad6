//! Random fingers.

use finray_model::Finger;
use finray_model::finger::{
    FingerDescription, Joints, MarkerPoints, Part, Plate, RibDescription, RibPositions, Strip, Zone,
};
use proptest::prelude::*;

fn strip() -> impl Strategy<Value = Strip> {
    (0.5..3.0, 5.0..500.0).prop_map(|(thickness_mm, youngs_modulus_mpa)| Strip { thickness_mm, youngs_modulus_mpa })
}

/// Up to seven ribs, evenly or unevenly spaced, clamped or pinned, deformable or not.
fn ribs() -> impl Strategy<Value = (usize, Vec<[f64; 2]>, Joints, Option<Strip>)> {
    (
        0..8_usize,
        prop::collection::vec([0.3..1.0, 0.3..1.0], 8),
        prop_oneof![Just(Joints::Rigid), Just(Joints::Hinged)],
        prop::option::weighted(0.7, strip()),
    )
}

/// None, or of any two lengths, as shares of the base width; with markers on junctions or hinges.
fn brackets() -> impl Strategy<Value = ([f64; 2], MarkerPoints)> {
    let lengths = prop_oneof![2 => Just([0.0; 2]), 1 => [0.0..0.08, 0.0..0.08]];
    (lengths, prop_oneof![Just(MarkerPoints::Junctions), Just(MarkerPoints::Hinges)])
}

/// Fingers of every kind that a scene file can describe, without zones.
pub fn finger() -> impl Strategy<Value = Finger> {
    let sizes = (40.0..90.0, 80.0..200.0, 0.85..1.2, 8.0..40.0);
    let extras = (prop_oneof![Just(0.0), 0.005..0.02], prop_oneof![Just(0.0), 0.1..0.49]);
    (sizes, extras, strip(), strip(), ribs(), brackets()).prop_filter_map(
        "an impossible finger",
        |(sizes, extras, front, back, ribs, (brackets, markers_on))| {
            let (base_width_mm, front_length_mm, ratio, depth_mm) = sizes;
            let back_length_mm = front_length_mm * ratio;
            let (count, gaps, joints, strip) = ribs;
            // Gaps between ribs, drawn, become positions that grow from the base to the tip.
            let position = |plate: usize, length: f64, rib: usize| {
                let until = |n: usize| gaps[..n].iter().map(|gap| gap[plate]).sum::<f64>();
                length * until(rib + 1) / until(count + 1)
            };
            let positions =
                (0..count).map(|rib| [position(0, front_length_mm, rib), position(1, back_length_mm, rib)]).collect();
            let bracket_mm = brackets.map(|share| share * base_width_mm);
            let description = FingerDescription {
                base_width_mm,
                front_length_mm,
                back_length_mm,
                depth_mm,
                rod_arm_mm: extras.0 * front_length_mm,
                poissons_ratio: extras.1,
                front,
                back,
                ribs: RibDescription { positions: RibPositions::Positions(positions), joints, bracket_mm, strip },
                zones: Vec::new(),
                markers_on,
            };
            Finger::new(description).ok()
        },
    )
}

/// Fingers whose plates carry up to two zones of other modulus.
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
