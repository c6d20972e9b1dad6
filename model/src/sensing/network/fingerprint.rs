//! Fingerprint of the finger that a network belongs to, independent of names in the scene file.

use crate::Finger;
use crate::finger::{Joints, MarkerPoints, NodeId, Part, Plate, SideFaces};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use sha2::{Digest, Sha256};
use std::fmt;
use std::str::FromStr;

/// Number of significant digits that are compared, so that rounding errors do not matter. Rounding errors arise, for example, if one scene states the
/// number of ribs and another scene states the positions of the same ribs.
const DIGITS: i32 = 10;

/// SHA-256 hash of the numbers that define a finger: key nodes, rigid arms, clips and ends, rigidities, shear, tapers, rib thicknesses, joints,
/// brackets with the points of markers, and zones. Names, the order of zones, the way in which the scene states the ribs, and other tables of the
/// scene have no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Fingerprint([u8; 32]);

impl Fingerprint {
    /// Fingerprint of a finger. Fingers have the same fingerprint if their numbers round to the same ten significant digits.
    pub fn of(finger: &Finger) -> Fingerprint {
        let mut numbers = Numbers(Sha256::new());
        // Coordinates may be zero, so they are rounded to a step that depends on the length of the longer plate.
        let longest_mm = f64::max(finger.plate_length_mm(Plate::Front), finger.plate_length_mm(Plate::Back));
        let step_mm = 10_f64.powi(longest_mm.log10().floor() as i32 + 1 - DIGITS);
        numbers.number("step_mm", step_mm);
        for node in (1..=finger.key_node_count()).map(NodeId) {
            for coordinate_mm in finger.position(node).iter() {
                numbers.text(&format!("node {node} {}", (coordinate_mm / step_mm).round() as i64));
            }
        }
        let d = finger.description();
        numbers.number("arm_mm", d.rod_arm_mm);
        let of_ribs_mm = d.rib_arm_mm.unwrap_or(d.rod_arm_mm);
        if of_ribs_mm != d.rod_arm_mm {
            numbers.number("rib arm_mm", of_ribs_mm);
        }
        for arm_mm in d.clamp_arm_mm.iter().filter(|arm_mm| [d.rod_arm_mm, of_ribs_mm] != [**arm_mm; 2]) {
            numbers.number("clamp arm_mm", *arm_mm);
        }
        if d.fillets.is_some() {
            let members = (0..=finger.rib_count())
                .flat_map(|member| [Plate::Front, Plate::Back].map(|plate| finger.member_arms_mm(plate, member)));
            let ribs = (0..finger.rib_count()).map(|rib| finger.rib_arms_mm(rib));
            members.chain(ribs).flatten().for_each(|arm_mm| numbers.number("arm beside fillets mm", arm_mm));
        }
        if finger.shear_flexibility() > 0.0 {
            numbers.number("shear_flexibility", finger.shear_flexibility());
        }
        if d.side_faces == Some(SideFaces::Free) {
            numbers.number("free side faces: depth_mm", d.depth_mm);
            numbers.number("free side faces: poissons_ratio", d.poissons_ratio);
        }
        numbers.part(finger, "front", Part::Front);
        numbers.part(finger, "back", Part::Back);
        if finger.rib_count() > 0 {
            numbers.part(finger, "ribs", Part::Ribs);
            numbers.text(match finger.description().ribs.joints {
                Joints::Rigid => "joints rigid",
                Joints::Hinged => "joints hinged",
            });
        }
        for (name, plate, strip) in [("front", Plate::Front, d.front), ("back", Plate::Back, d.back)] {
            for thickness_mm in strip.tip_thickness_mm.iter().filter(|_| finger.tapers(plate)) {
                numbers.number(&format!("{name} tip_thickness_mm"), *thickness_mm);
            }
        }
        let ends = d.rigid_ends.iter().flat_map(|ends| [ends.base_mm, ends.tip_mm]);
        let rigid: Vec<f64> = d.ribs.clip_mm.iter().copied().chain(ends).collect();
        if rigid.iter().any(|length_mm| *length_mm > 0.0) {
            for (place, length_mm) in rigid.into_iter().enumerate() {
                numbers.number(&format!("rigid part {place} mm"), length_mm);
            }
        }
        for (rib, thickness_mm) in d.ribs.thicknesses_mm.iter().flatten().enumerate() {
            numbers.number(&format!("rib {rib} thickness_mm"), *thickness_mm);
        }
        if finger.has_brackets() {
            let all = finger.description().ribs.bracket_mm.all().as_flattened();
            for (name, length_mm) in ["front", "back"].into_iter().cycle().zip(all) {
                numbers.number(&format!("{name} bracket_mm"), *length_mm);
            }
            numbers.text(match finger.description().markers_on {
                MarkerPoints::Junctions => "markers on junctions",
                MarkerPoints::Hinges => "markers on hinges",
            });
        }
        let mut zones: Vec<String> = finger
            .description()
            .zones
            .iter()
            .map(|zone| {
                let part = match zone.part {
                    Part::Front => "front",
                    Part::Back => "back",
                    Part::Ribs => "ribs",
                };
                let [from_mm, to_mm, factor] = [zone.from_mm, zone.to_mm, zone.modulus_factor].map(rounded);
                format!("zone {part} {from_mm} {to_mm} {factor}")
            })
            .collect();
        zones.sort();
        zones.iter().for_each(|zone| numbers.text(zone));
        Fingerprint(numbers.0.finalize().into())
    }
}

/// Input of the hash: one entry per line.
struct Numbers(Sha256);

impl Numbers {
    fn text(&mut self, entry: &str) {
        self.0.update(entry.as_bytes());
        self.0.update(b"\n");
    }

    fn number(&mut self, name: &str, value: f64) {
        self.text(&format!("{name} {}", rounded(value)));
    }

    fn part(&mut self, finger: &Finger, name: &str, part: Part) {
        match finger.section(part) {
            Some(section) => {
                self.number(&format!("{name} EA"), section.axial_rigidity_n);
                self.number(&format!("{name} EI"), section.bending_rigidity_nmm2);
            }
            None => self.text(&format!("{name} does not deform")),
        }
    }
}

/// Formats a number with [`DIGITS`] significant digits. Plus and minus zero have the same text.
fn rounded(value: f64) -> String {
    format!("{:.*e}", DIGITS as usize - 1, value + 0.0)
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Error for a text that is not a fingerprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected a fingerprint of 64 hexadecimal digits")]
pub struct NoFingerprint;

impl FromStr for Fingerprint {
    type Err = NoFingerprint;

    fn from_str(text: &str) -> Result<Fingerprint, NoFingerprint> {
        let digits = text.bytes().map(|byte| char::from(byte).to_digit(16)).collect::<Option<Vec<u32>>>();
        let bytes: Vec<u8> =
            digits.ok_or(NoFingerprint)?.chunks(2).map(|pair| pair.iter().fold(0, |n, d| 16 * n + *d as u8)).collect();
        if text.len() != 64 {
            return Err(NoFingerprint);
        }
        bytes.try_into().map(Fingerprint).map_err(|_| NoFingerprint)
    }
}

impl Serialize for Fingerprint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Fingerprint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Fingerprint, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}
