//! Error of beam theory by kind of finger.

use super::{Finger, Plate, percent};
use std::fmt;

/// Cosine of the angle between rib and plate below which ribs are inclined: 35 degrees.
const INCLINED: f64 = 0.819_152;

/// Kinds of fingers whose beams err differently from solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FingerKind {
    /// Beams whose scene describes no solid, because Poisson's ratio, shear or arms are missing.
    Beams,
    /// Stated arms, with rods in the junctions.
    Rods,
    /// Stated arms, without rods; all ribs at 35 degrees or more from the plates.
    StatedArms,
    /// Stated arms, without rods, with ribs at less than 35 degrees from a plate.
    StatedArmsInclined,
    /// One piece, sharp at the base; all ribs at 35 degrees or more from the plates.
    OnePiece,
    /// One piece with fillets at the base; all ribs at 35 degrees or more from the plates.
    FilletedBase,
    /// One piece with fillets that meet on a rib.
    MeetingFillets,
    /// One piece with a rib near the base: the plate's first member is shorter than three thicknesses or, with inclined ribs, free of corners and
    /// fillets over less than two thicknesses.
    RibNearBase,
    /// One piece with ribs at less than 35 degrees from a plate.
    InclinedRibs,
    /// One piece with ribs that share junctions, and sharp corners.
    ZigzagRibs,
    /// One piece with ribs that share junctions, and fillets.
    FilletedZigzag,
}

impl FingerKind {
    /// Relative standard deviation of a sensed force due to the errors of beam theory, dimensionless: root mean square errors on 400 random solids
    /// with the present or an earlier rule, rounded up. 200 others judge them (`fixtures/solids/README.md`). Zero for [`FingerKind::Beams`], which describe no solid.
    pub const fn model_error(self) -> f64 {
        match self {
            FingerKind::Beams => 0.0,
            FingerKind::Rods => 0.006,
            FingerKind::StatedArms => 0.0085,
            FingerKind::StatedArmsInclined => 0.033,
            FingerKind::OnePiece => 0.0085,
            FingerKind::FilletedBase => 0.011,
            FingerKind::MeetingFillets => 0.0135,
            FingerKind::RibNearBase => 0.05,
            FingerKind::InclinedRibs => 0.016,
            FingerKind::ZigzagRibs => 0.011,
            FingerKind::FilletedZigzag => 0.015,
        }
    }

    /// Errors of a force whose direction is estimated, beyond those of a known direction: relative standard deviation of the force, dimensionless, and
    /// standard deviation of the direction, degrees; first near the base, then elsewhere. A force along the plate moves the markers by hundredths of
    /// what a force across it does, and near the base these small motions depend on how plate, base and first rib join. Chosen from 360 random
    /// solids, judged on 200 others (`fixtures/solids/README.md`). Zero for beams, and for rods, whose junctions are stiff.
    const fn unknown_direction(self) -> [[f64; 2]; 2] {
        match self {
            FingerKind::Beams | FingerKind::Rods => [[0.0; 2]; 2],
            FingerKind::StatedArms | FingerKind::StatedArmsInclined => [[0.05, 6.5], [0.01, 1.2]],
            _ => [[0.025, 3.5], [0.01, 1.2]],
        }
    }

    /// Whether the beams describe a solid.
    pub(super) fn is_solid(self) -> bool {
        self != FingerKind::Beams
    }
}

impl fmt::Display for FingerKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FingerKind::Beams => "beams without Poisson's ratio, shear or arms",
            FingerKind::Rods => "fingers with rods",
            FingerKind::StatedArms => "fingers with stated arms, without rods",
            FingerKind::StatedArmsInclined => "fingers with stated arms and inclined ribs, without rods",
            FingerKind::OnePiece => "fingers of one piece",
            FingerKind::FilletedBase => "fingers of one piece with fillets at the base",
            FingerKind::MeetingFillets => "fingers of one piece with fillets that meet on a rib",
            FingerKind::RibNearBase => "fingers of one piece with a rib near the base",
            FingerKind::InclinedRibs => "fingers of one piece with inclined ribs",
            FingerKind::ZigzagRibs => "fingers of one piece with zigzag ribs and sharp corners",
            FingerKind::FilletedZigzag => "fingers of one piece with zigzag ribs and fillets",
        })
    }
}

/// Relative standard deviation of a sensed force due to the errors of the finger's model, with its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelError {
    /// Value that the scene states for beam theory, dimensionless; `None` for the default of the kind.
    pub stated: Option<f64>,
    /// Kind of the finger.
    pub kind: FingerKind,
    /// Error of the model of free side faces, dimensionless.
    pub side_faces: f64,
}

impl ModelError {
    /// The error of a finger, given the value that its scene states.
    pub fn of(finger: &Finger, stated: Option<f64>) -> ModelError {
        ModelError { stated, kind: finger.kind(), side_faces: finger.side_face_error() }
    }

    /// Errors of a force whose direction is estimated, in addition to the others: relative standard deviation of the force, dimensionless, and standard
    /// deviation of the direction, degrees; first near the base, then elsewhere. They scale with the value that the scene states. `None` without
    /// such errors.
    pub(crate) fn unknown_direction(&self) -> Option<[[f64; 2]; 2]> {
        let usual = self.kind.model_error();
        let scaled = |error| error * self.stated.unwrap_or(usual) / usual;
        let errors = self.kind.unknown_direction().map(|errors| errors.map(scaled));
        (errors[0][0] > 0.0).then_some(errors)
    }

    /// Relative standard deviation of a sensed force, dimensionless.
    pub fn share(&self) -> f64 {
        self.stated.unwrap_or(self.kind.model_error()).hypot(self.side_faces)
    }
}

/// The value and its origin in words, for instance "0.64 % (stated: 0.4 %; free side faces: 0.5 %)".
impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} % (", percent(self.share()))?;
        match self.stated {
            Some(stated) => write!(f, "stated: {} %", percent(stated))?,
            None => write!(f, "{}: {} %", self.kind, percent(self.kind.model_error()))?,
        }
        if self.side_faces > 0.0 {
            write!(f, "; free side faces: {} %", percent(self.side_faces))?;
        }
        f.write_str(")")
    }
}

impl Finger {
    /// The kind of this finger.
    pub fn kind(&self) -> FingerKind {
        let d = self.description();
        let has_arms = d.rod_arm_mm > 0.0 || d.rib_arm_mm.is_some_and(|arm_mm| arm_mm > 0.0);
        match &self.one_piece {
            Some(one_piece) => one_piece.kind,
            None if !has_arms || d.shear_correction == 0.0 || d.poissons_ratio == 0.0 => FingerKind::Beams,
            None if self.has_rods() => FingerKind::Rods,
            None if self.has_inclined_ribs() && !self.has_shared_junctions() => FingerKind::StatedArmsInclined,
            None => FingerKind::StatedArms,
        }
    }

    /// Whether a rib and a plate form an angle below 35 degrees.
    pub(super) fn has_inclined_ribs(&self) -> bool {
        let tangents = [Plate::Front, Plate::Back].map(|plate| self.tangent(plate));
        (0..self.rib_count()).any(|rib| {
            let [front, back] = self.rib_nodes(rib).map(|node| self.hinge(node));
            tangents.iter().any(|tangent| (front - back).normalize().dot(tangent).abs() > INCLINED)
        })
    }
}
