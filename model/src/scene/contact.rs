//! How objects meet the finger: `[contact]`.

use super::SceneError;
use super::object::{LARGEST_FRICTION, ROD_RADIUS_MM};
use super::reader::TableReader;
use crate::finger::{Finger, Plate};
use crate::sensing::{Lean, Normal, Pad};

/// All keys of `[contact]`.
pub(super) const KEYS: [&str; 11] = [
    "rod_radius_mm",
    PAD,
    PAD_LENGTH,
    FRICTION,
    "friction_sigma",
    "friction_range",
    "friction_build_up_n",
    "normal",
    "normal_over_mm",
    FORCE_ERROR,
    "object",
];
const PAD: &str = "pad_mm";
const PAD_LENGTH: &str = "pad_length_mm";
const FORCE_ERROR: &str = "force_error_share";
const FRICTION: &str = "friction";
/// Keys that say more of a friction that is stated.
const FURTHER: [&str; 4] = ["friction_sigma", "friction_build_up_n", "normal", "normal_over_mm"];

/// What an object meets, and how a contact force leans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactDescription {
    /// Radius of the rods that an object meets, mm.
    pub rod_radius_mm: f64,
    /// By how much friction turns a force that is sensed, where the scene says so.
    pub lean: Option<Lean>,
    /// Share by which sensed forces err beyond what is known otherwise: standard deviation.
    pub force_error: f64,
    /// What lies between an object and the front plate where forces are sensed.
    pub pad: Pad,
}

impl Default for ContactDescription {
    fn default() -> ContactDescription {
        ContactDescription { rod_radius_mm: ROD_RADIUS_MM, lean: None, force_error: 0.0, pad: Pad::default() }
    }
}

pub(super) fn read_contact(table: &TableReader, finger: &Finger) -> Result<ContactDescription, SceneError> {
    let rod_radius_mm =
        if table.has("rod_radius_mm") { super::not_negative_mm(table, "rod_radius_mm")? } else { ROD_RADIUS_MM };
    let lean = match (table.has(FRICTION), table.has("friction_range")) {
        (true, true) => return Err(table.wrong("friction_range", "either friction or friction_range", "both")),
        (true, false) => Some(read_friction(table)?),
        (false, true) => {
            let range: [f64; 2] =
                table.numbers("friction_range", "the least and the largest coefficient of friction")?;
            if range[0] > range[1] || range.iter().any(|coefficient| coefficient.abs() > LARGEST_FRICTION) {
                let expected = format!("two coefficients of friction in rising order, {}", limits());
                return Err(table.wrong("friction_range", &expected, &format!("{range:?}")));
            }
            Some(Lean::within(range))
        }
        (false, false) => None,
    };
    let force_error = not_negative(table, FORCE_ERROR, 1.0)?;
    let pad_mm = |key| match table.has(key) {
        true => super::not_negative_mm(table, key),
        false => Ok(0.0),
    };
    let pad = Pad { length_mm: pad_mm(PAD_LENGTH)?, thickness_mm: pad_mm(PAD)? };
    let plate_mm = finger.plate_length_mm(Plate::Front);
    for (key, length_mm) in [(PAD_LENGTH, pad.length_mm), (PAD, pad.thickness_mm)] {
        if length_mm > plate_mm {
            let expected = format!("a length in mm, no more than the front plate's {plate_mm}");
            return Err(table.wrong(key, &expected, &format!("{length_mm:?}")));
        }
    }
    match (lean, FURTHER.iter().find(|key| table.has(key))) {
        (None, Some(key)) => {
            Err(table.missing(FRICTION, &format!("a coefficient of friction (or friction_range), as `{key}` is there")))
        }
        (None, None) => Ok(ContactDescription { rod_radius_mm, lean: None, force_error, pad }),
        (Some(lean), _) => {
            Ok(ContactDescription { rod_radius_mm, lean: Some(read_further(table, lean)?), force_error, pad })
        }
    }
}

fn limits() -> String {
    format!("-{LARGEST_FRICTION} to {LARGEST_FRICTION}, positive towards the tip")
}

fn read_friction(table: &TableReader) -> Result<Lean, SceneError> {
    let friction = table.number(FRICTION, "coefficient of friction")?;
    if !(-LARGEST_FRICTION..=LARGEST_FRICTION).contains(&friction) {
        return Err(table.wrong(
            FRICTION,
            &format!("a coefficient of friction, {}", limits()),
            &format!("{friction:?}"),
        ));
    }
    let sigma = not_negative(table, "friction_sigma", LARGEST_FRICTION)?;
    Ok(Lean::of_friction(friction, sigma))
}

fn read_further(table: &TableReader, lean: Lean) -> Result<Lean, SceneError> {
    let from = match table.has("normal") {
        false => true,
        true => table.choice("normal", &[("deformed", true), ("undeformed", false)])?,
    };
    let over_mm = not_negative(table, "normal_over_mm", f64::MAX)?;
    let from = match from {
        true => Normal::Deformed { over_mm },
        false if table.has("normal_over_mm") => {
            let expected = "nothing: an undeformed plate has one normal";
            return Err(table.wrong("normal_over_mm", expected, &format!("{over_mm:?}")));
        }
        false => Normal::Undeformed,
    };
    Ok(Lean { build_up_n: not_negative(table, "friction_build_up_n", f64::MAX)?, from, ..lean })
}

/// A number from zero to a limit; zero if it is not there.
fn not_negative(table: &TableReader, key: &str, most: f64) -> Result<f64, SceneError> {
    let value = table.optional_number(key, "number")?.unwrap_or(0.0);
    match (0.0..=most).contains(&value) {
        true => Ok(value),
        false if most < LARGEST_FRICTION => Err(table.wrong(key, "a share from 0 to 1", &format!("{value:?}"))),
        false => Err(table.wrong(key, "a finite number, zero or more", &format!("{value:?}"))),
    }
}
