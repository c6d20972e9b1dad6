//! Rigidities of plates and ribs whose side faces are free.

use super::sections::SectionFactors;
use super::{Finger, Part, Plate};

/// State of the two faces of the finger that are parallel to the plane of the finger frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SideFaces {
    /// Plane strain: no section contracts or bends along the depth. Holds for a depth much larger than all lengths, and between rigid walls.
    #[default]
    Fixed,
    /// No stress acts on the side faces. From the faces inwards, sections contract and bend along the depth (anticlastic bending), up to the distance
    /// at which plates and ribs at both ends of the member prevent it.
    Free,
}

/// Width of the layers at both side faces together, as multiples of the free length and of the thickness of a member, dimensionless.
struct Layers {
    bending_by_length: f64,
    bending_by_thickness: f64,
    stretching_by_length: f64,
}

// Fitted to the compliance of the 96 random fingers in `fixtures/depth/fit.py`. For a strip between lines that prevent anticlastic bending,
// theory of thin plates gives 0.17 (sway) to 0.34 (constant curvature) of the length at a Poisson's ratio of 0.45, and tension gives 1.0.
/// Layers of members between junctions with rods, which prevent anticlastic bending at the member's ends.
const WITH_RODS: Layers = Layers { bending_by_length: 0.15, bending_by_thickness: 1.65, stretching_by_length: 1.0 };
/// Layers of members between junctions of one piece. Plates contract through such junctions.
const WITHOUT_RODS: Layers = Layers { bending_by_length: 0.19, bending_by_thickness: 1.5, stretching_by_length: 3.4 };

/// Smallest `rod_arm_mm` of a finger with rods, in mean thicknesses of the plates. By the rule for arms, a rod that fills the junction of plates has an
/// arm of 0.44 thicknesses, and a junction without rod has less than 0.25 thicknesses.
const ROD_ARM: f64 = 0.4;

/// Root mean square error of the compliance with free side faces, relative, on the 84 random fingers without rods in `fixtures/depth/fingers.csv`, rounded
/// up. On the 66 fingers with rods, the error is 0.0031. No constant was fitted to these fingers.
pub const SIDE_FACE_ERROR: f64 = 0.005;

/// Value of (1 - nu) (3 + nu) at the Poisson's ratio 0.45, to which [`Layers`] refers. At a free edge of a thin plate whose curvature varies as cos(kx),
/// the layer of anticlastic bending is 2 / ((1 - nu) (3 + nu) k) wide (Kirchhoff plate with free edge; Timoshenko and Woinowsky-Krieger, Theory of
/// Plates and Shells, 1959, ch. 6).
const REFERENCE: f64 = 0.55 * 3.45;

impl Finger {
    /// Relative standard deviation of a sensed force due to the error of [`SideFaces::Free`], dimensionless; zero for [`SideFaces::Fixed`].
    pub fn side_face_error(&self) -> f64 {
        match self.description.side_faces {
            None | Some(SideFaces::Fixed) => 0.0,
            Some(SideFaces::Free) => SIDE_FACE_ERROR,
        }
    }

    /// Whether rods are in the junctions. Only the stated arms show it.
    pub(super) fn has_rods(&self) -> bool {
        let d = &self.description;
        d.rod_arm_mm >= ROD_ARM * 0.5 * (d.front.thickness_mm + d.back.thickness_mm)
    }

    /// Ratios of the rigidities to those in plane strain, between 1 - nu^2 and 1, of a plate's member, numbered from 0 at the base, or a rib.
    pub(super) fn side_face_factors(&self, part: Part, member: usize) -> SectionFactors {
        let d = &self.description;
        if d.side_faces != Some(SideFaces::Free) {
            return SectionFactors::NONE;
        }
        let (length_mm, arms_mm, thickness_mm) = match part {
            Part::Ribs => (self.rib_length_mm(member), self.rib_arms_mm(member), self.rib_thickness_mm(member)),
            Part::Front | Part::Back => {
                let plate = if part == Part::Front { Plate::Front } else { Plate::Back };
                let [from_mm, to_mm] = [member, member + 1].map(|level| self.level_mm(plate, level));
                let thickness_mm = self.thickness_mm(plate, 0.5 * (from_mm + to_mm));
                (to_mm - from_mm, self.member_arms_mm(plate, member), thickness_mm)
            }
        };
        let layers = if self.has_rods() { WITH_RODS } else { WITHOUT_RODS };
        let nu = d.poissons_ratio;
        let free_mm = (length_mm - arms_mm[0] - arms_mm[1]) * REFERENCE / ((1.0 - nu) * (3.0 + nu));
        let thick_mm = thickness_mm * REFERENCE / ((1.0 - nu) * (3.0 + nu));
        let factor = |width_mm: f64| 1.0 - nu * nu * free_share(d.depth_mm / width_mm);
        SectionFactors {
            bending: factor(layers.bending_by_length * free_mm + layers.bending_by_thickness * thick_mm),
            stretching: factor(layers.stretching_by_length * free_mm),
        }
    }
}

/// Share of the depth on which side faces are effectively free, given the depth as a multiple of the layers' width: 1 for a small depth, 1 / `depth` for
/// a large one. Two layers that decay exponentially from both faces have this share.
fn free_share(depth: f64) -> f64 {
    if depth > 0.0 { depth.tanh() / depth } else { 1.0 }
}
