//! Description of a finger by the user.

pub use crate::keys::{BracketLengths, OfRibs};

use super::{Finger, Plate, SideFaces};

/// Thickness and material of a plate or of the ribs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// In-plane thickness, mm; for a tapered plate, the thickness at the base.
    pub thickness_mm: f64,
    /// Thickness at the tip of a linearly tapered plate, mm; `None` for a plate of constant thickness and for ribs.
    pub tip_thickness_mm: Option<f64>,
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
}

/// Lengths of the rigid sections at both ends of a plate, mm, zero or more.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RigidEnds {
    /// Length of the clamped section at the base, mm.
    pub base_mm: f64,
    /// Length of the section at the tip, mm. This section rotates with the tip.
    pub tip_mm: f64,
}

/// Radii of the fillets of a finger of one piece, mm; zero for sharp corners.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fillets {
    /// Corners between the front plate and ribs, and between the back plate and ribs.
    pub plates_mm: [f64; 2],
    /// Corners between plates and base. With sharp corners, the clamp holds the sections of the plates at their ends.
    pub base_mm: f64,
}

/// Type of the joints between ribs and plates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joints {
    /// The ribs are clamped to both plates.
    Rigid,
    /// The ribs are pinned to both plates.
    Hinged,
}

/// Positions of the ribs along both plates.
#[derive(Debug, Clone, PartialEq)]
pub enum RibPositions {
    /// Number of evenly spaced ribs. For i from 1 to the number of ribs, rib i lies at the fraction i / (count + 1) of the length of each plate.
    Count(usize),
    /// Position of each rib on the front and on the back plate, mm from the base; ordered from base to tip.
    Positions(Vec<[f64; 2]>),
}

/// Description of the ribs by the user.
#[derive(Debug, Clone, PartialEq)]
pub struct RibDescription {
    /// Positions along the plates.
    pub positions: RibPositions,
    /// Type of the joints between ribs and plates.
    pub joints: Joints,
    /// Lengths of the rigid brackets that join the ribs to the front and back plate, mm, zero or more. A bracket is perpendicular to the undeformed
    /// plate, points towards the other plate and rotates with its plate. The joint with the rib is at the end of the bracket.
    pub bracket_mm: BracketLengths,
    /// Lengths of the rigid clips of the brackets on front and back plate, mm, zero or more. Half of a clip lies on each side of its key node.
    pub clip_mm: [f64; 2],
    /// Thickness and modulus; `None` if the ribs are undeformable or the finger has no ribs.
    pub strip: Option<Strip>,
    /// Thickness of each rib, mm, from base to tip, if the ribs differ. These values replace the thickness of `strip`; in this case, `strip` stores
    /// the largest of the values.
    pub thicknesses_mm: Option<Vec<f64>>,
    /// Radii of the fillets in the corners of the ribs, mm, which replace those of [`Fillets::plates_mm`]; `None` if unstated.
    pub fillets_mm: Option<OfRibs<f64>>,
}

/// Positions of the markers at the ends of ribs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MarkerPoints {
    /// The marker is on the key node, on the plate's middle line.
    #[default]
    Junctions,
    /// The marker is on the joint at the end of the bracket.
    Hinges,
}

/// A part of the finger, to which a member or a zone belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The front plate.
    Front,
    /// The back plate.
    Back,
    /// The ribs. A zone of this part covers the ribs whose front ends lie in the zone.
    Ribs,
}

/// A section of a plate, or a group of ribs, with a different modulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone {
    /// The part of the finger to which the zone belongs.
    pub part: Part,
    /// Start of the zone along the plate, mm from the base; for ribs, along the front plate.
    pub from_mm: f64,
    /// End of the zone along the plate, mm from the base; for ribs, along the front plate.
    pub to_mm: f64,
    /// Factor on Young's modulus in the zone, dimensionless.
    pub modulus_factor: f64,
}

impl Zone {
    /// Whether the zone covers a rib whose front end is `position_mm` from the base. At the boundary of two zones, the zone that starts at the
    /// boundary covers the rib.
    pub fn holds_rib(&self, position_mm: f64) -> bool {
        self.part == Part::Ribs && self.from_mm <= position_mm && position_mm < self.to_mm
    }
}

