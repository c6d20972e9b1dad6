//! Reading of the gripper's linkage: the table `[gripper]`.

use super::SceneError;
use super::reader::TableReader;
use crate::gripper::{Assembly, Gripper, GripperDescription};
use crate::keys::GRIPPER;

pub(super) fn read_gripper(table: &TableReader) -> Result<Gripper, SceneError> {
    let description = GripperDescription {
        screw_pitch_mm: table.get(&GRIPPER.screw_pitch_mm)?,
        slider_mm: table.get(&GRIPPER.slider_mm)?,
        link_mm: table.get(&GRIPPER.link_mm)?,
        fixed_joint_mm: table.get(&GRIPPER.fixed_joint_mm)?,
        assembly: table.word(&GRIPPER.assembly, [Assembly::Outer, Assembly::Inner])?,
    };
    Gripper::new(description).map_err(|impossible| table.at(GRIPPER.link_mm.name, &impossible.to_string()))
}
