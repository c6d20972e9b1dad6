//! Checks of a finger's description, and positions of its nodes.

use super::{
    BracketLengths, Fillets, Finger, FingerDescription, ImpossibleFinger, Joints, OfRibs, Part, Plate, RibPositions,
};
use crate::Vector;
use crate::keys::{BACK, FINGER, FRONT, Key, Kind, RIBS, ZONE};

/// Smallest valid distance between neighbouring nodes that do not share a point, and between nodes and plate ends, as a share of the plate's length.
/// The other checks of the geometry use `SMALLEST_SPACING` as a relative margin.
pub(super) const SMALLEST_SPACING: f64 = 1e-9;

/// Largest shear parameter 12 EI / (kappa G A L^2) of a member, dimensionless. At this limit, a member is several hundred times as thick as it is
/// long. The larger the shear parameter, the more digits of the stiffness against sway are lost to rounding; at this limit, ten digits remain.
const LARGEST_SHEAR_PARAMETER: f64 = 1e6;

pub(super) fn require(holds: bool, key: &str, reason: impl FnOnce() -> String) -> Result<(), ImpossibleFinger> {
    if holds { Ok(()) } else { Err(ImpossibleFinger { key: key.to_owned(), reason: reason() }) }
}

/// Checks a value against the valid range of its key.
fn check<K: Kind>(key: &Key<K>, value: &K::Value) -> Result<(), ImpossibleFinger> {
    key.check(value).map_err(|refused| ImpossibleFinger { key: key.path(), reason: refused.to_string() })
}

/// Checks each size against the valid range of its key.
pub(super) fn check_sizes(d: &FingerDescription) -> Result<(), ImpossibleFinger> {
    check(&FINGER.base_width_mm, &d.base_width_mm)?;
    check(&FINGER.front_length_mm, &d.front_length_mm)?;
    check(&FINGER.back_length_mm, &d.back_length_mm)?;
    check(&FINGER.depth_mm, &d.depth_mm)?;
    check(&FINGER.rod_arm_mm, &d.rod_arm_mm)?;
    d.rib_arm_mm.map_or(Ok(()), |arm_mm| check(&FINGER.rib_arm_mm, &arm_mm))?;
    d.clamp_arm_mm.map_or(Ok(()), |arm_mm| check(&FINGER.clamp_arm_mm, &arm_mm))?;
    check_fillets(d)?;
    check(&FINGER.poissons_ratio, &d.poissons_ratio)?;
    check(&FINGER.shear_correction, &d.shear_correction)?;
    for (keys, strip, ends) in [(&FRONT, d.front, d.rigid_ends[0]), (&BACK, d.back, d.rigid_ends[1])] {
        check(&keys.thickness_mm, &strip.thickness_mm)?;
        strip.tip_thickness_mm.map_or(Ok(()), |thickness_mm| check(&keys.tip_thickness_mm, &thickness_mm))?;
        check(&keys.youngs_modulus_mpa, &strip.youngs_modulus_mpa)?;
        check(&keys.rigid_base_mm, &ends.base_mm)?;
        check(&keys.rigid_tip_mm, &ends.tip_mm)?;
    }
    if let Some(strip) = &d.ribs.strip {
        let each_mm = d.ribs.thicknesses_mm.clone().map(OfRibs::Each);
        check(&RIBS.thickness_mm, &each_mm.unwrap_or(OfRibs::Alike(strip.thickness_mm)))?;
        check(&RIBS.youngs_modulus_mpa, &strip.youngs_modulus_mpa)?;
    }
    check(&RIBS.bracket_mm, &d.ribs.bracket_mm)?;
    check(&RIBS.clip_mm, &d.ribs.clip_mm)
}

/// Checks fillets, and that the finger is one piece: with other arms, hinges or brackets, the rule for the arms does not hold.
fn check_fillets(d: &FingerDescription) -> Result<(), ImpossibleFinger> {
    let Some(Fillets { plates_mm, base_mm }) = d.fillets else {
        return require(d.ribs.fillets_mm.is_none(), &RIBS.fillet_mm.path(), || {
            format!("expected {} beside it, found none", FINGER.fillet_mm.path())
        });
    };
    for (key, radius_mm) in
        [(&FRONT.fillet_mm, plates_mm[0]), (&BACK.fillet_mm, plates_mm[1]), (&FINGER.base_fillet_mm, base_mm)]
    {
        check(key, &radius_mm)?;
    }
    d.ribs.fillets_mm.as_ref().map_or(Ok(()), |radii_mm| check(&RIBS.fillet_mm, radii_mm))?;
    let arms = d.rod_arm_mm != 0.0 || d.rib_arm_mm.is_some() || d.clamp_arm_mm.is_some();
    let deforms = d.ribs.strip.is_some() || d.ribs.positions == RibPositions::Count(0);
    let is_one_piece = d.ribs.joints == Joints::Rigid && d.ribs.bracket_mm == BracketLengths::NONE && deforms;
    for (holds, other) in [
        (!arms, "rod_arm_mm, rib_arm_mm and clamp_arm_mm: arms follow from the fillets"),
        (is_one_piece, "hinged joints, brackets and undeformable ribs: a finger of one piece has none"),
    ] {
        require(holds, &FINGER.fillet_mm.path(), || format!("expected no fillets beside {other}"))?;
    }
    Ok(())
}

