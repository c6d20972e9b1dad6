//! Cross-sections of a finger's plates and ribs.

use super::{Finger, FingerDescription, Part, Plate, Strip};
use crate::frame::Section;

/// Ratios of a member's rigidities to those of its section in plane strain, dimensionless.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SectionFactors {
    pub(crate) bending: f64,
    pub(crate) stretching: f64,
}

impl SectionFactors {
    pub(super) const NONE: SectionFactors = SectionFactors { bending: 1.0, stretching: 1.0 };

    /// The section with these ratios. The shear rigidity stays.
    fn apply(self, section: Section) -> Section {
        Section {
            axial_rigidity_n: section.axial_rigidity_n * self.stretching,
            bending_rigidity_nmm2: section.bending_rigidity_nmm2 * self.bending,
            shear_flexibility: section.shear_flexibility * self.stretching,
            ..section
        }
    }
}

impl Finger {
    /// Factors of free side faces and of the junctions of a finger of one piece, for a plate's member, numbered from 0 at the base, or a rib.
    pub(crate) fn section_factors(&self, part: Part, member: usize) -> SectionFactors {
        let faces = self.side_face_factors(part, member);
        let stretching = self.one_piece_member(part, member).map_or(1.0, |member| member.stretching);
        SectionFactors { stretching: faces.stretching * stretching, ..faces }
    }

    /// Whether the thickness of a plate differs between base and tip.
    pub fn tapers(&self, part: Plate) -> bool {
        let strip = self.strip(part);
        strip.tip_thickness_mm.is_some_and(|tip_mm| tip_mm != strip.thickness_mm)
    }

    /// Thickness of a plate at the distance `s_mm` from its base, mm.
    pub fn thickness_mm(&self, part: Plate, s_mm: f64) -> f64 {
        let Strip { thickness_mm, tip_thickness_mm, .. } = *self.strip(part);
        let more_mm = tip_thickness_mm.map_or(0.0, |tip_mm| tip_mm - thickness_mm);
        thickness_mm + more_mm * (s_mm / self.plate_length_mm(part))
    }

    /// Thickness of a rib, mm; ribs are numbered from 0 at the base. Zero for undeformable ribs.
    pub(crate) fn rib_thickness_mm(&self, rib: usize) -> f64 {
        let ribs = &self.description.ribs;
        let alike_mm = ribs.strip.map_or(0.0, |strip| strip.thickness_mm);
        ribs.thicknesses_mm.as_ref().map_or(alike_mm, |each_mm| each_mm[rib])
    }

    fn strip(&self, part: Plate) -> &Strip {
        match part {
            Plate::Front => &self.description.front,
            Plate::Back => &self.description.back,
        }
    }

    /// Section of a part, ignoring zones, free side faces and junctions, with the plane-strain modulus E / (1 - nu^2). For a plate, this is the section at its base; for ribs, the
    /// section of the thickest rib. `None` for undeformable ribs.
    pub fn section(&self, part: Part) -> Option<Section> {
        match part {
            Part::Front => Some(self.section_of(&self.description.front)),
            Part::Back => Some(self.section_of(&self.description.back)),
            Part::Ribs => self.description.ribs.strip.as_ref().map(|strip| self.section_of(strip)),
        }
    }

    /// Section of a plate with the thickness at its base, ignoring zones, with the factors of a member; members are numbered from 0 at the base.
    pub fn member_section(&self, plate: Plate, member: usize) -> Section {
        let axis_mm = self.one_piece_member(plate.into(), member).map_or([0.0; 2], |member| member.axis_mm);
        Section { axis_mm, ..self.section_factors(plate.into(), member).apply(self.section_of(self.strip(plate))) }
    }

    fn section_of(&self, strip: &Strip) -> Section {
        let modulus =
            strip.youngs_modulus_mpa / (1.0 - self.description.poissons_ratio * self.description.poissons_ratio);
        let section = Section::rectangle(strip.thickness_mm, self.description.depth_mm, modulus);
        Section { shear_flexibility: self.shear_flexibility(), ..section }
    }

    /// Ratio of axial to shear rigidity of all sections, dimensionless. The axial rigidity is E A / (1 - nu^2) and the shear rigidity kappa G A, with
    /// G = E / (2 (1 + nu)), so the ratio is 2 / (kappa (1 - nu)). Zero without shear deformation.
    pub(crate) fn shear_flexibility(&self) -> f64 {
        let FingerDescription { shear_correction, poissons_ratio, .. } = self.description;
        if shear_correction > 0.0 { 2.0 / (shear_correction * (1.0 - poissons_ratio)) } else { 0.0 }
    }

    /// Section of a rib, including the effects of zones, side faces and junctions; ribs are numbered from 0 at the base. `None` for undeformable ribs.
    pub fn rib_section(&self, rib: usize) -> Option<Section> {
        let d = &self.description;
        let strip = Strip { thickness_mm: self.rib_thickness_mm(rib), ..d.ribs.strip? };
        let zones = d.zones.iter().filter(|zone| zone.holds_rib(self.ribs[rib][0]));
        let factor: f64 = zones.map(|zone| zone.modulus_factor).product();
        Some(self.section_factors(Part::Ribs, rib).apply(self.section_of(&strip)).scaled(factor))
    }
}
