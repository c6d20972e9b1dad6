//! Differences between a scene's finger and a finger that another program solved, by the keys of the scene.

use crate::prelude::*;
use finray_model::finger::{Fillets, FingerDescription, Joints, RibDescription, RibPositions, RigidEnds, Strip, Zone};
use finray_model::keys::{BACK, CONTACT, FINGER, FRONT, Key, Kind as KeyKind, PlateKeys, RIBS, SceneTable, ZONE};
use std::fmt;

/// Model whose shapes were exported. It determines the keys on which the shapes depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solved {
    /// The beams of the scene. Their shapes do not depend on the rods' radius.
    Beams,
    /// A plane continuum with plates, ribs and rods of the scene's sizes. Its shapes do not depend on the beams' arms and shear correction.
    Continuum,
}

/// A key whose value differs between a scene and an exported finger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    key: String,
    expected: String,
    found: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.key, self.expected, self.found)
    }
}

/// Every key on which the exported shapes depend and whose value differs, with defaults for keys that a scene does not state.
pub(super) fn differences(scene: &Scene, exported: &Scene, solved: Solved) -> Vec<Difference> {
    let (found, expected) = (properties(scene, solved), properties(exported, solved));
    let differing = found.into_iter().zip(expected).filter(|((_, found), (_, expected))| found != expected);
    differing.map(|((key, found), (_, expected))| Difference { key, expected, found }).collect()
}

/// Keys of a scene and their values as text, in the same order for every scene.
fn properties(scene: &Scene, solved: Solved) -> Vec<(String, String)> {
    let finger = &scene.finger;
    // A new field does not compile here until its influence on exported shapes is decided.
    let FingerDescription {
        base_width_mm,
        front_length_mm,
        back_length_mm,
        depth_mm,
        rod_arm_mm,
        rib_arm_mm,
        clamp_arm_mm,
        fillets,
        poissons_ratio,
        side_faces,
        shear_correction,
        front,
        back,
        rigid_ends,
        ribs,
        zones,
        markers_on: _,
    } = finger.description();
    let mut all = vec![
        number(&FINGER.base_width_mm, *base_width_mm),
        number(&FINGER.front_length_mm, *front_length_mm),
        number(&FINGER.back_length_mm, *back_length_mm),
        number(&FINGER.depth_mm, *depth_mm),
        number(&FINGER.poissons_ratio, *poissons_ratio),
        (FINGER.side_faces.path(), format!("{:?}", side_faces.unwrap_or_default()).to_lowercase()),
    ];
    all.extend(of_plate(&FRONT, front, &rigid_ends[0]));
    all.extend(of_plate(&BACK, back, &rigid_ends[1]));
    all.extend(of_ribs(finger, ribs));
    all.push((ZONE.path().to_owned(), listed(zones.iter().map(of_zone))));
    all.extend(match solved {
        // The corners of the continua are sharp, and fillets of zero radius are sharp corners.
        Solved::Continuum => vec![
            number(&CONTACT.rod_radius_mm, scene.contact.rod_radius_mm),
            (FINGER.fillet_mm.path(), of_fillets(fillets.unwrap_or_default())),
        ],
        Solved::Beams => vec![
            number(&FINGER.rod_arm_mm, *rod_arm_mm),
            number(&FINGER.rib_arm_mm, rib_arm_mm.unwrap_or(*rod_arm_mm)),
            (FINGER.clamp_arm_mm.path(), clamp_arm_mm.map_or("the members' other arm".to_owned(), rounded)),
            (FINGER.fillet_mm.path(), fillets.map_or("none".to_owned(), of_fillets)),
            number(&FINGER.shear_correction, *shear_correction),
        ],
    });
    all
}

fn of_fillets(Fillets { plates_mm, base_mm }: Fillets) -> String {
    format!("{}, {} at the base", pair(plates_mm), rounded(base_mm))
}

fn of_plate(keys: &PlateKeys, strip: &Strip, ends: &RigidEnds) -> [(String, String); 5] {
    let Strip { thickness_mm, tip_thickness_mm, youngs_modulus_mpa } = *strip;
    let RigidEnds { base_mm, tip_mm } = *ends;
    [
        number(&keys.thickness_mm, thickness_mm),
        number(&keys.tip_thickness_mm, tip_thickness_mm.unwrap_or(thickness_mm)),
        number(&keys.youngs_modulus_mpa, youngs_modulus_mpa),
        number(&keys.rigid_base_mm, base_mm),
        number(&keys.rigid_tip_mm, tip_mm),
    ]
}

fn of_ribs(finger: &Finger, ribs: &RibDescription) -> [(String, String); 8] {
    let RibDescription { positions, joints, bracket_mm, clip_mm, strip, thicknesses_mm, fillets_mm } = ribs;
    let count = finger.rib_count();
    let [front_mm, back_mm] = [Plate::Front, Plate::Back].map(|plate| finger.plate_positions_mm(plate));
    let key = match positions {
        RibPositions::Count(_) => RIBS.count.path(),
        RibPositions::Positions(_) => RIBS.positions_mm.path(),
    };
    let is_rigid = strip.is_none() && count > 0;
    let thickness_mm =
        |rib| thicknesses_mm.as_ref().map_or(strip.map(|strip| strip.thickness_mm), |all| all.get(rib).copied());
    [
        (key, format!("{count} ribs at {}", listed((1..=count).map(|rib| pair([front_mm[rib], back_mm[rib]]))))),
        (RIBS.joints.path(), if *joints == Joints::Hinged { "hinged" } else { "rigid" }.to_owned()),
        (RIBS.rigid.path(), is_rigid.to_string()),
        (RIBS.thickness_mm.path(), listed((0..count).filter_map(thickness_mm).map(rounded))),
        (RIBS.youngs_modulus_mpa.path(), strip.map_or("none".to_owned(), |strip| rounded(strip.youngs_modulus_mpa))),
        (RIBS.bracket_mm.path(), listed((0..count).map(|rib| pair(bracket_mm.of(rib))))),
        (RIBS.clip_mm.path(), pair(*clip_mm)),
        (RIBS.fillet_mm.path(), listed((0..count).filter_map(|rib| Some(rounded(fillets_mm.as_ref()?.of(rib)))))),
    ]
}

fn of_zone(zone: &Zone) -> String {
    let Zone { part, from_mm, to_mm, modulus_factor } = zone;
    format!("{part:?} {} to {} mm by {}", rounded(*from_mm), rounded(*to_mm), rounded(*modulus_factor))
}

fn number<K: KeyKind>(key: &Key<K>, value: f64) -> (String, String) {
    (key.path(), rounded(value))
}

/// Rounds to [`SAME`](crate::truths::SAME), because evenly spaced ribs and their stated positions differ in the last digits.
fn rounded(value: f64) -> String {
    ((value * 1e9).round() / 1e9).to_string()
}

fn pair([a, b]: [f64; 2]) -> String {
    format!("[{}, {}]", rounded(a), rounded(b))
}

/// A list in brackets, in which equal neighbours are written once.
fn listed(values: impl Iterator<Item = String>) -> String {
    let mut values: Vec<String> = values.collect();
    values.dedup();
    format!("[{}]", values.join(", "))
}
