//! Cross-sections of elements in tapered plates and in zones with a different modulus.

use super::Mesh;
use crate::finger::{Finger, Part, Plate, Zone};
use crate::frame::Section;

/// Start of element `i` (counted from 0), mm from the base. The elastic part of a plate member starts at `from`, ends at `to` (both mm from the base)
/// and has `elements` equal elements. If `i` is the number of elements, returns `to` without rounding, so that a load at the tip lies on the plate.
pub(super) fn element_start([from, to]: [f64; 2], elements: usize, i: usize) -> f64 {
    if i == elements { to } else { from + (to - from) * i as f64 / elements as f64 }
}

impl Finger {
    /// Section with the mean compliances of a segment of a plate member, including the effects of zones and side faces. The mean shear compliance and the mean axial compliance,
    /// relative to the base section, are equal, because both rigidities are proportional to modulus times thickness.
    pub(super) fn plate_section(&self, plate: Plate, member: usize, from_mm: f64, to_mm: f64) -> Section {
        let d = self.description();
        let zones: Vec<Zone> = d.zones.iter().filter(|zone| zone.part == Part::from(plate)).copied().collect();
        let of_base = self.member_section(plate, member);
        let mean = |relative: &dyn Fn(f64, f64) -> f64| {
            compliance(&zones, from_mm, to_mm, relative, |_| true) / (to_mm - from_mm)
        };
        Section {
            axial_rigidity_n: of_base.axial_rigidity_n * (1.0 / mean(&|from, to| self.stretching(plate, from, to))),
            bending_rigidity_nmm2: of_base.bending_rigidity_nmm2
                * (1.0 / mean(&|from, to| self.bending(plate, from, to))),
            ..of_base
        }
    }

    /// Mean of t_0 / t over a plate segment, dimensionless: t_0 ln(b / a) / (b - a) for a thickness t that varies linearly from a to b. t_0 is the thickness
    /// at the base.
    fn stretching(&self, plate: Plate, from_mm: f64, to_mm: f64) -> f64 {
        let [base_mm, a, b] = self.thicknesses_mm(plate, from_mm, to_mm);
        let growth = (b - a) / a;
        base_mm / a * if growth == 0.0 { 1.0 } else { growth.ln_1p() / growth }
    }

    /// Mean of (t_0 / t)^3 over a plate segment, dimensionless: (a + b) / (2 a^2 b^2) for t / t_0 that varies linearly from a to b.
    fn bending(&self, plate: Plate, from_mm: f64, to_mm: f64) -> f64 {
        let [base_mm, a, b] = self.thicknesses_mm(plate, from_mm, to_mm);
        let (a, b) = (a / base_mm, b / base_mm);
        (a + b) / (2.0 * a * a * b * b)
    }

    fn thicknesses_mm(&self, plate: Plate, from_mm: f64, to_mm: f64) -> [f64; 3] {
        [0.0, from_mm, to_mm].map(|s_mm| self.thickness_mm(plate, s_mm))
    }
}

/// Integral of the compliance, relative to the base section, over the length of a plate segment, mm. `relative` returns the mean relative compliance
/// between two positions, without the effect of zones. This mean is divided by the product of the modulus factors of the zones. Ends of zones divide
/// the segment into parts. Only parts with a midpoint that satisfies `counted` contribute.
fn compliance(
    zones: &[Zone],
    from_mm: f64,
    to_mm: f64,
    relative: impl Fn(f64, f64) -> f64,
    counted: impl Fn(f64) -> bool,
) -> f64 {
    let mut cuts: Vec<f64> = zones
        .iter()
        .flat_map(|zone| [zone.from_mm, zone.to_mm])
        .filter(|cut| *cut > from_mm && *cut < to_mm)
        .chain([from_mm, to_mm])
        .collect();
    cuts.sort_by(f64::total_cmp);
    let parts = cuts.windows(2).map(|w| (w[0], w[1], 0.5 * (w[0] + w[1])));
    let lengths = parts.filter(|&(.., middle)| counted(middle)).map(|(from, to, middle)| {
        let factor: f64 = zones.iter().filter(|zone| covers(zone, middle)).map(|zone| zone.modulus_factor).product();
        (to - from) * relative(from, to) / factor
    });
    lengths.sum()
}

fn covers(zone: &Zone, position_mm: f64) -> bool {
    zone.from_mm <= position_mm && position_mm <= zone.to_mm
}

impl Mesh {
    /// Sensitivity of the frame members' stiffness to the modulus factor of a zone; zones are numbered from 0. Returns pairs of a member's index and
    /// its sensitivity d ln(stiffness) / d ln(factor), 0..1. The sensitivity equals the zone's share of the member's compliance. In a tapered plate,
    /// it is the share of the bending compliance. Members outside the zone are omitted.
    pub fn zone_shares(&self, zone: usize) -> Vec<(usize, f64)> {
        let description = self.finger.description();
        let Some(chosen) = description.zones.get(zone) else { return Vec::new() };
        let of_part: Vec<Zone> = description.zones.iter().filter(|other| other.part == chosen.part).copied().collect();
        let plate = if chosen.part == Part::Back { Plate::Back } else { Plate::Front };
        let positions = self.finger.plate_positions_mm(plate);
        let lines = self.lines.iter().filter(|line| line.part == chosen.part).enumerate();
        let shares = lines.flat_map(|(nth, line)| {
            // The share for a rib does not depend on the rigid arms along a plate, so these arms are set to zero.
            let arms_mm = if chosen.part == Part::Ribs { [0.0; 2] } else { self.finger.member_arms_mm(plate, nth) };
            let free = [positions[nth] + arms_mm[0], positions[nth + 1] - arms_mm[1]];
            let share = |i: usize| match chosen.part {
                Part::Ribs => f64::from(u8::from(chosen.holds_rib(positions[nth + 1]))),
                Part::Front | Part::Back => {
                    let [from_mm, to_mm] = [i, i + 1].map(|i| element_start(free, line.members.len(), i));
                    let relative = |from, to| self.finger.bending(plate, from, to);
                    compliance(&of_part, from_mm, to_mm, relative, |middle| covers(chosen, middle))
                        / compliance(&of_part, from_mm, to_mm, relative, |_| true)
                }
            };
            line.members.clone().enumerate().map(|(i, member)| (member, share(i))).collect::<Vec<_>>()
        });
        shares.filter(|(_, share)| *share > 0.0).collect()
    }
}
