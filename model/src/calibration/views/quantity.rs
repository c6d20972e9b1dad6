//! Quantities of a scene that several views can calibrate.

use crate::finger::{FingerDescription, Plate, RibPositions};
use std::fmt;

/// A quantity that a scene states and that several views can determine more accurately.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Factor on all moduli, dimensionless.
    Modulus,
    /// Factor on the modulus of a plate, dimensionless.
    PlateModulus(Plate),
    /// Length of the brackets on a plate, mm.
    Bracket(Plate),
    /// Additional length of one rib's bracket on a plate beyond the scene's length, mm. Ribs count from 0.
    OwnBracket(Plate, usize),
    /// Length of the clips on both plates, mm.
    Clip,
    /// Length of the clips on a plate, mm.
    PlateClip(Plate),
    /// Position of a rib along a plate, mm. Ribs count from 0.
    RibPosition(Plate, usize),
    /// Height of the markers above the plane of the beams, mm.
    MarkerHeight,
    /// x coordinate of the finger frame's origin in the frame of each view, mm.
    BaseX,
    /// y coordinate of the finger frame's origin in the frame of each view, mm.
    BaseY,
    /// Rotation of the finger frame in the frame of each view, degrees.
    BaseTurn,
    /// Moment that the plates of the unloaded finger exert on each other at the tip, N mm.
    Preload,
    /// Deviation of the lean of a sliding force (angle between force and normal) from the scene's mean lean, degrees, common to all forces that were not
    /// measured, because one object has one coefficient of friction.
    Lean,
}

/// Name in results: `modulus_factor`, `front_bracket_mm`, `back_rib_3_mm`.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |plate: &Plate| if *plate == Plate::Front { "front" } else { "back" };
        match self {
            Quantity::Modulus => f.write_str("modulus_factor"),
            Quantity::PlateModulus(plate) => write!(f, "{}_modulus_factor", name(plate)),
            Quantity::Bracket(plate) => write!(f, "{}_bracket_mm", name(plate)),
            Quantity::OwnBracket(plate, rib) => write!(f, "{}_rib_{}_bracket_more_mm", name(plate), rib + 1),
            Quantity::Clip => f.write_str("clip_mm"),
            Quantity::PlateClip(plate) => write!(f, "{}_clip_mm", name(plate)),
            Quantity::RibPosition(plate, rib) => write!(f, "{}_rib_{}_mm", name(plate), rib + 1),
            Quantity::MarkerHeight => f.write_str("marker_height_mm"),
            Quantity::BaseX => f.write_str("base_x_mm"),
            Quantity::BaseY => f.write_str("base_y_mm"),
            Quantity::BaseTurn => f.write_str("base_deg"),
            Quantity::Preload => f.write_str("preload_nmm"),
            Quantity::Lean => f.write_str("lean_deg"),
        }
    }
}

impl Quantity {
    /// Whether the quantity is a factor on a modulus. Only measured forces determine a factor on a modulus, and the search varies the logarithm of
    /// the factor. For a quantity that is not a factor on a modulus, the search varies the change of the quantity.
    pub fn is_modulus(&self) -> bool {
        matches!(self, Quantity::Modulus | Quantity::PlateModulus(_))
    }

    /// Whether the quantity is a length of the finger.
    pub(super) fn is_length(&self) -> bool {
        matches!(
            self,
            Quantity::Bracket(_)
                | Quantity::OwnBracket(..)
                | Quantity::Clip
                | Quantity::PlateClip(_)
                | Quantity::RibPosition(..)
        )
    }

    /// Whether the quantity describes markers or base, not the finger.
    pub fn is_of_rig(&self) -> bool {
        matches!(self, Quantity::MarkerHeight | Quantity::BaseX | Quantity::BaseY | Quantity::BaseTurn)
    }
}

/// A sought quantity with its prior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sought {
    /// The quantity.
    pub quantity: Quantity,
    /// Prior standard deviation in the quantity's unit, relative for a factor. `None` without a prior.
    pub prior_sd: Option<f64>,
}

/// Changes one quantity of a finger's description: by the logarithm `change` for a factor, by `change` in mm for a length.
pub(super) fn changed(description: &mut FingerDescription, rib_count: usize, quantity: Quantity, change: f64) {
    match quantity {
        Quantity::Modulus => description.multiply_moduli(change.exp()),
        Quantity::PlateModulus(Plate::Front) => description.front.youngs_modulus_mpa *= change.exp(),
        Quantity::PlateModulus(Plate::Back) => description.back.youngs_modulus_mpa *= change.exp(),
        Quantity::Bracket(plate) => {
            let all = description.ribs.bracket_mm.all_mut();
            all.iter_mut().for_each(|lengths_mm| lengths_mm[plate.index()] += change);
        }
        Quantity::OwnBracket(plate, rib) => description.lengthen_bracket(rib_count, plate, rib, change),
        Quantity::Clip => description.ribs.clip_mm.iter_mut().for_each(|clip_mm| *clip_mm += change),
        Quantity::PlateClip(plate) => description.ribs.clip_mm[plate.index()] += change,
        Quantity::RibPosition(plate, rib) => {
            if let RibPositions::Positions(positions) = &mut description.ribs.positions
                && let Some(position) = positions.get_mut(rib)
            {
                position[plate.index()] += change;
            }
        }
        Quantity::MarkerHeight
        | Quantity::BaseX
        | Quantity::BaseY
        | Quantity::BaseTurn
        | Quantity::Preload
        | Quantity::Lean => {}
    }
}
