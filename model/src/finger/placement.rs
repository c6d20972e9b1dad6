//! What a description must hold to be a finger, and where its nodes are.

use super::{BracketLengths, Finger, FingerDescription, ImpossibleFinger, Part, Plate, RibPositions, Strip};
use crate::Vector;

/// Neighbouring nodes and the plates' ends must be this share of a plate apart.
pub(super) const SMALLEST_SPACING: f64 = 1e-9;
/// Most ribs that a finger may have.
const MAX_RIBS: usize = 1000;

pub(super) fn require(holds: bool, key: &str, reason: impl FnOnce() -> String) -> Result<(), ImpossibleFinger> {
    if holds { Ok(()) } else { Err(ImpossibleFinger { key: key.to_owned(), reason: reason() }) }
}

/// Denormal numbers count as zero: nothing can be computed with them in double precision. Messages write numbers with
/// `{:?}`, which gives such ones a power of ten.
pub(super) fn require_positive(key: &str, value: f64, unit: &str) -> Result<(), ImpossibleFinger> {
    require(value.is_normal() && value > 0.0, key, || format!("expected a positive {unit}, found {value:?}"))
}

pub(super) fn check_strip(key: &str, strip: &Strip) -> Result<(), ImpossibleFinger> {
    require_positive(&format!("{key}.thickness_mm"), strip.thickness_mm, "length in mm")?;
    require_positive(&format!("{key}.youngs_modulus_mpa"), strip.youngs_modulus_mpa, "modulus in MPa")
}

/// The tip from the three sides of the triangle; its height by Kahan's form of Heron's formula, which keeps its digits
/// for needle-thin and very obtuse triangles.
pub(super) fn place_tip(d: &FingerDescription) -> Result<Vector, ImpossibleFinger> {
    let mut sides = [
        (d.base_width_mm, "finger.base_width_mm"),
        (d.front_length_mm, "finger.front_length_mm"),
        (d.back_length_mm, "finger.back_length_mm"),
    ];
    sides.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(a, longest), (b, _), (c, _)] = sides;
    require(c - (a - b) > a * SMALLEST_SPACING, longest, || {
        format!(
            "expected less than {:?} mm, the other two sides together: base width {:?}, front plate {:?} and back plate \
             {:?} make no triangle",
            b + c,
            d.base_width_mm,
            d.front_length_mm,
            d.back_length_mm
        )
    })?;
    let area = 0.25 * ((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))).sqrt();
    let (front, back) = (d.front_length_mm, d.back_length_mm);
    let tip = Vector::new(2.0 * area / d.base_width_mm, (back - front) * (back + front) / (2.0 * d.base_width_mm));
    require(tip.iter().all(|x| x.is_finite()), longest, || "expected lengths of a finger in mm".to_owned())?;
    Ok(tip)
}

pub(super) fn place_ribs(d: &FingerDescription) -> Result<Vec<[f64; 2]>, ImpossibleFinger> {
    let (ribs, key) = match &d.ribs.positions {
        RibPositions::Count(count) => {
            require(*count <= MAX_RIBS, "finger.ribs.count", || {
                format!("expected 0 to {MAX_RIBS} ribs, found {count}")
            })?;
            let spaced = |length: f64, i: usize| length * i as f64 / (*count + 1) as f64;
            let ribs =
                (1..=*count).map(|i| [spaced(d.front_length_mm, i), spaced(d.back_length_mm, i)]).collect::<Vec<_>>();
            (ribs, "finger.ribs.count")
        }
        RibPositions::Positions(positions) => {
            require(positions.len() <= MAX_RIBS, "finger.ribs.positions_mm", || {
                format!("expected at most {MAX_RIBS} ribs, found {}", positions.len())
            })?;
            (positions.clone(), "finger.ribs.positions_mm")
        }
    };
    for (column, plate, length) in [(0, "front", d.front_length_mm), (1, "back", d.back_length_mm)] {
        let gap = length * SMALLEST_SPACING;
        let mut before = 0.0;
        for (i, rib) in ribs.iter().enumerate() {
            let position = rib[column];
            require(position.is_finite() && position > gap && position < length - gap, key, || {
                format!("expected rib {} on the {plate} plate, between 0 and {length:?} mm, found {position:?}", i + 1)
            })?;
            require(position > before + gap, key, || {
                format!(
                    "expected ribs from base to tip that neither cross nor touch: on the {plate} plate rib {} at \
                     {position:?} mm does not follow the rib before it at {before:?} mm",
                    i + 1
                )
            })?;
            before = position;
        }
    }
    Ok(ribs)
}

