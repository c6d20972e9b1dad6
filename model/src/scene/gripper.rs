//! The gripper's linkage: `[gripper]`.

use super::SceneError;
use super::reader::TableReader;
use crate::gripper::{Assembly, Gripper, GripperDescription};

/// All keys of `[gripper]`.
pub(super) const KEYS: [&str; 5] = ["screw_pitch_mm", "slider_mm", "link_mm", "fixed_joint_mm", "assembly"];

/// Largest length, mm.
const LARGEST_MM: f64 = 1e4;

pub(super) fn read_gripper(table: &TableReader) -> Result<Gripper, SceneError> {
    let length = |key: &str, value: f64| {
        let found = format!("{value:?}");
        let expected = format!("a length in mm above zero, up to {LARGEST_MM}");
        let is_length = value.is_normal() && 0.0 < value && value <= LARGEST_MM;
        if is_length { Ok(value) } else { Err(table.wrong(key, &expected, &found)) }
    };
    let slider_mm = table.number("slider_mm", "length in mm")?;
    if slider_mm.is_nan() || slider_mm.abs() > LARGEST_MM {
        let expected = format!("a height in mm, up to {LARGEST_MM} either way");
        return Err(table.wrong("slider_mm", &expected, &format!("{slider_mm:?}")));
    }
    let link_mm: [f64; 2] = table.numbers("link_mm", "lengths in mm")?;
    for link_mm in link_mm {
        length("link_mm", link_mm)?;
    }
    let assembly = match table.has("assembly") {
        true => table.choice("assembly", &[("outer", Assembly::Outer), ("inner", Assembly::Inner)])?,
        false => Assembly::default(),
    };
    let description = GripperDescription {
        screw_pitch_mm: length("screw_pitch_mm", table.number("screw_pitch_mm", "length in mm")?)?,
        slider_mm,
        link_mm,
        fixed_joint_mm: length("fixed_joint_mm", table.number("fixed_joint_mm", "length in mm")?)?,
        assembly,
    };
    Gripper::new(description).map_err(|impossible| table.at("link_mm", &format!("link_mm: {impossible}")))
}