/// Description of a finger by the user; [`Finger::new`](super::Finger::new) checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerDescription {
    /// Distance between the two plates at the base, mm.
    pub base_width_mm: f64,
    /// Length of the front plate, mm.
    pub front_length_mm: f64,
    /// Length of the back plate, mm.
    pub back_length_mm: f64,
    /// Depth out of the plane, mm.
    pub depth_mm: f64,
    /// Length of the rigid arms at both ends of every member, mm. The arms model the rods at the key nodes, or junctions without rods.
    pub rod_arm_mm: f64,
    /// Length of the rigid arms at both ends of every rib, mm; `None` for `rod_arm_mm`.
    pub rib_arm_mm: Option<f64>,
    /// Length of the rigid arms of plates and ribs at clamped nodes, mm; `None` for the arm of the member's other nodes.
    pub clamp_arm_mm: Option<f64>,
    /// Fillets of a finger of one piece. The arms then follow from the fillets, and the other arms must be zero. `None` if the finger is not one piece
    /// or its arms are stated.
    pub fillets: Option<Fillets>,
    /// Poisson's ratio, dimensionless. The effective modulus is E / (1 - nu^2) (plane strain), and smaller with free side faces.
    pub poissons_ratio: f64,
    /// State of the side faces, which are parallel to the plane of the finger frame; `None` if unstated, which computes like [`SideFaces::Fixed`].
    pub side_faces: Option<SideFaces>,
    /// Shear correction factor kappa of plates and ribs, dimensionless: the shear rigidity is kappa G A. Zero for members without shear deformation.
    pub shear_correction: f64,
    /// The front plate.
    pub front: Strip,
    /// The back plate.
    pub back: Strip,
    /// Rigid ends of the front and the back plate.
    pub rigid_ends: [RigidEnds; 2],
    /// The ribs.
    pub ribs: RibDescription,
    /// Zones with different moduli. The factors of overlapping zones multiply.
    pub zones: Vec<Zone>,
    /// Position of the markers at the ends of ribs.
    pub markers_on: MarkerPoints,
}

impl FingerDescription {
    /// Multiplies all moduli by a dimensionless factor.
    pub(crate) fn multiply_moduli(&mut self, factor: f64) {
        let plates = [&mut self.front, &mut self.back];
        plates.into_iter().chain(&mut self.ribs.strip).for_each(|strip| strip.youngs_modulus_mpa *= factor);
    }

    /// Multiplies all thicknesses of a part by a dimensionless factor. The middle lines stay.
    pub(crate) fn multiply_thickness(&mut self, part: Part, factor: f64) {
        let strip = match part {
            Part::Front => Some(&mut self.front),
            Part::Back => Some(&mut self.back),
            Part::Ribs => self.ribs.strip.as_mut(),
        };
        if let Some(strip) = strip {
            strip.thickness_mm *= factor;
            strip.tip_thickness_mm.iter_mut().for_each(|thickness_mm| *thickness_mm *= factor);
        }
        if part == Part::Ribs {
            self.ribs.thicknesses_mm.iter_mut().flatten().for_each(|thickness_mm| *thickness_mm *= factor);
        }
    }

    /// Moves one end of a rib by `by_mm` along a plate, away from the base; `rib` is the number of the rib, from 0. `finger` must be the finger with
    /// this description.
    pub(crate) fn move_rib(&mut self, finger: &Finger, plate: Plate, rib: usize, by_mm: f64) {
        if let RibPositions::Count(_) = self.ribs.positions {
            let [front_mm, back_mm] = [Plate::Front, Plate::Back].map(|plate| finger.plate_positions_mm(plate));
            let all = (1..=finger.rib_count()).map(|rib| [front_mm[rib], back_mm[rib]]);
            self.ribs.positions = RibPositions::Positions(all.collect());
        }
        if let RibPositions::Positions(positions) = &mut self.ribs.positions {
            positions[rib][plate.index()] += by_mm;
        }
    }

    /// Lengthens the bracket of a rib on one plate by `by_mm`. `rib` counts from 0; `rib_count` is the number of ribs.
    pub(crate) fn lengthen_bracket(&mut self, rib_count: usize, plate: Plate, rib: usize, by_mm: f64) {
        let mut each: Vec<[f64; 2]> = (0..rib_count).map(|rib| self.ribs.bracket_mm.of(rib)).collect();
        each[rib][plate.index()] += by_mm;
        self.ribs.bracket_mm = BracketLengths::Each(each);
    }
}

/// Error for a description that is not a valid finger.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key}: {reason}")]
pub struct ImpossibleFinger {
    /// Key in the scene file, for instance `finger.ribs.positions_mm`.
    pub key: String,
    /// Expected and found value, in words.
    pub reason: String,
}