/// Position of the tip, mm, finger frame, from the lengths of the triangle's sides. The height follows from Kahan's form of Heron's formula, which is
/// accurate for thin triangles.
pub(super) fn place_tip(d: &FingerDescription) -> Result<Vector, ImpossibleFinger> {
    let mut sides = [
        (d.base_width_mm, &FINGER.base_width_mm),
        (d.front_length_mm, &FINGER.front_length_mm),
        (d.back_length_mm, &FINGER.back_length_mm),
    ];
    sides.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(a, longest), (b, _), (c, _)] = sides;
    let longest = longest.path();
    require(c - (a - b) > a * SMALLEST_SPACING, &longest, || {
        format!(
            "expected less than {:?} mm, the sum of the other two sides: base width {:?}, front plate {:?} and back plate \
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
    require(tip.iter().all(|x| x.is_finite()), &longest, || {
        "expected a smaller length in mm: the position of the tip overflows".to_owned()
    })?;
    Ok(tip)
}

pub(super) fn place_ribs(d: &FingerDescription) -> Result<Vec<[f64; 2]>, ImpossibleFinger> {
    let (ribs, key) = match &d.ribs.positions {
        RibPositions::Count(count) => {
            check(&RIBS.count, count)?;
            let spaced = |length: f64, i: usize| length * i as f64 / (*count + 1) as f64;
            let ribs =
                (1..=*count).map(|i| [spaced(d.front_length_mm, i), spaced(d.back_length_mm, i)]).collect::<Vec<_>>();
            (ribs, RIBS.count.path())
        }
        RibPositions::Positions(positions) => {
            let most = RIBS.count.kind.2;
            require(positions.len() <= most, &RIBS.positions_mm.path(), || {
                format!("expected at most {most} ribs, found {}", positions.len())
            })?;
            (positions.clone(), RIBS.positions_mm.path())
        }
    };
    for (column, plate, length) in [(0, "front", d.front_length_mm), (1, "back", d.back_length_mm)] {
        let gap = length * SMALLEST_SPACING;
        let mut before = 0.0;
        for (i, rib) in ribs.iter().enumerate() {
            let position = rib[column];
            let is_on_plate = position.is_finite() && (position == 0.0 || position > gap) && position < length - gap;
            require(is_on_plate, &key, || {
                format!(
                    "expected the position of rib {} on the {plate} plate from 0 to below {length:?} mm, found \
                        {position:?}",
                    i + 1
                )
            })?;
            require(position == before || position > before + gap, &key, || {
                format!(
                    "expected ribs in order from base to tip that do not cross: on the {plate} plate, rib {} at \
                        {position:?} mm must lie clearly beyond the previous rib at {before:?} mm or exactly at the same position",
                    i + 1
                )
            })?;
            before = position;
        }
    }
    let before = std::iter::once(&[0.0; 2]).chain(&ribs);
    for (i, (rib, _)) in ribs.iter().zip(before).enumerate().filter(|(_, (rib, before))| rib == before) {
        let other = if i == 0 { "the base line" } else { "the previous rib" };
        require(false, &key, || format!("expected ribs that differ: rib {} at {rib:?} mm lies on {other}", i + 1))?;
    }
    Ok(ribs)
}

pub(super) fn check_zones(d: &FingerDescription) -> Result<(), ImpossibleFinger> {
    for (i, zone) in d.zones.iter().enumerate() {
        let number = i + 1;
        let length = if zone.part == Part::Back { d.back_length_mm } else { d.front_length_mm };
        require(zone.from_mm >= 0.0 && zone.from_mm < length, &ZONE.from_mm.path_in(number), || {
            format!("expected a position on the plate, 0 to {length:?} mm, found {:?}", zone.from_mm)
        })?;
        require(zone.to_mm > zone.from_mm && zone.to_mm <= length, &ZONE.to_mm.path_in(number), || {
            format!(
                "expected a position after from_mm = {:?} and up to {length:?} mm, found {:?}",
                zone.from_mm, zone.to_mm
            )
        })?;
        let factor = ZONE.modulus_factor.check(&zone.modulus_factor);
        factor.map_err(|refused| ImpossibleFinger {
            key: ZONE.modulus_factor.path_in(number),
            reason: refused.to_string(),
        })?;
    }
    Ok(())
}

/// Rejects brackets and undeformable ribs if ribs share a junction. A shared junction ties nodes to each other, and a tied node cannot also belong to
/// a rigid link.
fn check_shared_junctions(finger: &Finger) -> Result<(), ImpossibleFinger> {
    let shared = "where ribs share a junction or end in a corner of the base";
    let refused = finger.has_shared_junctions();
    require(!(refused && finger.has_brackets()), &RIBS.bracket_mm.path(), || format!("expected no brackets {shared}"))?;
    let is_rigid = finger.description.ribs.strip.is_none();
    require(!(refused && is_rigid), &RIBS.rigid.path(), || format!("expected false {shared}"))
}

/// Checks that lists with one value per rib have as many values as the finger has ribs.
pub(super) fn check_lists(finger: &Finger) -> Result<(), ImpossibleFinger> {
    let (ribs, count) = (&finger.description.ribs, finger.rib_count());
    let thicknesses = ribs.thicknesses_mm.as_ref().map(|each| (RIBS.thickness_mm.path(), "thickness", each.len()));
    let fillets = ribs.fillets_mm.clone().and_then(OfRibs::each);
    let fillets = fillets.map(|each| (RIBS.fillet_mm.path(), "radius", each.len()));
    for (key, name, found) in thicknesses.into_iter().chain(fillets) {
        require(found == count, &key, || {
            format!("expected one {name} for each of {count} ribs, found {found} values")
        })?;
    }
    Ok(())
}

/// Checks that rods, clips and rigid ends leave an elastic part of each member, and that brackets leave room for each rib.
pub(super) fn check_room(finger: &Finger) -> Result<(), ImpossibleFinger> {
    check_shared_junctions(finger)?;
    check_brackets(finger)?;
    let d = &finger.description;
    check_rod_arms(finger)?;
    let plates = [Plate::Front, Plate::Back];
    let members =
        plates.map(|plate| finger.plate_positions_mm(plate).windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>());
    for (((plate, name), keys), lengths_mm) in
        plates.into_iter().zip(["front", "back"]).zip([&FRONT, &BACK]).zip(&members)
    {
        for (member, length_mm) in lengths_mm.iter().enumerate().filter(|(_, length_mm)| **length_mm > 0.0) {
            let arms_mm = finger.member_arms_mm(plate, member);
            let key = match member {
                0 => keys.rigid_base_mm.path(),
                last if last == finger.rib_count() => keys.rigid_tip_mm.path(),
                _ => RIBS.clip_mm.path(),
            };
            require(arms_mm[0] + arms_mm[1] < length_mm * (1.0 - SMALLEST_SPACING), &key, || {
                format!(
                    "expected clips and rigid ends together shorter than each member of the {name} plate, found {:?} mm in a member of {length_mm:?} mm",
                    arms_mm[0] + arms_mm[1]
                )
            })?;
        }
    }
    if d.shear_correction > 0.0 { check_shear(finger) } else { Ok(()) }
}

/// Checks that the arms of rods leave an elastic part of each member.
fn check_rod_arms(finger: &Finger) -> Result<(), ImpossibleFinger> {
    let d = &finger.description;
    let rod_arm = (FINGER.rod_arm_mm.path(), d.rod_arm_mm, "member");
    let rib_arm = d.rib_arm_mm.map_or(rod_arm.clone(), |arm_mm| (FINGER.rib_arm_mm.path(), arm_mm, "rib"));
    let ribs = (0..finger.rib_count()).map(|rib| (&rib_arm, finger.rib_length_mm(rib), finger.rib_nodes(rib)));
    let of_plate = |plate: Plate| {
        let (nodes, positions_mm) = (finger.plate_nodes(plate), finger.plate_positions_mm(plate));
        let member = |i: usize| (&rod_arm, positions_mm[i + 1] - positions_mm[i], [nodes[i], nodes[i + 1]]);
        (0..=finger.rib_count()).map(member).collect::<Vec<_>>()
    };
    let members = [Plate::Front, Plate::Back].into_iter().flat_map(of_plate).chain(ribs);
    let mut members: Vec<_> = members.filter(|(_, length_mm, _)| *length_mm > 0.0).collect();
    members.sort_by(|a, b| a.1.total_cmp(&b.1));
    for (arm, length_mm, nodes) in members {
        let &(ref key, arm_mm, name) = arm;
        let room_mm = length_mm * (1.0 - SMALLEST_SPACING);
        let is_clamped = nodes.iter().any(|node| finger.is_clamped(*node));
        match d.clamp_arm_mm.filter(|_| is_clamped) {
            None => require(2.0 * arm_mm < room_mm, key, || {
                format!("expected less than half of the shortest {name}, {length_mm:?} mm, found {arm_mm:?}")
            })?,
            Some(clamp_arm_mm) => {
                require(arm_mm < room_mm, key, || {
                    format!("expected less than the {name} at the clamp, {length_mm:?} mm, found {arm_mm:?}")
                })?;
                require(arm_mm + clamp_arm_mm < room_mm, &FINGER.clamp_arm_mm.path(), || {
                    let left_mm = length_mm - arm_mm;
                    format!(
                        "expected less than {left_mm:?} mm, which {key} leaves of a {name} at the clamp, found {clamp_arm_mm:?}"
                    )
                })?;
            }
        }
    }
    Ok(())
}

/// Rejects members with too large a shear parameter: a very thick, short member would lose its stiffness against sway to rounding.
fn check_shear(finger: &Finger) -> Result<(), ImpossibleFinger> {
    let d = &finger.description;
    let of_plate = |plate: Plate| {
        let thickest_mm = [0.0, finger.plate_length_mm(plate)].map(|s_mm| finger.thickness_mm(plate, s_mm));
        let positions_mm = finger.plate_positions_mm(plate);
        let free = |member: usize| {
            let arms_mm = finger.member_arms_mm(plate, member);
            positions_mm[member + 1] - positions_mm[member] - arms_mm[0] - arms_mm[1]
        };
        let lengths_mm: Vec<f64> = (0..=finger.rib_count()).map(free).filter(|length_mm| *length_mm > 0.0).collect();
        lengths_mm.into_iter().map(move |length_mm| thickest_mm[0].max(thickest_mm[1]) / length_mm)
    };
    let of_rib = |rib: usize| {
        let thickness_mm = d.ribs.strip.map_or(0.0, |strip| strip.thickness_mm);
        let arms_mm = finger.rib_arms_mm(rib);
        thickness_mm / (finger.rib_length_mm(rib) - arms_mm[0] - arms_mm[1])
    };
    let ratios = [Plate::Front, Plate::Back].into_iter().flat_map(of_plate).chain((0..finger.rib_count()).map(of_rib));
    let most = finger.shear_flexibility() * ratios.fold(0.0, f64::max).powi(2);
    require(most <= LARGEST_SHEAR_PARAMETER, &FINGER.shear_correction.path(), || {
        format!(
            "expected members with a shear parameter 12 EI / (kappa G A L^2) up to {LARGEST_SHEAR_PARAMETER:e}, found {most:e}"
        )
    })
}

/// For each rib and plate, checks that the bracket is shorter than the distance from the plate to the rib's joint on the other plate. This check
/// ensures that each rib has a positive length, and that ribs do not cross.
fn check_brackets(finger: &Finger) -> Result<(), ImpossibleFinger> {
    let key = RIBS.bracket_mm.path();
    if let BracketLengths::Each(lengths_mm) = &finger.description.ribs.bracket_mm {
        require(lengths_mm.len() == finger.rib_count(), &key, || {
            format!("expected one pair for each of {} ribs, found {} pairs", finger.rib_count(), lengths_mm.len())
        })?;
    }
    for rib in 0..finger.rib_count() {
        let brackets_mm = finger.description.ribs.bracket_mm.of(rib);
        let [front, back] = finger.rib_nodes(rib);
        for (plate, hinge, other_mm) in [(Plate::Front, back, brackets_mm[0]), (Plate::Back, front, brackets_mm[1])] {
            let distance_mm = (finger.hinge(hinge) - finger.base(plate)).dot(&finger.inward(plate));
            require(distance_mm * (1.0 - SMALLEST_SPACING) > other_mm, &key, || {
                format!(
                    "expected brackets shorter than the gap between the plates at rib {}, found {brackets_mm:?} mm on front and back plate",
                    rib + 1
                )
            })?;
        }
    }
    Ok(())
}
