//! Effect of zones of other modulus on the elements.

use super::Mesh;
use crate::finger::{Part, Plate, Zone};

/// Where the elements of a plate member begin and end, mm from the base.
pub(super) struct ElementPositions {
    free: [f64; 2],
    elements: usize,
}

impl ElementPositions {
    /// Equal elements between the rigid arms of a member.
    pub(super) fn new(positions: [f64; 2], arms_mm: [f64; 2], elements: usize) -> ElementPositions {
        ElementPositions { free: [positions[0] + arms_mm[0], positions[1] - arms_mm[1]], elements }
    }

    /// Where the elastic part begins and ends.
    pub(super) fn free(&self) -> [f64; 2] {
        self.free
    }

    /// Where element `i` begins. The last one ends where the member does, not rounded: a load at the tip must find it.
    pub(super) fn start(&self, i: usize) -> f64 {
        let [from, to] = self.free;
        if i == self.elements { to } else { from + (to - from) * i as f64 / self.elements as f64 }
    }
}

/// Length-weighted mean of 1 / (product of the zones' factors) over a section of plate.
pub(super) fn mean_compliance(zones: &[Zone], from_mm: f64, to_mm: f64) -> f64 {
    compliance(zones, from_mm, to_mm, |_| true) / (to_mm - from_mm)
}

/// Sum of length / (product of the zones' factors) over the parts of a section whose middle is `counted`.
fn compliance(zones: &[Zone], from_mm: f64, to_mm: f64, counted: impl Fn(f64) -> bool) -> f64 {
    let mut cuts: Vec<f64> = zones
        .iter()
        .flat_map(|zone| [zone.from_mm, zone.to_mm])
        .filter(|cut| *cut > from_mm && *cut < to_mm)
        .chain([from_mm, to_mm])
        .collect();
    cuts.sort_by(f64::total_cmp);
    let parts = cuts.windows(2).map(|w| (w[1] - w[0], 0.5 * (w[0] + w[1])));
    let lengths = parts.filter(|&(_, middle)| counted(middle)).map(|(length, middle)| {
        let factor: f64 = zones.iter().filter(|zone| covers(zone, middle)).map(|zone| zone.modulus_factor).product();
        length / factor
    });
    lengths.sum()
}

fn covers(zone: &Zone, position_mm: f64) -> bool {
    zone.from_mm <= position_mm && position_mm <= zone.to_mm
}

impl Mesh {
    /// How far the stiffness of the members follows the factor of one of the finger's zones (counted from 0):
    /// d ln(stiffness) / d ln(factor) of each member that the zone touches, which is the zone's share of its compliance.
    pub fn zone_shares(&self, zone: usize) -> Vec<(usize, f64)> {
        let description = self.finger.description();
        let Some(chosen) = description.zones.get(zone) else { return Vec::new() };
        let of_part: Vec<Zone> = description.zones.iter().filter(|other| other.part == chosen.part).copied().collect();
        let plate = if chosen.part == Part::Back { Plate::Back } else { Plate::Front };
        let positions = self.finger.plate_positions_mm(plate);
        let lines = self.lines.iter().filter(|line| line.part == chosen.part).enumerate();
        let shares = lines.flat_map(|(nth, line)| {
            // Ribs have no positions along a plate; their share does not need them.
            let arms_mm = if chosen.part == Part::Ribs { [0.0; 2] } else { self.finger.member_arms_mm(plate, nth) };
            let elements = ElementPositions::new([positions[nth], positions[nth + 1]], arms_mm, line.members.len());
            let share = |i: usize| match chosen.part {
                Part::Ribs => f64::from(u8::from(chosen.holds_rib(positions[nth + 1]))),
                Part::Front | Part::Back => {
                    let (from_mm, to_mm) = (elements.start(i), elements.start(i + 1));
                    compliance(&of_part, from_mm, to_mm, |middle| covers(chosen, middle))
                        / compliance(&of_part, from_mm, to_mm, |_| true)
                }
            };
            line.members.clone().enumerate().map(|(i, member)| (member, share(i))).collect::<Vec<_>>()
        });
        shares.filter(|(_, share)| *share > 0.0).collect()
    }
}
