//! A finger as the user describes it.

pub use crate::keys::{BracketLengths, OfRibs};

use super::{Finger, Plate};

/// A plate or a rib as a material strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// Thickness in the plane, mm; of a plate that tapers, at the base.
    pub thickness_mm: f64,
    /// Thickness at the tip of a plate that tapers linearly, mm; `None` for ribs.
    pub tip_thickness_mm: Option<f64>,
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
}

/// Lengths at the ends of a plate that do not deform, mm, zero or more.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RigidEnds {
    /// Next to the base: it is clamped as a whole.
    pub base_mm: f64,
    /// Next to the tip: it turns with it.
    pub tip_mm: f64,
}

/// How ribs meet the plates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joints {
    /// Clamped to both plates.
    Rigid,
    /// Pinned at both ends.
    Hinged,
}

/// Where the ribs are.
#[derive(Debug, Clone, PartialEq)]
pub enum RibPositions {
    /// This number of ribs, rib i at i / (count + 1) of both plates.
    Count(usize),
    /// Distances from the base along the front and the back plate, mm, from base to tip.
    Positions(Vec<[f64; 2]>),
}

/// The ribs as the user describes them.
#[derive(Debug, Clone, PartialEq)]
pub struct RibDescription {
    /// Their positions.
    pub positions: RibPositions,
    /// Their joints with the plates.
    pub joints: Joints,
    /// Lengths of the rigid brackets that hold their ends off the front and the back plate, mm, zero or more: perpendicular to
    /// the undeformed plate, towards the other one, turning with the plate. Joints are at their ends.
    pub bracket_mm: BracketLengths,
    /// Lengths of the rigid clips that hold the brackets on front and back plate, mm, zero or more: half on each side of the node.
    pub clip_mm: [f64; 2],
    /// Their material; `None` for ribs that do not deform (or if there are none).
    pub strip: Option<Strip>,
    /// Thickness of each rib, mm, from base to tip, where they differ: it counts instead of the strip's, which is the largest of them.
    pub thicknesses_mm: Option<Vec<f64>>,
}

/// Which point of a rib's end a camera sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MarkerPoints {
    /// The key node, on the plate's middle line.
    #[default]
    Junctions,
    /// The joint at the end of the bracket.
    Hinges,
}

/// Which part of the finger a zone belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The front plate.
    Front,
    /// The back plate.
    Back,
    /// The ribs whose front end lies in the zone.
    Ribs,
}

/// A section of other modulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone {
    /// The part it belongs to.
    pub part: Part,
    /// Where it begins, mm from the base along the plate (for ribs: the front plate).
    pub from_mm: f64,
    /// Where it ends, mm.
    pub to_mm: f64,
    /// Factor on Young's modulus.
    pub modulus_factor: f64,
}

impl Zone {
    /// Whether it covers a rib with its front end at a position; on a border the zone that begins there does.
    pub fn holds_rib(&self, position_mm: f64) -> bool {
        self.part == Part::Ribs && self.from_mm <= position_mm && position_mm < self.to_mm
    }
}

/// A finger as the user describes it; [`Finger::new`](super::Finger::new) checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerDescription {
    /// Distance between the two plates at the base, mm.
    pub base_width_mm: f64,
    /// Length of the front plate, mm.
    pub front_length_mm: f64,
    /// Length of the back plate, mm.
    pub back_length_mm: f64,
    /// Out of plane, mm.
    pub depth_mm: f64,
    /// Length of the rigid arms at both ends of every member, mm.
    pub rod_arm_mm: f64,
    /// Poisson's ratio of the strips, wide against their thickness: they have the modulus E / (1 - nu^2).
    pub poissons_ratio: f64,
    /// The front plate.
    pub front: Strip,
    /// The back plate.
    pub back: Strip,
    /// What does not deform of the front and of the back plate.
    pub rigid_ends: [RigidEnds; 2],
    /// The ribs.
    pub ribs: RibDescription,
    /// Sections of other modulus; overlapping ones multiply.
    pub zones: Vec<Zone>,
    /// Where the markers of the ribs' ends are.
    pub markers_on: MarkerPoints,
}

impl FingerDescription {
    /// Moves the end of a rib, counted from 0, along a plate away from the base; `finger` is the one that is described.
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

    /// Lengthens the bracket of one of so many ribs, counted from 0, on a plate.
    pub(crate) fn lengthen_bracket(&mut self, rib_count: usize, plate: Plate, rib: usize, by_mm: f64) {
        let mut each: Vec<[f64; 2]> = (0..rib_count).map(|rib| self.ribs.bracket_mm.of(rib)).collect();
        each[rib][plate.index()] += by_mm;
        self.ribs.bracket_mm = BracketLengths::Each(each);
    }
}

/// A finger that cannot be: which key of the scene is wrong, and why.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key}: {reason}")]
pub struct ImpossibleFinger {
    /// Key as in the scene file, for instance `finger.ribs.positions_mm`.
    pub key: String,
    /// What was expected and what was found.
    pub reason: String,
}