pub(super) fn check_zones(d: &FingerDescription) -> Result<(), ImpossibleFinger> {
    for (i, zone) in d.zones.iter().enumerate() {
        let key = |name: &str| format!("finger.zone[{}].{name}", i + 1);
        let length = if zone.part == Part::Back { d.back_length_mm } else { d.front_length_mm };
        require(zone.from_mm >= 0.0 && zone.from_mm < length, &key("from_mm"), || {
            format!("expected a position on the plate, 0 to {length:?} mm, found {:?}", zone.from_mm)
        })?;
        require(zone.to_mm > zone.from_mm && zone.to_mm <= length, &key("to_mm"), || {
            format!(
                "expected a position after from_mm = {:?} and up to {length:?} mm, found {:?}",
                zone.from_mm, zone.to_mm
            )
        })?;
        require_positive(&key("modulus_factor"), zone.modulus_factor, "factor")?;
    }
    Ok(())
}

/// The arms of rods, clips and rigid ends, and the brackets of ribs must leave room for what is between them.
pub(super) fn check_room(finger: &Finger) -> Result<(), ImpossibleFinger> {
    check_brackets(finger)?;
    let d = &finger.description;
    let ribs = (0..finger.rib_count()).map(|rib| finger.rib_length_mm(rib));
    let plates = [Plate::Front, Plate::Back];
    let members =
        plates.map(|plate| finger.plate_positions_mm(plate).windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>());
    let shortest = members.iter().flatten().copied().chain(ribs).fold(f64::INFINITY, f64::min);
    require(2.0 * d.rod_arm_mm < shortest * (1.0 - SMALLEST_SPACING), "finger.rod_arm_mm", || {
        format!("expected less than half of the shortest member, {shortest:?} mm, found {:?}", d.rod_arm_mm)
    })?;
    for ((plate, name), lengths_mm) in plates.into_iter().zip(["front", "back"]).zip(&members) {
        for (member, length_mm) in lengths_mm.iter().enumerate() {
            let arms_mm = finger.member_arms_mm(plate, member);
            let key = match member {
                0 => format!("finger.{name}.rigid_base_mm"),
                last if last == finger.rib_count() => format!("finger.{name}.rigid_tip_mm"),
                _ => "finger.ribs.clip_mm".to_owned(),
            };
            require(arms_mm[0] + arms_mm[1] < length_mm * (1.0 - SMALLEST_SPACING), &key, || {
                format!(
                    "expected clips and rigid ends that leave some of each member of the {name} plate to bend, found {:?} of {length_mm:?} mm rigid",
                    arms_mm[0] + arms_mm[1]
                )
            })?;
        }
    }
    Ok(())
}

/// The hinges of each plate must lie before those of the other: then ribs have a length and neither cross nor turn round.
fn check_brackets(finger: &Finger) -> Result<(), ImpossibleFinger> {
    const KEY: &str = "finger.ribs.bracket_mm";
    if let BracketLengths::Each(lengths_mm) = &finger.description.ribs.bracket_mm {
        require(lengths_mm.len() == finger.rib_count(), KEY, || {
            format!("expected a pair for each of {} ribs, found {}", finger.rib_count(), lengths_mm.len())
        })?;
    }
    for rib in 0..finger.rib_count() {
        let brackets_mm = finger.description.ribs.bracket_mm.of(rib);
        let [front, back] = finger.rib_nodes(rib);
        for (plate, hinge, other_mm) in [(Plate::Front, back, brackets_mm[0]), (Plate::Back, front, brackets_mm[1])] {
            let distance_mm = (finger.hinge(hinge) - finger.base(plate)).dot(&finger.inward(plate));
            require(distance_mm * (1.0 - SMALLEST_SPACING) > other_mm, KEY, || {
                format!(
                    "expected brackets that leave room for rib {} between them, found {brackets_mm:?} on front and back \
                     plate",
                    rib + 1
                )
            })?;
        }
    }
    Ok(())
}

/// Lengths that may be zero.
pub(super) fn check_rigid_parts(d: &FingerDescription) -> Result<(), ImpossibleFinger> {
    let [front, back] = d.rigid_ends;
    for (key, lengths_mm) in [
        ("finger.ribs.bracket_mm", d.ribs.bracket_mm.all().as_flattened()),
        ("finger.ribs.clip_mm", &d.ribs.clip_mm[..]),
        ("finger.front.rigid_base_mm", &[front.base_mm]),
        ("finger.front.rigid_tip_mm", &[front.tip_mm]),
        ("finger.back.rigid_base_mm", &[back.base_mm]),
        ("finger.back.rigid_tip_mm", &[back.tip_mm]),
    ] {
        let possible =
            lengths_mm.iter().all(|length_mm| *length_mm == 0.0 || (length_mm.is_normal() && *length_mm > 0.0));
        require(possible, key, || match lengths_mm {
            [length_mm] => format!("expected a length in mm, zero or more, found {length_mm:?}"),
            _ => format!("expected lengths in mm, zero or more, found {lengths_mm:?}"),
        })?;
    }
    Ok(())
}
