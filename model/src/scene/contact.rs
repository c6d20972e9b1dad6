//! Reading of the contacts between objects and the finger: the table `[contact]`.

use super::SceneError;
use super::reader::TableReader;
use crate::finger::{Finger, Plate};
use crate::keys::{CONTACT, Key, Number, ROD_RADIUS_MM};
use crate::sensing::{ContactPosition, Lean, Normal, Pad};

/// Properties of contacts between objects and the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactDescription {
    /// Radius of the rods on the front plate that objects touch, mm.
    pub rod_radius_mm: f64,
    /// Lean of sensed forces: their angle from the plate normal, caused by friction. `None` if the scene states no friction.
    pub lean: Option<Lean>,
    /// Plate normal from which the lean (angle between force and normal) is measured, also in the calibration of friction.
    pub normal: Normal,
    /// Relative standard deviation of a sensed force from causes that are not modelled otherwise, dimensionless.
    pub force_error: f64,
    /// Pad between objects and the front plate, on whose surface every sensed force acts; `None` if the scene states no pad.
    pub pad: Option<Pad>,
}

impl Default for ContactDescription {
    fn default() -> ContactDescription {
        ContactDescription {
            rod_radius_mm: ROD_RADIUS_MM,
            lean: None,
            normal: Lean::NONE.from,
            force_error: 0.0,
            pad: None,
        }
    }
}

impl ContactDescription {
    /// The surface that an object touches on a finger without pad: of the rod at a node, if it stands out from the plate, and otherwise of the plate.
    pub fn bare_surface(&self, finger: &Finger, position: Option<ContactPosition>) -> Pad {
        let stands_out_mm = match position {
            Some(ContactPosition::Node(node)) => {
                let s_mm = finger.front_position_mm(node).unwrap_or_default();
                (self.rod_radius_mm - 0.5 * finger.thickness_mm(Plate::Front, s_mm)).max(0.0)
            }
            _ => 0.0,
        };
        Pad { length_mm: 0.0, thickness_mm: stands_out_mm }
    }
}

pub(super) fn read_contact(table: &TableReader, finger: &Finger) -> Result<ContactDescription, SceneError> {
    let length_mm = finger.plate_length_mm(Plate::Front);
    let on_plate_mm = |key: &Key<Number>| match table.optional(key)? {
        Some(too_long) if too_long > length_mm => {
            let expected = format!("a length in mm, at most the front plate's {length_mm}");
            Err(table.wrong(key.name, &expected, &format!("{too_long:?}")))
        }
        pad_mm => Ok(pad_mm),
    };
    let pad = match (on_plate_mm(&CONTACT.pad_length_mm)?, on_plate_mm(&CONTACT.pad_mm)?) {
        (None, None) => None,
        (length_mm, pad_mm) => {
            Some(Pad { length_mm: length_mm.unwrap_or_default(), thickness_mm: pad_mm.unwrap_or_default() })
        }
    };
    let normal = read_normal(table)?;
    Ok(ContactDescription {
        rod_radius_mm: table.get(&CONTACT.rod_radius_mm)?,
        lean: read_lean(table, normal)?,
        normal,
        force_error: table.get(&CONTACT.force_error_share)?,
        pad,
    })
}

fn read_lean(table: &TableReader, from: Normal) -> Result<Option<Lean>, SceneError> {
    let range_name = CONTACT.friction_range.name;
    let lean = match (table.optional(&CONTACT.friction)?, table.optional(&CONTACT.friction_range)?) {
        (Some(_), Some(_)) => return Err(table.wrong(range_name, "either friction or friction_range", "both")),
        (Some(friction), None) => Lean::of_friction(friction, table.get(&CONTACT.friction_sigma)?),
        (None, Some(range)) if range[0] > range[1] => {
            let expected = "two coefficients of friction in ascending order";
            return Err(table.wrong(range_name, expected, &format!("{range:?}")));
        }
        (None, Some(range)) => Lean::within(range),
        (None, None) => {
            return match table.first_of(&[CONTACT.friction_sigma.name, CONTACT.friction_build_up_n.name]) {
                Some(name) => {
                    let expected =
                        format!("a coefficient of friction (or friction_range), because the table has `{name}`");
                    Err(table.missing(CONTACT.friction.name, &expected))
                }
                None => Ok(None),
            };
        }
    };
    Ok(Some(Lean { build_up_n: table.get(&CONTACT.friction_build_up_n)?, from, ..lean }))
}

fn read_normal(table: &TableReader) -> Result<Normal, SceneError> {
    let over_mm = table.get(&CONTACT.normal_over_mm)?;
    match table.word(&CONTACT.normal, [true, false])? {
        true => Ok(Normal::Deformed { over_mm }),
        false if table.has(&CONTACT.normal_over_mm) => {
            let expected = "no value with normal = \"undeformed\", because only the deformed normal is averaged";
            Err(table.wrong(CONTACT.normal_over_mm.name, expected, &format!("{over_mm:?}")))
        }
        false => Ok(Normal::Undeformed),
    }
}
