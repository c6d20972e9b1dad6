//! What a scene states and views may show better.

use crate::finger::{FingerDescription, Plate, RibPositions};
use std::fmt;

/// Something that a scene states and that several views may show better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Factor on all moduli.
    Modulus,
    /// Factor on the modulus of a plate.
    PlateModulus(Plate),
    /// Length of the brackets on a plate, mm.
    Bracket(Plate),
    /// How much longer the bracket of a rib, counted from 0, is on a plate than the scene has it, mm.
    OwnBracket(Plate, usize),
    /// Length of the clips on both plates, mm.
    Clip,
    /// Length of the clips on a plate, mm.
    PlateClip(Plate),
    /// Where a rib, counted from 0, is along a plate, mm.
    RibPosition(Plate, usize),
    /// Height of the markers above the plane of the beams, mm.
    MarkerHeight,
    /// Where the finger is in the frame that a view has of its base, mm.
    BaseX,
    /// The same along y.
    BaseY,
    /// The same for its turn, degrees.
    BaseTurn,
    /// Moment at the tip that the plates exert on each other without load, N mm.
    Preload,
    /// An error that the scene states of its unloaded finger, counted from 0, in standard deviations.
    Unloaded(usize),
}

/// As in results: `modulus_factor`, `front_bracket_mm`, `back_rib_3_mm`.
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
            Quantity::Unloaded(k) => write!(f, "unloaded_error_{}", k + 1),
        }
    }
}

impl Quantity {
    /// Whether it is a factor on a modulus: its logarithm is sought, and only measured forces show it. Otherwise it is a length or an angle, whose change is
    /// sought.
    pub fn is_modulus(&self) -> bool {
        matches!(self, Quantity::Modulus | Quantity::PlateModulus(_))
    }

    /// Its step for derivatives: that of a factor, a length or an angle, or an error.
    pub(super) fn step(&self, [share, length, sigma]: [f64; 3]) -> f64 {
        match self {
            Quantity::Modulus | Quantity::PlateModulus(_) => share,
            Quantity::Unloaded(_) => sigma,
            _ => length,
        }
    }

    /// Whether it belongs to the rig before the camera.
    pub fn is_of_rig(&self) -> bool {
        matches!(self, Quantity::MarkerHeight | Quantity::BaseX | Quantity::BaseY | Quantity::BaseTurn)
    }
}

/// A quantity that is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sought {
    /// Which.
    pub quantity: Quantity,
    /// How well the scene has it, if that is known: standard deviation in the quantity's unit, of a factor in parts of it.
    pub prior_sd: Option<f64>,
}

/// A description with one quantity changed.
pub(super) fn changed(description: &mut FingerDescription, rib_count: usize, quantity: Quantity, change: f64) {
    match quantity {
        Quantity::Modulus => {
            description.front.youngs_modulus_mpa *= change.exp();
            description.back.youngs_modulus_mpa *= change.exp();
            if let Some(strip) = &mut description.ribs.strip {
                strip.youngs_modulus_mpa *= change.exp();
            }
        }
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
        | Quantity::Unloaded(_) => {}
    }
}
