//! Reading of the object of known shape that touches the plate while forces are sensed: the table `[contact.object]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::keys::TOUCHED;
use crate::sensing::{TouchedObject, TouchedOutline};
use nalgebra::Isometry2;

/// An object of known shape that touches the front plate.
#[derive(Debug, Clone, PartialEq)]
pub struct TouchedDescription {
    /// Outline of the object.
    pub shape: TouchedOutline,
    /// Pose of the object with its uncertainty; `None` if the scene does not state it.
    pub place: Option<ObjectPlace>,
}

/// Pose of an object with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectPlace {
    /// Pose of the outline: position of its origin (mm) and rotation (rad).
    pub pose: Isometry2<f64>,
    /// Standard deviation of each coordinate of the origin, mm.
    pub sd_mm: f64,
    /// Standard deviation of the rotation, rad.
    pub sd_rad: f64,
    /// Frame to which the pose refers.
    pub frame: ObjectFrame,
}

/// Frame to which an object's pose refers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObjectFrame {
    /// The finger frame. It moves with the base, so the pose of this frame is the base's pose in the image.
    Base,
    /// The reference frame of the camera's pose. The base moves within this frame between images.
    Plane,
}

impl TouchedDescription {
    /// Expresses the object in the finger frame of one measurement. `base` is the pose of the base in the reference frame of the camera's pose. Returns `None`
    /// if the object's pose is unknown.
    pub fn seen_from(&self, base: &Isometry2<f64>) -> Option<TouchedObject> {
        let ObjectPlace { pose, sd_mm, sd_rad, frame } = self.place?;
        let pose = match frame {
            ObjectFrame::Base => pose,
            ObjectFrame::Plane => base.inverse() * pose,
        };
        Some(TouchedObject { shape: self.shape.clone(), pose, sd_mm, sd_rad })
    }
}

pub(super) fn read_touched(table: &TableReader) -> Result<TouchedDescription, SceneError> {
    let shape = read_shape(table)?;
    let of_pose =
        [TOUCHED.pose_sigma_mm.name, TOUCHED.rotation_deg.name, TOUCHED.rotation_sigma_deg.name, TOUCHED.frame.name];
    let place = match (table.optional(&TOUCHED.pose_mm)?, table.first_of(&of_pose)) {
        (Some(pose_mm), _) => Some(read_place(table, &shape, pose_mm)?),
        (None, Some(name)) => {
            return Err(table.missing(TOUCHED.pose_mm.name, &format!("[x, y] in mm, because the table has `{name}`")));
        }
        (None, None) => None,
    };
    Ok(TouchedDescription { shape, place })
}

/// Function that reads the keys of one type of outline.
type ShapeReader = fn(&TableReader) -> Result<TouchedOutline, SceneError>;

fn read_shape(table: &TableReader) -> Result<TouchedOutline, SceneError> {
    let disc: ShapeReader = |table| Ok(TouchedOutline::Disc { radius_mm: table.get(&TOUCHED.radius_mm)? });
    let ellipse: ShapeReader = |table| Ok(TouchedOutline::Ellipse { semi_axes_mm: table.get(&TOUCHED.semi_axes_mm)? });
    let polygon: ShapeReader = |table| {
        let corners = table.get(&TOUCHED.corners_mm)?.into_iter().map(Vector::from).collect();
        TouchedOutline::polygon(corners)
            .map_err(|error| table.wrong(TOUCHED.corners_mm.name, &error.to_string(), "others"))
    };
    table.shape(&TOUCHED, &TOUCHED.shape, [disc, ellipse, polygon])?(table)
}

fn read_place(table: &TableReader, shape: &TouchedOutline, pose_mm: [f64; 2]) -> Result<ObjectPlace, SceneError> {
    let turned = table.first_of(&[TOUCHED.rotation_deg.name, TOUCHED.rotation_sigma_deg.name]);
    if let Some(name) = turned.filter(|_| shape.is_round()) {
        return Err(table.not_of(name, "a disc"));
    }
    Ok(ObjectPlace {
        pose: Isometry2::new(Vector::from(pose_mm), table.get(&TOUCHED.rotation_deg)?.to_radians()),
        sd_mm: table.get(&TOUCHED.pose_sigma_mm)?,
        sd_rad: table.get(&TOUCHED.rotation_sigma_deg)?.to_radians(),
        frame: table.word(&TOUCHED.frame, [ObjectFrame::Base, ObjectFrame::Plane])?,
    })
}
